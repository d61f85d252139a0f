"""ICanControl and ICanControl2: the one lease that sets a line up, starts and stops it.

Source: VCI V4 manual 5.2.3, 6.6.3 and 6.6.4; rulings.md 4 and 10.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self, TypeVar
from uuid import UUID

from canwire import BadTiming
from canwire.vci.arguments import UINT8, UINT16, instance, within
from canwire.vci.bus_line import BusLine
from canwire.vci.can.filters import FilterLists, FilterModes
from canwire.vci.can.line import (
    check_coupling,
    check_ex_mode,
    line_status,
    line_status2,
    mode_of_init,
    mode_of_init2,
)
from canwire.vci.can.structures import (
    CanBtpTable,
    CanBtrTable,
    CanInitLine,
    CanInitLine2,
    CanLineStatus,
    CanLineStatus2,
)
from canwire.vci.can.timing import timing_of_btp, timing_of_registers
from canwire.vci.line_objects import ControlObject
from canwire.vci.structures.constants import (
    CAN_BTP_TABLE_SIZE,
    CAN_EXMODE_FASTDATA,
    CAN_EXMODE_NONISO,
    CAN_OPMODE_LOWSPEED,
)
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VCI_E_TIMEOUT, VciError
from canwire.vci.structures.guids import IID_ICanControl, IID_ICanControl2, IID_IUnknown
from canwire.vci.unknown import vci_call

if TYPE_CHECKING:
    from canwire import BitTiming, Capabilities, Control, Filtered

_NO_INDEX = 0xFF
Table = TypeVar("Table", CanBtrTable, CanBtpTable)
Candidates = list[tuple["BitTiming", "BitTiming | None"]]


class _Control(ControlObject, FilterLists):
    _lease: Control

    @classmethod
    def open(cls, line: BusLine) -> Self:
        """For the BAL and for channels: one program at a time may have it."""
        lease = line.open_control()
        return cls(line.share(), lease)

    def _filters(self) -> Filtered:
        return self._lease

    def _detect(
        self, candidates: Candidates, timeout_ms: int, *, iso_fd: bool = True, low_speed: bool = False
    ) -> int:
        """Index of the candidate that the bus speaks."""
        if within("timeout_ms", timeout_ms, 0, UINT16) == 0:
            raise VciError.of(VCI_E_TIMEOUT, "a bus needs more than 0 ms to be heard")
        return self._lease.detect(candidates, timeout_ms, iso_fd=iso_fd, low_speed=low_speed)


class CanControl(_Control):
    """ICanControl: the control unit of a line; its filters are inclusive. Source: manual 6.6.3."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanControl})

    @vci_call
    def detect_baud(self, timeout_ms: int, table: CanBtrTable) -> CanBtrTable:
        """DetectBaud: find the rate of the running bus; only listens. Returns the table with `index` set.

        `timeout_ms` 1 to 65535 of silence at most between two messages; `index` CAN_OPMODE_LOWSPEED for that
        coupling, else 0 or 0xFF. Raises VciTimeout if nothing is heard, VciInvalidArgument for an empty table,
        VciInvalidState while the line runs.
        """
        _check_table(table, CanBtrTable)
        if table.index not in (0, _NO_INDEX, CAN_OPMODE_LOWSPEED):
            raise VciError.of(VCI_E_INVALIDARG, f"bIndex {table.index!r}: CAN_OPMODE_LOWSPEED, 0 or 0xFF")
        low_speed = table.index == CAN_OPMODE_LOWSPEED
        check_coupling(table.index if low_speed else 0, self._line.capabilities)
        pairs = zip(table.btr0, table.btr1, strict=False)
        candidates: Candidates = [(timing_of_registers(*pair), None) for pair in pairs]
        table.index = self._detect(candidates[: table.count], timeout_ms, low_speed=low_speed)
        return table

    @vci_call
    def init_line(self, init: CanInitLine) -> None:
        """InitLine: reset the line and set it up; it is stopped then.

        Raises VciNotSupported naming the feature that is missing, VciInvalidArgument, VciTimeout if it had to
        find its bit rate (CAN_OPMODE_AUTOBAUD) and heard nothing.
        """
        self._lease.initialise(mode_of_init(instance(init, CanInitLine), self._line.capabilities))

    @vci_call
    def get_line_status(self) -> CanLineStatus:
        """GetLineStatus: at any time."""
        return line_status(self._line.status())


class CanControl2(_Control, FilterModes):
    """ICanControl2: the control unit of a CAN FD line. Source: manual 6.6.4."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanControl2})

    @vci_call
    def detect_baud(self, op_mode: int, ex_mode: int, timeout_ms: int, table: CanBtpTable) -> CanBtpTable:
        """DetectBaud: find the rates of the running bus; only listens. Returns the table with `index` set.

        `op_mode` CAN_OPMODE_LOWSPEED or not; `ex_mode` CAN_EXMODE_FASTDATA to find the fast rate too, with
        CAN_EXMODE_NONISO on a bus of such frames. The rest as ICanControl's; raises VciError with
        VCI_E_INVALID_TIMING for an entry that the line cannot make.
        """
        _check_table(table, CanBtpTable)
        capabilities = self._line.capabilities
        check_coupling(within("op_mode", op_mode, 0, UINT8), capabilities)
        check_ex_mode(within("ex_mode", ex_mode, 0, UINT8), capabilities)
        table.index = self._detect(
            _candidates(table, capabilities, fast=bool(ex_mode & CAN_EXMODE_FASTDATA)),
            timeout_ms,
            iso_fd=not ex_mode & CAN_EXMODE_NONISO,
            low_speed=bool(op_mode & CAN_OPMODE_LOWSPEED),
        )
        return table

    @vci_call
    def init_line(self, init: CanInitLine2) -> None:
        """InitLine: reset the line and set it up with its filters; it is stopped then.

        Raises as ICanControl's, and VciError with VCI_E_INVALID_TIMING for a rate or raw value that the line
        cannot make.
        """
        self._lease.initialise(mode_of_init2(instance(init, CanInitLine2), self._line.capabilities))

    @vci_call
    def get_line_status(self) -> CanLineStatus2:
        """GetLineStatus: at any time."""
        return line_status2(self._line.status())


def _check_table(table: Table, kind: type[Table]) -> None:
    """Raise VciInvalidArgument for a table that C could not hold, and unless 1 to 64 entries count."""
    instance(table, kind).to_bytes()
    within("bCount", table.count, 1, CAN_BTP_TABLE_SIZE)


def _candidates(table: CanBtpTable, capabilities: Capabilities, *, fast: bool) -> Candidates:
    """The table's timings; raises BadTiming naming the entry that the line cannot make."""
    found: Candidates = []
    for at, pair in enumerate(table.btp[: table.count]):
        try:
            data = timing_of_btp(pair.fdr, capabilities, data=True) if fast else None
            found.append((timing_of_btp(pair.sdr, capabilities, data=False), data))
        except BadTiming as error:
            raise BadTiming(f"asBTP[{at}]: {error}") from None
    return found
