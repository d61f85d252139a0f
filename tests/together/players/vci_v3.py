"""A .NET program of VCI V3."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import canwire
from canwire import vci
from canwire.vci import v3
from tests.together.players.player import OTHER_RATE, RATE, Player
from tests.together.players.vci_v4 import VciV4
from tests.vci.v3.programs import BOTH, NetProgram, Port

_RATES = {RATE: v3.CanBitrate.CIA_250_KBIT, OTHER_RATE: v3.CanBitrate.CIA_500_KBIT}


class VciV3(Player):
    kind = "vci v3"
    shows = vci.VciError
    name_of = VciV4.name_of

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._program = NetProgram(hub)
        self._control: Any = None
        self._socket: Any = None
        self._port: Port | None = None

    def join(self) -> str:
        return self.tell(self._join)

    def _join(self) -> None:
        self._socket = self._program.open(v3.CanSocket, 0, self.board.hardware_id)
        self._port = self._program.port(0, self.board.hardware_id)

    def set_up(self) -> str:
        return self.tell(lambda: (self._configure(RATE), self._join()))

    def set_rate(self, rate: int) -> str:
        return self.tell(lambda: self._configure(rate))

    def _configure(self, rate: int) -> None:
        self._opened().init_line(BOTH | v3.CanOperatingModes.ERR_FRAME, _RATES[rate])
        self._opened().start_line()

    def take_control(self) -> str:
        return self.tell(self._opened)

    def stop(self) -> str:
        return self.tell(lambda: self._opened().stop_line())

    def reset(self) -> str:
        return self.tell(lambda: self._opened().reset_line())

    def recover(self) -> str:
        def again() -> None:
            self._opened().stop_line()
            self._opened().start_line()

        return self.tell(again)

    def _opened(self) -> Any:
        if self._control is None:
            self._control = self._program.open(v3.CanControl, 0, self.board.hardware_id)
        return self._control

    def send(self, identifier: int) -> str:
        message = v3.CanMessage()
        message.identifier = identifier
        return self.tell(lambda: self._opened_port().send(message))

    def received(self) -> list[int]:
        return [one.identifier for one in self._opened_port().waiting()]

    def told(self) -> set[str]:
        words = set()
        for one in self._opened_port().waiting(None):
            information = one.frame_type == v3.CanMsgFrameType.INFO
            words.add(v3.CanMsgInfoValue(one[0]).name if information else one.frame_type.name)
        return words - {"DATA"}

    def narrow(self) -> str:
        def choose() -> None:
            control = self._opened()
            control.stop_line()
            control.set_acc_filter(v3.CanFilter.STD, 0x200 << 1, 0x700 << 1)
            control.start_line()

        return self.tell(choose)

    def state(self) -> str:
        return self.tell(self._state)

    def _state(self) -> str:
        status = self._socket.line_status
        if status.is_mode_undefined:
            return "IsModeUndefined"
        if status.is_bus_off:
            return "IsBusOff"
        return "IsInInitMode" if status.is_in_init_mode else "on the bus"

    def _opened_port(self) -> Port:
        assert self._port is not None
        return self._port

    def end(self) -> None:
        with suppress(vci.VciError, canwire.HubLost):
            self._program.close()
        self.hub.close()
