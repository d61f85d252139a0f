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

    The states of a line: undefined -> `init_line` or `detect_baud` -> offline -> `start_line` -> online -> `stop_line`
    or `reset_line` -> offline. A call that is not allowed in a state raises VciException. After `dispose` the line
    stays as it is while another interface of the line is open. After `reset_line` a line that ICanControl2 configured
    keeps its mode and bit rate if the registers can express them; otherwise it is not initialised.
    """

    _control_iid: ClassVar[UUID] = IID_ICanControl
    _control: can_control.CanControl

    @net_call
    def detect_baud(self, timeout_ms: int, bitrates: Sequence[CanBitrate]) -> int:
        """DetectBaud: the index of the running bus's bit rate, -1 if no message is received. The line only listens.

        `timeout_ms` is 1 to 65535 for each bit rate. A line that was not initialised is then offline, with the bit rate
        found and all its frame formats.
        Raises VciException while the line is started and for a timeout of 0, ArgumentException for no bit rates.
        """
        if not bitrates:
            raise ArgumentException(VCI_E_INVALIDARG, "no bit rates to try")
        if checked("timeout_ms", timeout_ms, UINT16) == 0:
            raise VciException(VCI_E_TIMEOUT, "the detection needs a timeout of more than 0 ms")
        for start in range(0, len(bitrates), CAN_BTR_TABLE_SIZE):
            index = self._detect(timeout_ms, bitrates[start : start + CAN_BTR_TABLE_SIZE])
            if index != _NOTHING_HEARD:
                self._leave_undefined(bitrates[start + index])
                return start + index
        return _NOTHING_HEARD

    @net_call
    def init_line(self, operating_mode: int, bitrate: CanBitrate) -> None:
        """InitLine: reset the line and configure it; it is then offline, and all messages pass its filters.

        `operating_mode` is STANDARD, EXTENDED or both, optionally with ERR_FRAME, LISTEN_ONLY and LOW_SPEED.
        Raises VciException, which names the missing feature.
        """
        mode = checked("operating_mode", int(operating_mode), UINT8)
        if mode & CAN_OPMODE_AUTOBAUD:
            raise ArgumentException(VCI_E_INVALIDARG, f"operating_mode {mode:#x}: CanOperatingModes")
        self._control.init_line(CanInitLine(mode, 0, bitrate.btr0, bitrate.btr1))

    @net_call
    def set_acc_filter(self, select: int, code: int, mask: int) -> None:
        """SetAccFilter: the first stage of a CanFilter, a pattern of identifier << 1 | RTR.

        A 1 in the mask means that the bit is compared. All identifiers pass CanAccCode.ALL with CanAccMask.ALL, none
        passes CanAccCode.NONE with CanAccMask.NONE. Filters can be changed only offline, otherwise VciException.
        """
        self._control.set_acc_filter(select, code, mask)

    @net_call
    def add_filter_ids(self, select: int, code: int, mask: int) -> None:
        """AddFilterIds: add identifiers that match the pattern to the second stage, a list of up to 4096 entries."""
        self._control.add_filter_ids(select, code, mask)

    @net_call
    def rem_filter_ids(self, select: int, code: int, mask: int) -> None:
        """RemFilterIds: remove all identifiers that match the pattern from the list of the second stage."""
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
