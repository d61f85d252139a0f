"""Programs on a LIN line: VCI V4, VCI V3, and `canwire lin dump`."""

from __future__ import annotations

from contextlib import suppress
from typing import Any, ClassVar

import canwire
from canwire import LinePlace, LinMonitorMode, vci
from canwire.commands.lin.line import Wish, begin_listening
from canwire.vci import v3
from tests.together.players.player import Player
from tests.together.players.vci_v4 import VciV4
from tests.vci.programs import LIN_LINE, Program
from tests.vci.v3.programs import NetProgram

RATE, OTHER_RATE = 19_200, 9_600


class LinV4(Player):
    """A slave that listens."""

    kind = "vci v4 lin"
    shows = vci.VciError
    name_of = VciV4.name_of

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._program = Program(hub)
        self._control: Any = None
        self._port: Any = None

    def join(self) -> str:
        return self.tell(self._join)

    def _join(self) -> None:
        self._port = self._program.monitor(self.board.hardware_id)

    def set_up(self) -> str:
        return self.tell(lambda: (self._configure(RATE), self._join()))

    def set_rate(self, rate: int) -> str:
        return self.tell(lambda: self._configure(rate))

    def _configure(self, rate: int) -> None:
        self._opened().init_line(vci.LinInitLine(op_mode=0, bitrate=rate))
        self._opened().start_line()

    def take_control(self) -> str:
        return self.tell(self._opened)

    def stop(self) -> str:
        return self.tell(lambda: self._opened().stop_line())

    def reset(self) -> str:
        return self.tell(lambda: self._opened().reset_line())

    def _opened(self) -> Any:
        if self._control is None:
            self._control = self._program.open(vci.IID_ILinControl, LIN_LINE, self.board.hardware_id)
        return self._control

    def received(self) -> list[int]:
        return [
            one.msg_info.pid & 0x3F
            for one in self._port.waiting()
            if one.msg_info.type == vci.LIN_MSGTYPE_DATA
        ]

    def state(self) -> str:
        def look() -> str:
            with self._program.bal(self.board.hardware_id).open_socket(LIN_LINE, vci.IID_ILinSocket) as one:
                status = one.get_line_status()
            if status.bitrate == vci.LIN_BITRATE_UNDEF:
                return "not set up"
            return "stopped" if status.status & vci.LIN_STATUS_ININIT else f"{status.bitrate} bit/s"

        return self.tell(look)

    def end(self) -> None:
        with suppress(vci.VciError, canwire.HubLost):
            self._program.close()
        self.hub.close()


class LinV3(LinV4):
    """The same in .NET's words."""

    kind = "vci v3 lin"
    _RATES: ClassVar = {RATE: v3.LinBitrate.LIN_19200_BIT, OTHER_RATE: v3.LinBitrate.LIN_9600_BIT}

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._net = NetProgram(hub)

    def _join(self) -> None:
        monitor = self._net.open(v3.LinMonitor, LIN_LINE, self.board.hardware_id)
        monitor.initialize(200, False)
        self._reader = self._net.keep(monitor.get_message_reader())
        monitor.activate()
        self._socket = self._net.open(v3.LinSocket, LIN_LINE, self.board.hardware_id)

    def _configure(self, rate: int) -> None:
        self._opened().init_line(v3.LinInitLine(v3.LinOperatingModes.SLAVE, self._RATES[rate]))
        self._opened().start_line()

    def _opened(self) -> Any:
        if self._control is None:
            self._control = self._net.open(v3.LinControl, LIN_LINE, self.board.hardware_id)
        return self._control

    def received(self) -> list[int]:
        found = []
        while (message := self._reader.read_message()) is not None:
            if message.message_type == v3.LinMessageType.DATA:
                found.append(message.prot_id & 0x3F)
        return found

    def state(self) -> str:
        def look() -> str:
            status = self._socket.line_status
            if status.bitrate == v3.LinBitrate.UNDEFINED:
                return "not set up"
            return "stopped" if status.is_in_init_mode else f"{status.bitrate.as_uint16} bit/s"

        return self.tell(look)

    def end(self) -> None:
        with suppress(vci.VciError, canwire.HubLost):
            self._net.close()
        super().end()


class LinVerb(Player):
    """`canwire lin dump`."""

    kind = "canwire lin"

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._place = LinePlace(board, LIN_LINE)
        self._monitor: Any = None

    def join(self) -> str:
        return self.tell(lambda: self._open(None))

    def set_up(self) -> str:
        return self.tell(lambda: self._open(RATE))

    def _open(self, rate: int | None) -> None:
        self._monitor = self.hub.open_monitor(self.board.id, LIN_LINE)
        self._monitor.set_up(LinMonitorMode(200))
        begin_listening(self.hub, self._place, Wish(False, rate))
        self._monitor.activate()

    def set_rate(self, rate: int) -> str:
        return self.tell(lambda: begin_listening(self.hub, self._place, Wish(False, rate)) and None)

    def received(self) -> list[int]:
        found = []
        while (message := self._monitor.receive(0)) is not None:
            if hasattr(message, "id"):
                found.append(message.id)
        return found

    def state(self) -> str:
        def look() -> str:
            status = self.hub.lin_status(self.board.id, LIN_LINE).status
            if not status.initialised:
                return "not set up"
            return f"{status.bit_rate} bit/s" if status.running else "stopped"

        return self.tell(look)

    def end(self) -> None:
        self.hub.close()
