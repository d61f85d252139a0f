"""What goes on beside the programs for a life of the hub: a recorder, a gateway, the page with a viewer."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections import Counter
from pathlib import Path

import canwire
from soaking.crowd import PATIENCE_S, Running

_RATE = 500_000
_TIMING = canwire.BitTiming.for_bit_rate(_RATE, clock_hz=80_000_000)
_RECORDS, _FROM, _TO, _BEHIND = ("HW1A", 0), ("HW1B", 0), ("HW1B", 1), ("HW1A", 1)
_PAGE = Path(__file__).with_name("page.py")


class Services:
    """Started with a hub; `settle` ends them, and says what does not balance."""

    def __init__(self, hub: canwire.Hub, address: str, home: Path, done: Counter[str]) -> None:
        self._hub, self._address, self._home, self._done = hub, address, home, done
        self._log = home / "kept.log"
        self._behind = self._listening()
        self._recorder = self._canwire("record", *self._line(_RECORDS), str(self._log))
        self._gateway = self._canwire(
            "bridge", ":".join(map(str, _FROM)), ":".join(map(str, _TO)), "--one-way"
        )
        self._web = self._canwire("web", "--port", "0")
        address = self._web.line().partition(": ")[2]
        self._viewer = Running([sys.executable, str(_PAGE), address], home / "page.log", self._address)
        self._viewer.line()
        self._until_listening()

    def _until_listening(self) -> None:
        """Recorder and gateway have their lines: what is sent from now on is theirs."""
        ends = time.monotonic() + PATIENCE_S
        while not all(self._is_heard(place) for place in (_RECORDS, _FROM, _TO)):
            assert time.monotonic() < ends, "neither recorder nor gateway"
            time.sleep(0.1)

    def _is_heard(self, place: tuple[str, int]) -> bool:
        status = self._status(place)
        return status.running and status.channels > 0

    @property
    def stoppable(self) -> list[Running]:
        """Those that may be stopped for half a minute."""
        return [self._recorder, self._gateway, self._web, self._viewer]

    def settle(self) -> list[str]:
        """Nobody sends any more."""
        wrong = [*self._viewed(), *self._passed_on(), *self._recorded()]
        self._web.process.terminate()
        self._web.end()
        self._behind.close()
        return wrong

    def _viewed(self) -> list[str]:
        self._viewer.say("")
        told = json.loads(self._viewer.line())
        self._viewer.end()
        self._done["pages"] += told["pages"]
        self._done["messages of the page's socket"] += told["messages"]
        wrong = [f"page: {each}" for each in told["wrong"]]
        return wrong if told["messages"] else [*wrong, "page: nothing came by its socket"]

    def _recorded(self) -> list[str]:
        """Frames in the log and those that it counts as lost are what the line received."""
        self._interrupt(self._recorder)
        frames = lost = 0
        with canwire.open_log(self._log) as log:
            for entry in log:
                frames += isinstance(entry.content, canwire.Frame)
                if isinstance(entry.content, canwire.LogMark) and entry.content.kind == canwire.MarkKind.LOST:
                    lost += entry.content.count
            faults = log.faults
        self._log.unlink()
        received = self._status(_RECORDS).frames_received
        self._done["frames in the recorder's log"] += frames
        self._done["lost by the recorder, as it says"] += lost
        holds = frames <= received <= frames + lost and not faults
        return [] if holds else [f"recorder: {received} received, {frames} in the log, {lost} lost, {faults}"]

    def _passed_on(self) -> list[str]:
        """All that the gateway sent on was heard, and it sent what it received but for what it says."""
        self._interrupt(self._gateway)
        sent, heard = self._status(_TO).frames_sent, self._status(_BEHIND).frames_received
        received = self._status(_FROM).frames_received
        self._done["frames through the gateway"] += sent
        told = self._gateway.log.read_text()
        whole = received == sent or "lost" in told or "waiting" in told
        return (
            []
            if sent == heard and whole
            else [f"gateway: {received} in, {sent} out, {heard} heard: {told[-500:]}"]
        )

    def _interrupt(self, running: Running) -> None:
        running.process.send_signal(signal.SIGINT)
        running.process.wait(PATIENCE_S)
        running.end()

    def _status(self, place: tuple[str, int]) -> canwire.LineStatus:
        return self._hub.line_status(self._hub.board(place[0]).id, place[1])

    @staticmethod
    def _line(place: tuple[str, int]) -> list[str]:
        return [f"{place[0]}:{place[1]}"]

    def _listening(self) -> canwire.HubChannel:
        """Somebody on the other side of the gateway, who acknowledges."""
        board = self._hub.board(_BEHIND[0]).id
        with self._hub.open_control(board, _BEHIND[1]) as control:
            control.initialise(canwire.LineMode(_TIMING))
            control.start()
            channel = self._hub.open_channel(board, _BEHIND[1])
        channel.set_up(canwire.ChannelMode(16, 0))
        channel.activate()
        return channel

    def _canwire(self, verb: str, *words: str) -> Running:
        words = (verb, *words, "--hub", self._address)
        os.environ.setdefault("XDG_STATE_HOME", str(self._home))
        return Running([sys.executable, "-m", "canwire", *words], self._home / f"{verb}.log", self._address)
