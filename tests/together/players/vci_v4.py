"""A VCI V4 program: ICanControl2 and ICanChannel2 where the line knows CAN FD, else ICanControl and ICanChannel."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import canwire
from canwire import vci
from tests.together.players.player import OTHER_RATE, RATE, Player
from tests.vci.programs import Port, Program

_CLASSIC = {RATE: (vci.CAN_BT0_250KB, vci.CAN_BT1_250KB), OTHER_RATE: (vci.CAN_BT0_500KB, vci.CAN_BT1_500KB)}
_FD = {RATE: vci.CAN_BTP_250KB, OTHER_RATE: vci.CAN_BTP_500KB}
_BOTH = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED | vci.CAN_OPMODE_ERRFRAME
_INFOS = {getattr(vci, name): name for name in ("CAN_INFO_START", "CAN_INFO_STOP", "CAN_INFO_RESET")}
_TOLD = {vci.CAN_MSGTYPE_ERROR: "CAN_MSGTYPE_ERROR", vci.CAN_MSGTYPE_STATUS: "CAN_MSGTYPE_STATUS"}
_CODES = {
    getattr(vci, name): name
    for name in ("VCI_E_ACCESSDENIED", "VCI_E_DEVICE_NOT_CONNECTED", "VCI_E_INVALID_STATE")
}


class VciV4(Player):
    kind = "vci v4"
    shows = vci.VciError

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._fd = board.lines[0].capabilities.data is not None
        self._program = Program(hub)
        self._control: Any = None
        self._port: Port | None = None

    def name_of(self, error: Any) -> str:
        return _CODES.get(error.code, f"{error.code:#x}")

    def join(self) -> str:
        return self.tell(self._join)

    def _join(self) -> None:
        open_port = self._program.port if self._fd else self._program.old_port
        self._port = open_port(0, self.board.hardware_id)

    def set_up(self) -> str:
        return self.tell(lambda: (self._configure(RATE), self._join()))

    def set_rate(self, rate: int) -> str:
        return self.tell(lambda: self._configure(rate))

    def _configure(self, rate: int) -> None:
        control = self._opened()
        if self._fd:
            init = vci.CanInitLine2(
                op_mode=_BOTH, ex_mode=3, btp_sdr=_FD[rate], btp_fdr=vci.CAN_BTP_DBR_SL_2000KB
            )
            control.init_line(init)
        else:
            bt0, bt1 = _CLASSIC[rate]
            control.init_line(vci.CanInitLine(op_mode=_BOTH, bt_reg0=bt0, bt_reg1=bt1))
        control.start_line()

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
            iid = vci.IID_ICanControl2 if self._fd else vci.IID_ICanControl
            self._control = self._program.open(iid, 0, self.board.hardware_id)
        return self._control

    def send(self, identifier: int) -> str:
        made = vci.CanMsg2 if self._fd else vci.CanMsg
        return self.tell(lambda: self._opened_port().writer.put_data_entry(made(msg_id=identifier)))

    def received(self) -> list[int]:
        waiting = self._opened_port().waiting()
        return [one.msg_id for one in waiting if one.msg_info.type == vci.CAN_MSGTYPE_DATA]

    def told(self) -> set[str]:
        words = set()
        for one in self._opened_port().waiting():
            kind = one.msg_info.type
            words.add(_INFOS[one.data[0]] if kind == vci.CAN_MSGTYPE_INFO else _TOLD.get(kind, ""))
        return words - {""}

    def narrow(self) -> str:
        def choose() -> None:
            control = self._opened()
            control.stop_line()
            if self._fd:
                control.set_filter_mode(vci.CAN_FILTER_STD, vci.CAN_FILTER_INCL)
            control.set_acc_filter(vci.CAN_FILTER_STD, 0x200 << 1, 0x700 << 1)
            control.start_line()

        return self.tell(choose)

    def state(self) -> str:
        return self.tell(self._state)

    def _state(self) -> str:
        iid = vci.IID_ICanSocket2 if self._fd else vci.IID_ICanSocket
        with self._program.bal(self.board.hardware_id).open_socket(0, iid) as socket:
            status = socket.get_line_status()
        if not status.op_mode:
            return "CAN_OPMODE_UNDEFINED"
        if status.status & vci.CAN_STATUS_BUSOFF:
            return "CAN_STATUS_BUSOFF"
        return "CAN_STATUS_ININIT" if status.status & vci.CAN_STATUS_ININIT else "on the bus"

    def _opened_port(self) -> Port:
        assert self._port is not None
        return self._port

    def end(self) -> None:
        with suppress(vci.VciError, canwire.HubLost):
            self._program.close()
        self.hub.close()
