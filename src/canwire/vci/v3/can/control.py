"""ICanControl: the control unit of a line.

Source: VCI V3 .NET manual 4.2.4; reference/vci.md section 7a; rulings.md 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar
from uuid import UUID

from canwire.vci.arguments import UINT8, UINT16
from canwire.vci.can import control as can_control
from canwire.vci.can.structures import CanBtrTable, CanInitLine
from canwire.vci.structures.constants import CAN_BTR_TABLE_SIZE, CAN_OPMODE_AUTOBAUD, CAN_OPMODE_STANDARD
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VCI_E_TIMEOUT, VciTimeout
from canwire.vci.structures.guids import IID_ICanControl
from canwire.vci.v3.bus_socket import ControlSocket
from canwire.vci.v3.can.bitrate import CanBitrate
from canwire.vci.v3.can.enums import CanOperatingModes
from canwire.vci.v3.can.socket import CanSocket
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ArgumentException, VciException, checked

_NOTHING_HEARD = -1


class CanControl(ControlSocket, CanSocket):
    """ICanControl. One program at a time may have it.

    Undefined -> `init_line` or `detect_baud` -> offline -> `start_line` -> online -> `stop_line` or `reset_line`
    -> offline. Calls that are wrong in a state raise VciException. Disposed, it leaves the line as it is for as long
    as anything else is open on the line. Of what ICanControl2 had set up, mode and bit rate stay through
    `reset_line`, as far as registers can express it; otherwise the line is not initialised then.
    """

    _control_iid: ClassVar[UUID] = IID_ICanControl
    _control: can_control.CanControl

    @net_call
    def detect_baud(self, timeout_ms: int, bitrates: Sequence[CanBitrate]) -> int:
        """DetectBaud: index of the bit rate that the running bus speaks, -1 if nothing is heard; only listens.

        `timeout_ms` 1 to 65535 for each of the bit rates. A line that was not initialised is offline then, with
        the bit rate found and all frame formats that it has.
        Raises VciException while the line is started and for no timeout, ArgumentException for no bit rates.
        """
        if not bitrates:
            raise ArgumentException(VCI_E_INVALIDARG, "no bit rates to try")
        if checked("timeout_ms", timeout_ms, UINT16) == 0:
            raise VciException(VCI_E_TIMEOUT, "a bus needs more than 0 ms to be heard")
        for start in range(0, len(bitrates), CAN_BTR_TABLE_SIZE):
            index = self._detect(timeout_ms, bitrates[start : start + CAN_BTR_TABLE_SIZE])
            if index != _NOTHING_HEARD:
                self._leave_undefined(bitrates[start + index])
                return start + index
        return _NOTHING_HEARD

    @net_call
    def init_line(self, operating_mode: int, bitrate: CanBitrate) -> None:
        """InitLine: reset the line and set it up; it is offline then, and all messages pass its filters.

        `operating_mode` STANDARD, EXTENDED or both, with ERR_FRAME, LISTEN_ONLY and LOW_SPEED as wanted.
        Raises VciException naming the feature that the line lacks.
        """
        mode = checked("operating_mode", int(operating_mode), UINT8)
        if mode & CAN_OPMODE_AUTOBAUD:
            raise ArgumentException(VCI_E_INVALIDARG, f"operating_mode {mode:#x}: CanOperatingModes")
        self._control.init_line(CanInitLine(mode, 0, bitrate.btr0, bitrate.btr1))

    @net_call
    def set_acc_filter(self, select: int, code: int, mask: int) -> None:
        """SetAccFilter: the first stage of a CanFilter, one pattern of identifier << 1 | RTR; a mask bit of 1 compares.

        CanAccCode.ALL and CanAccMask.ALL let all through, CanAccCode.NONE and CanAccMask.NONE none. Like the next
        two only offline, else VciException.
        """
        self._control.set_acc_filter(select, code, mask)

    @net_call
    def add_filter_ids(self, select: int, code: int, mask: int) -> None:
        """AddFilterIds: put all that agrees with the pattern on the second stage's list, of up to 4096 entries."""
        self._control.add_filter_ids(select, code, mask)

    @net_call
    def rem_filter_ids(self, select: int, code: int, mask: int) -> None:
        """RemFilterIds: take all that agrees with the pattern off that list."""
        self._control.rem_filter_ids(select, code, mask)

    def _detect(self, timeout_ms: int, bitrates: Sequence[CanBitrate]) -> int:
        table = CanBtrTable(
            count=len(bitrates),
            btr0=bytes(rate.btr0 for rate in bitrates),
            btr1=bytes(rate.btr1 for rate in bitrates),
        )
        try:
            return self._control.detect_baud(timeout_ms, table).index
        except VciTimeout:
            return _NOTHING_HEARD

    def _leave_undefined(self, bitrate: CanBitrate) -> None:
        if self._control.get_line_status().op_mode == CanOperatingModes.UNDEFINED:
            both = self.supports_std_and_ext_frames
            mode = CanOperatingModes.MODE_MASK if both else CAN_OPMODE_STANDARD
            self._control.init_line(CanInitLine(int(mode), 0, bitrate.btr0, bitrate.btr1))

    def _settings(self) -> CanInitLine | None:
        status = self._control.get_line_status()
        if not status.op_mode or not (status.bt_reg0 or status.bt_reg1):
            return None
        return CanInitLine(status.op_mode & ~CAN_OPMODE_AUTOBAUD, 0, status.bt_reg0, status.bt_reg1)
