"""ICanControl and ICanControl2 of Ixxat.Vci4.

Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 5.2.3 and 6.6.4; rulings.md 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar
from uuid import UUID

from canwire.vci.arguments import UINT8, UINT16
from canwire.vci.can import control as can_control
from canwire.vci.can.structures import CanBtpPair, CanBtpTable, CanInitLine, CanInitLine2
from canwire.vci.net4.bitrate import CanBitrate2, CanFdBitrate
from canwire.vci.net4.enums import CanFilterModes, CanOperatingModes
from canwire.vci.net4.socket import CanSocket, CanSocket2
from canwire.vci.structures.constants import CAN_BTP_TABLE_SIZE, CAN_FILTER_SIZE_EXT, CAN_FILTER_SIZE_STD
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VCI_E_TIMEOUT, VciTimeout
from canwire.vci.structures.guids import IID_ICanControl2
from canwire.vci.v3.bus_socket import ControlSocket
from canwire.vci.v3.can import control as v3
from canwire.vci.v3.can.bitrate import CanBitrate
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ArgumentException, VciException, checked

_NOTHING_HEARD = -1


class CanControl(v3.CanControl, CanSocket):
    """ICanControl: the same as in V3, but it can also detect the bit rate (CanOperatingModes.AUTO_BAUDRATE)."""

    @net_call
    def init_line(self, operating_mode: int, bitrate: CanBitrate) -> None:
        """InitLine: the same as in V3; with AUTO_BAUDRATE it detects the bit rate, or raises VciException."""
        mode = checked("operating_mode", int(operating_mode), UINT8)
        self._control.init_line(CanInitLine(mode, 0, bitrate.btr0, bitrate.btr1))


class CanControl2(ControlSocket, CanSocket2):
    """ICanControl2: the control unit of a CAN FD line. One program at a time may have it.

    The states are the same as in ICanControl. After `reset_line` the line is offline, with the settings of `init_line`.
    """

    _control_iid: ClassVar[UUID] = IID_ICanControl2
    _control: can_control.CanControl2

    def _open_more(self) -> None:
        super()._open_more()
        self._init: CanInitLine2 | None = None

    @net_call
    def detect_baud(
        self, operating_mode: int, extended_mode: int, timeout_ms: int, bitrate_table: Sequence[CanFdBitrate]
    ) -> int:
        """DetectBaud: the index of the running bus's bit rates, -1 if no message is received. The line only listens.

        `operating_mode` is LOW_SPEED for that coupling, else 0; `extended_mode` is FAST_DATA_RATE to find the fast
        rate, too, with NON_ISO_CAN_FD on a bus with non-ISO frames; `timeout_ms` is 1 to 65535 for each entry.
        Raises VciException while the line is started and for a timeout of 0, ArgumentException for no bit rates.
        """
        if not bitrate_table:
            raise ArgumentException(VCI_E_INVALIDARG, "no bit rates to try")
        if checked("timeout_ms", timeout_ms, UINT16) == 0:
            raise VciException(VCI_E_TIMEOUT, "the detection needs a timeout of more than 0 ms")
        low_speed = int(operating_mode) & CanOperatingModes.LOW_SPEED
        for start in range(0, len(bitrate_table), CAN_BTP_TABLE_SIZE):
            some = bitrate_table[start : start + CAN_BTP_TABLE_SIZE]
            pairs = [CanBtpPair(one.std_bitrate.structure(), one.fast_bitrate.structure()) for one in some]
            table = CanBtpTable(count=len(pairs), btp=pairs)
            try:
                found = self._control.detect_baud(int(low_speed), int(extended_mode), timeout_ms, table)
            except VciTimeout:
                continue
            return start + found.index
        return _NOTHING_HEARD

    @net_call
    def init_line(
        self,
        operating_mode: int,
        extended_mode: int,
        filter_mode_std: int,
        cnt_ids_std: int,
        filter_mode_ext: int,
        cnt_ids_ext: int,
        bitrate: CanBitrate2,
        extended_bitrate: CanBitrate2,
    ) -> None:
        """InitLine: reset the line and configure it with its filters; it is offline afterwards.

        The modes are CanOperatingModes, CanExtendedOperatingModes, and CanFilterModes for 11 and for 29 bits, each with
        the number of identifiers in the list. Raises VciException, which names the missing feature or the rate or raw
        number that the line cannot make.
        """
        init = CanInitLine2(
            op_mode=checked("operating_mode", int(operating_mode), UINT8),
            ex_mode=checked("extended_mode", int(extended_mode), UINT8),
            sf_mode=int(filter_mode_std),
            ef_mode=int(filter_mode_ext),
            sf_ids=cnt_ids_std,
            ef_ids=cnt_ids_ext,
            btp_sdr=bitrate.structure(),
            btp_fdr=extended_bitrate.structure(),
        )
        self._control.init_line(init)
        self._init = init

    @net_call
    def set_acc_filter(self, select: int, code: int, mask: int) -> None:
        """SetAccFilter: the same as in ICanControl. Filters can be changed only offline, otherwise VciException."""
        self._control.set_acc_filter(select, code, mask)

    @net_call
    def add_filter_ids(self, select: int, code: int, mask: int) -> None:
        """AddFilterIds: add all identifiers that match the pattern to the list."""
        self._control.add_filter_ids(select, code, mask)

    @net_call
    def rem_filter_ids(self, select: int, code: int, mask: int) -> None:
        """RemFilterIds: remove all identifiers that match the pattern from the list."""
        self._control.rem_filter_ids(select, code, mask)

    def _settings(self) -> CanInitLine2 | None:
        """The settings of `init_line`, with a detected bit rate; without `init_line` those of another program."""
        status = self._control.get_line_status()
        if not status.op_mode:
            return None
        filters = self._init or CanInitLine2(
            sf_mode=CanFilterModes.PASS,
            ef_mode=CanFilterModes.PASS,
            sf_ids=CAN_FILTER_SIZE_STD,
            ef_ids=CAN_FILTER_SIZE_EXT,
        )
        return CanInitLine2(
            op_mode=status.op_mode & ~CanOperatingModes.AUTO_BAUDRATE,
            ex_mode=status.ex_mode,
            sf_mode=filters.sf_mode,
            ef_mode=filters.ef_mode,
            sf_ids=filters.sf_ids,
            ef_ids=filters.ef_ids,
            btp_sdr=status.btp_sdr,
            btp_fdr=status.btp_fdr,
        )
