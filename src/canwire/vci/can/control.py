"""ICanControl and ICanControl2: the control unit, which configures, starts and stops a line.

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
        """Open the control unit, for the BAL and for channels; one program at a time may have it."""
        lease = line.open_control()
        return cls(line.share(), lease)

    def _filters(self) -> Filtered:
        return self._lease

    def _detect(
        self, candidates: Candidates, timeout_ms: int, *, iso_fd: bool = True, low_speed: bool = False
    ) -> int:
        """The index of the candidate whose bit rate the bus has."""
        if within("timeout_ms", timeout_ms, 0, UINT16) == 0:
            raise VciError.of(VCI_E_TIMEOUT, "the detection needs a timeout of more than 0 ms")
        return self._lease.detect(candidates, timeout_ms, iso_fd=iso_fd, low_speed=low_speed)


class CanControl(_Control):
    """ICanControl: the control unit of a line; its filters are inclusive. Source: manual 6.6.3."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanControl})

    @vci_call
    def detect_baud(self, timeout_ms: int, table: CanBtrTable) -> CanBtrTable:
        """DetectBaud: find the bit rate of the running bus in listen-only mode. Returns the table with `index` set.

        `timeout_ms`, 1 to 65535, is the longest silence between two messages. `index` is CAN_OPMODE_LOWSPEED for that
        coupling, else 0 or 0xFF. Raises VciTimeout if no message is received, VciInvalidArgument for an empty table,
        VciInvalidState while the line runs.
        """
        _check_table(table, CanBtrTable)
        if table.index not in (0, _NO_INDEX, CAN_OPMODE_LOWSPEED):
            raise VciError.of(
                VCI_E_INVALIDARG, f"bIndex {table.index!r}: it must be CAN_OPMODE_LOWSPEED, 0 or 0xFF"
            )
        low_speed = table.index == CAN_OPMODE_LOWSPEED
        check_coupling(table.index if low_speed else 0, self._line.capabilities)
        pairs = zip(table.btr0, table.btr1, strict=False)
        candidates: Candidates = [(timing_of_registers(*pair), None) for pair in pairs]
        table.index = self._detect(candidates[: table.count], timeout_ms, low_speed=low_speed)
        return table

    @vci_call
    def init_line(self, init: CanInitLine) -> None:
        """InitLine: reset the line and configure it; it is stopped afterwards.

        Raises VciNotSupported, which names the missing feature, VciInvalidArgument, and VciTimeout if the line could
        not detect its bit rate (CAN_OPMODE_AUTOBAUD) because it received nothing.
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
        """DetectBaud: find the bit rates of the running bus in listen-only mode. Returns the table with `index` set.

        `op_mode` is CAN_OPMODE_LOWSPEED for that coupling, else 0; `ex_mode` is CAN_EXMODE_FASTDATA to find the fast
        rate, too, with CAN_EXMODE_NONISO on a bus with non-ISO frames. Otherwise it is the same as in ICanControl;
        raises VciError with VCI_E_INVALID_TIMING for an entry that the line cannot make.
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
        """InitLine: reset the line and configure it with its filters; it is stopped afterwards.

        Raises what ICanControl's raises, and VciError with VCI_E_INVALID_TIMING for a rate or raw value that the line
        cannot make.
        """
        self._lease.initialise(mode_of_init2(instance(init, CanInitLine2), self._line.capabilities))

    @vci_call
    def get_line_status(self) -> CanLineStatus2:
        """GetLineStatus: at any time."""
        return line_status2(self._line.status())


def _check_table(table: Table, kind: type[Table]) -> None:
    """Raises VciInvalidArgument for a value that does not fit C's table, and unless `count` is 1 to 64."""
    instance(table, kind).to_bytes()
    within("bCount", table.count, 1, CAN_BTP_TABLE_SIZE)


def _candidates(table: CanBtpTable, capabilities: Capabilities, *, fast: bool) -> Candidates:
    """The timings of the table; raises BadTiming, which names an entry that the line cannot make."""
    found: Candidates = []
    for at, pair in enumerate(table.btp[: table.count]):
        try:
            data = timing_of_btp(pair.fdr, capabilities, data=True) if fast else None
            found.append((timing_of_btp(pair.sdr, capabilities, data=False), data))
        except BadTiming as error:
            raise BadTiming(f"asBTP[{at}]: {error}") from None
    return found
