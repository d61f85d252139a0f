"""The hub of the soak, and the honest program on a bus that nobody disturbs but by shorting it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import canwire

PATIENCE_S = 60.0
_TIMING = canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
_BUSES = Path(__file__).with_name("soak.toml")
_CLOCKED = Path(__file__).with_name("clocked.py")
BOARD = "HW0"


class Served:
    """`canwire serve`, and what it takes."""

    def __init__(self, home: Path) -> None:
        self.address = str(home / "soak.sock")
        words = ["serve", "--time", "real", "--config", str(_BUSES), "--socket", self.address]
        with (home / "hub.log").open("a") as log:
            self.process = subprocess.Popen(
                [sys.executable, str(_CLOCKED), *words], stdout=subprocess.PIPE, stderr=log, text=True
            )
        assert self.process.stdout is not None
        assert "canwire hub on" in self.process.stdout.readline()

    def own_kb(self) -> int:
        """Memory of its own; the rings that it shares with clients are theirs."""
        return self._told("RssAnon")

    def shared_kb(self) -> int:
        return self._told("RssShmem")

    def threads(self) -> int:
        return self._told("Threads")

    def descriptors(self) -> int:
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def end(self, number: int) -> int:
        self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)

    def _told(self, what: str) -> int:
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.split(f"{what}:")[1].split()[0])


class Honest:
    """Sends on one line of can1, receives on another, and counts; a new one for each hub."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.hub = canwire.connect(address, name="honest")
        self.board = self.hub.board(BOARD).id
        self.sending = self._line(0, canwire.ChannelMode(1, 256, frames=False))
        self.receiving = self._line(1, canwire.ChannelMode(65_536, 0))
        self.sent = self.got = 0

    def send(self) -> None:
        self.sending.send(canwire.Frame(0x10, self.sent.to_bytes(4, "little")), timeout=PATIENCE_S)
        self.sent += 1

    def exchange(self, count: int) -> None:
        """So many frames there."""
        for _ in range(count):
            self.send()
        self.collect()

    def collect(self) -> None:
        """Take what has come until all that was sent is there, in order."""
        while self.got < self.sent:
            frame = self.receiving.receive(PATIENCE_S)
            if frame is None:
                raise AssertionError(f"frame {self.got} of {self.sent} never came: {self.sending.status()}")
            if frame.id == 0x10 and not frame.extended:
                number = int.from_bytes(frame.data, "little")
                assert number == self.got, f"frame {number} came in place of {self.got}"
                self.got += 1

    def short(self) -> None:
        """The bus shorted for a moment, with frames on it: they come afterwards."""
        self.hub.short("can1", True)
        for _ in range(5):
            self.send()
        self.hub.short("can1", False)
        for line in (0, 1):
            self.hub.recover(self.board, line)
        self.collect()

    def balance(self) -> None:
        """sent = delivered + aborted + refused + pending; nothing lost."""
        self.collect()
        status = self.sending.status()
        assert status.sent == status.delivered + status.aborted + status.refused + status.pending, status
        assert status.delivered == self.sent, (status, self.sent)
        assert self.receiving.status().lost == 0

    def end(self, served: Served, number: int) -> None:
        """The hub goes first, and that is told."""
        served.end(number)
        began = time.monotonic()
        while True:
            try:
                self.hub.boards()
            except canwire.HubLost:
                break
            assert time.monotonic() - began < PATIENCE_S
        self.hub.close()

    def _line(self, line: int, mode: canwire.ChannelMode) -> canwire.HubChannel:
        with self.hub.open_control(self.board, line) as control:
            control.initialise(canwire.LineMode(_TIMING))
            control.start()
            channel = self.hub.open_channel(self.board, line)
        channel.set_up(mode)
        channel.activate()
        return channel
