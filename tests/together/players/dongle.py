"""The host of an emulated CANBUS dongle: its board is its own, and others may be on that board's line as well."""

from __future__ import annotations

import canwire
from canwire.slcan import Dongle, HubPort
from tests.together.players.player import DONE, OTHER_RATE, RATE, Player

BELL = "BELL"
_STATES = {DONE: "open", BELL: "closed"}
_FLAGS = {0x04: "EI", 0x20: "EPI", 0x40: "ALI", 0x80: "BEI"}
_RATES = {RATE: b"S5\r", OTHER_RATE: b"S6\r"}


class DongleHost(Player):
    kind = "dongle host"

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._port: HubPort | None = None
        self._dongle: Dongle | None = None
        self._came: list[int] = []
        self._flags = 0

    def _plug(self) -> None:
        if self._port is None:
            self._port = HubPort(self.hub, self.board)
            self._dongle = Dongle(self._port, self._port.now_ns)

    def _ask(self, *lines: bytes) -> str:
        """DONE, or BELL if one of them was refused, or how its port ended; frames that come meanwhile are kept."""
        return self.tell(lambda: self._told(*lines))

    def _told(self, *lines: bytes) -> str:
        assert self._dongle is not None
        self._dongle.pump()
        text = b""
        for line in lines:
            self._dongle.feed(line)
            text += bytes(self._dongle.output)
            self._dongle.written(len(self._dongle.output))
        self._flags = next((int(one[1:], 16) for one in text.split(b"\r") if one[:1] == b"F"), 0)
        self._came += [int(one[1:4], 16) for one in text.split(b"\r") if one[:1] == b"t"]
        return BELL if b"\x07" in text else DONE

    def join(self) -> str:
        """Its adapter is plugged in where somebody else is: that board cannot be its own."""
        return self.tell(self._plug)

    def set_up(self) -> str:
        told = self.join()
        return told if told != DONE else self._ask(_RATES[RATE], b"O\r")

    def set_rate(self, rate: int) -> str:
        """Only a closed channel takes another rate."""
        return self._ask(_RATES[rate])

    def stop(self) -> str:
        return self._ask(b"C\r")

    def recover(self) -> str:
        return self._ask(b"C\r", b"O\r")

    def send(self, identifier: int) -> str:
        return self._ask(b"t%03x0\r" % identifier)

    def received(self) -> list[int]:
        self._ask(b"")
        came, self._came = self._came, []
        return came

    def told(self) -> set[str]:
        """The flags of F since it was read last, but for those of its queues; what a closed channel answers is none."""
        self._ask(b"F\r")
        return {name for bit, name in _FLAGS.items() if self._flags & bit}

    def narrow(self) -> str:
        """Both filters of its controller's dual mode: bits 10..8 of the identifier are ACR0's bits 7..5."""
        return self._ask(b"C\r", b"M40004000\r", b"m1FFF1FFF\r", _RATES[RATE], b"O\r")

    def state(self) -> str:
        return _STATES.get(told := self._ask(b"F\r"), told)

    def end(self) -> None:
        if self._port is not None:
            self._port.end()
        self.hub.close()
