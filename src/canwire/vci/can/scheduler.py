"""ICanScheduler and ICanScheduler2: the cyclic transmit list, whose messages a line sends by itself.

Source: VCI V4 manual 5.2.5, 6.6.7, 6.6.8, 7.3.12, 7.3.13, 7.3.17 and 7.3.18; rulings.md 9.
"""

from __future__ import annotations

import contextlib
import struct
from typing import TYPE_CHECKING, ClassVar, Self
from uuid import UUID

from canwire import BadValue, Unsupported
from canwire.vci.arguments import UINT16, instance, within
from canwire.vci.bus_line import BusLine
from canwire.vci.can.line import line_status2
from canwire.vci.can.message import CanCyclicTxMsg, CanCyclicTxMsg2
from canwire.vci.can.structures import CanSchedulerStatus, CanSchedulerStatus2
from canwire.vci.line_objects import LeaseObject
from canwire.vci.structures.constants import (
    CAN_CTXTSK_STAT_RUNNING,
    CAN_CTXTSK_STAT_STOPPED,
    CAN_MAX_CTX_MSGS,
    CAN_MSGTYPE_DATA,
)
from canwire.vci.structures.errors import (
    VCI_E_INVALID_INDEX,
    VCI_E_INVALIDARG,
    VCI_E_NOT_IMPLEMENTED,
    VciError,
)
from canwire.vci.structures.guids import IID_ICanScheduler, IID_ICanScheduler2, IID_IUnknown
from canwire.vci.translation import meaning
from canwire.vci.unknown import vci_call

if TYPE_CHECKING:
    from canwire import CyclicStatus, Scheduler

_RECORD = struct.Struct("<QII64s")


class _Scheduler(LeaseObject):
    """The cyclic list of a line. A line has one list: an index means the same object in both interfaces."""

    _lease: Scheduler

    @classmethod
    def open(cls, line: BusLine) -> Self:
        """Open the list, for the BAL; one program at a time may have it. VciNotImplemented on a line without a list."""
        with meaning(VCI_E_NOT_IMPLEMENTED, Unsupported):
            lease = line.open_scheduler()
        return cls(line.share(), lease)

    @vci_call
    def resume(self) -> None:
        """Resume: start the list; all objects that were started before begin in the same tick."""
        self._lease.resume()

    @vci_call
    def suspend(self) -> None:
        """Suspend: stop all objects immediately. A new list is stopped."""
        self._lease.suspend()

    @vci_call
    def reset(self) -> None:
        """Reset: stop the list and remove all objects."""
        self._lease.reset()

    @vci_call
    def rem_message(self, index: int) -> None:
        """RemMessage: remove an object from the list; raises VciInvalidIndex if there is none."""
        with _no_such_index():
            self._lease.remove(_slot(index))

    @vci_call
    def start_message(self, index: int, count: int = 0) -> None:
        """StartMessage: while the list runs, send an object `count` times, 1 to 65535, or without end if it is 0.

        Raises VciInvalidIndex if there is no such object, VciInvalidArgument for another count.
        """
        within("count", count, 0, UINT16)
        with _no_such_index():
            self._lease.start(_slot(index), count)

    @vci_call
    def stop_message(self, index: int) -> None:
        """StopMessage: stop sending an object; raises VciInvalidIndex if there is none."""
        with _no_such_index():
            self._lease.stop(_slot(index))

    def _add(self, message: CanCyclicTxMsg | CanCyclicTxMsg2) -> int:
        message.to_bytes()  # names the member that does not fit
        info = message.msg_info
        if info.type != CAN_MSGTYPE_DATA:
            raise VciError.of(
                VCI_E_INVALIDARG, f"message type {info.type}: only CAN_MSGTYPE_DATA can be sent"
            )
        record = _RECORD.pack(0, message.msg_id, info.value, bytes(message.ab_data))
        return self._lease.add(
            record, message.cycle_time, increment=message.incr_mode, byte_index=message.byte_index
        )


class CanScheduler(_Scheduler):
    """ICanScheduler: the cyclic list for messages of up to 8 bytes. Source: manual 6.6.7."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanScheduler})

    @vci_call
    def add_message(self, message: CanCyclicTxMsg) -> int:
        """AddMessage: add an object, which is idle until `start_message`; returns its index, 0 to 15.

        `cycle_time` is 1 to cms_max_ticks of the capabilities; the sum of 1 / cycle_time over the list must not exceed
        1. Otherwise, and for a message that no line can send, it raises VciInvalidArgument. It raises VciInvalidState
        for a full list and for a message that this line cannot send in its present configuration.
        """
        instance(message, CanCyclicTxMsg)
        if message.msg_info.edl or message.msg_info.fdr:
            raise VciError.of(
                VCI_E_INVALIDARG, "a CANCYCLICTXMSG has neither edl nor fdr: use ICanScheduler2"
            )
        return self._add(message)

    @vci_call
    def get_status(self) -> CanSchedulerStatus:
        """GetStatus: CAN_CTXTSK_STAT_ of the list, CAN_CTXMSG_STAT_ of each of its 16 indices."""
        return CanSchedulerStatus(*_stats(self._lease.status()))


class CanScheduler2(_Scheduler):
    """ICanScheduler2: the cyclic list for messages of up to 64 bytes. Source: manual 6.6.8."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanScheduler2})

    @vci_call
    def add_message(self, message: CanCyclicTxMsg2) -> int:
        """AddMessage: the same as in ICanScheduler."""
        return self._add(instance(message, CanCyclicTxMsg2))

    @vci_call
    def get_status(self) -> CanSchedulerStatus2:
        """GetStatus: the same as in ICanScheduler, with the state of the line."""
        return CanSchedulerStatus2(line_status2(self._line.status()), *_stats(self._lease.status()))


def _stats(status: CyclicStatus) -> tuple[int, bytes]:
    task = CAN_CTXTSK_STAT_RUNNING if status.running else CAN_CTXTSK_STAT_STOPPED
    return task, bytes(status.states)


def _slot(index: int) -> int:
    if not isinstance(index, int) or not 0 <= index < CAN_MAX_CTX_MSGS:
        raise VciError.of(VCI_E_INVALID_INDEX, f"index {index!r}: it must be 0 to {CAN_MAX_CTX_MSGS - 1}")
    return index


def _no_such_index() -> contextlib.AbstractContextManager[None]:
    return meaning(VCI_E_INVALID_INDEX, BadValue)
