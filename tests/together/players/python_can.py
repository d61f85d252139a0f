"""A python-can program, with CAN FD where the line knows it."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import can

import canwire
from canwire.python_can import CanwireBus
from tests.together.players.player import RATE, Player

_CLASSES = {
    0x2: "CAN_ERR_LOSTARB",
    0x4: "CAN_ERR_CRTL",
    0x8: "CAN_ERR_PROT",
    0x40: "CAN_ERR_BUSOFF",
    0x80: "CAN_ERR_BUSERROR",
}
"""Classes of its error frames, which are SocketCAN's."""


class PythonCan(Player):
    kind = "python-can"
    shows = can.CanError

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._bus: Any = None

    def join(self) -> str:
        return self.tell(lambda: self._open())

    def set_up(self) -> str:
        return self.tell(lambda: self._open(bitrate=RATE))

    def set_rate(self, rate: int) -> str:
        """A second bus object of this program that asks for that."""
        return self.tell(lambda: self._made(bitrate=rate).shutdown())

    def _open(self, **arguments: Any) -> None:
        self._bus = self._made(**arguments)

    def _made(self, **arguments: Any) -> Any:
        return CanwireBus(f"{self.board.hardware_id}:0", hub=self.hub, error_frames=True, **arguments)

    def recover(self) -> str:
        def again() -> None:
            self._bus.state = can.BusState.ACTIVE

        return self.tell(again)

    def send(self, identifier: int) -> str:
        message = can.Message(arbitration_id=identifier, is_extended_id=False)
        return self.tell(lambda: self._bus.send(message, timeout=0))

    def received(self) -> list[int]:
        found = []
        while (message := self._bus.recv(0)) is not None:
            if not message.is_error_frame:
                found.append(message.arbitration_id)
        return found

    def told(self) -> set[str]:
        found = set()
        while (message := self._bus.recv(0)) is not None:
            if message.is_error_frame:
                found |= {name for bit, name in _CLASSES.items() if message.arbitration_id & bit}
        return found

    def narrow(self) -> str:
        return self.tell(
            lambda: self._bus.set_filters([{"can_id": 0x200, "can_mask": 0x700, "extended": False}])
        )

    def state(self) -> str:
        return self.tell(lambda: self._bus.state.name)

    def end(self) -> None:
        if self._bus is not None:
            with suppress(can.CanError):
                self._bus.shutdown()
        self.hub.close()
