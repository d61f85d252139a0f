"""What the interfaces of a CAN and of a LIN connector have in common: sockets, control units, queues.

What a line of either kind can do, how it is set up and how it is stays apart in can/line.py and lin/line.py: there
the same words mean other bits.
Source: VCI V4 manual 5.2 and 5.3.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Generic, NamedTuple, Protocol, Self, TypeVar
from uuid import UUID

from canwire.vci.bus_line import BusLine, bus_ctrl_of
from canwire.vci.fifo.elements import Elements
from canwire.vci.fifo.fifo import FifoEnd, FifoReader, Sibling
from canwire.vci.fifo.whole import QueueFifo
from canwire.vci.structures.devices import BalSocketInfo, VciId
from canwire.vci.structures.errors import VCI_E_ACCESSDENIED, VCI_E_INVHANDLE, VCI_E_NOT_INITIALIZED, VciError
from canwire.vci.structures.guids import IID_IFifoReader
from canwire.vci.unknown import Unknown, vci_call

if TYPE_CHECKING:
    from canwire import RingEnd


class Lease(Protocol):
    """What of a line one program holds."""

    def check(self) -> None: ...
    def close(self) -> None: ...


class ControlLease(Lease, Protocol):
    def reset(self) -> None: ...
    def start(self) -> None: ...
    def stop(self) -> None: ...


class QueueStatus(Protocol):
    @property
    def active(self) -> bool: ...
    @property
    def lost(self) -> int: ...


class QueueLease(Lease, Protocol):
    @property
    def name(self) -> str: ...
    @property
    def reading(self) -> RingEnd: ...
    def activate(self) -> object: ...
    def deactivate(self) -> None: ...
    def status(self) -> QueueStatus: ...


T = TypeVar("T")


class LineObject(Unknown):
    """An interface of a connector; it owns the share of the access layer that it was opened with."""

    def __init__(self, line: BusLine) -> None:
        super().__init__()
        self._line = line

    def _check(self) -> None:
        super()._check()
        self._line.layer.check()

    def _close(self) -> None:
        self._line.layer.close()


class SocketObject(LineObject):
    """What ICanSocket and ILinSocket have in common."""

    @classmethod
    def open(cls, line: BusLine) -> Self:
        """For the BAL: any number of programs may have one."""
        return cls(line.share())

    @vci_call
    def get_socket_info(self) -> BalSocketInfo:
        """GetSocketInfo: the connector's identifier, type and number from 0."""
        line = self._line
        return BalSocketInfo(
            object_id=VciId(line.number + 1 << 32 | line.board.id & 0xFFFF_FFFF),
            bus_type=bus_ctrl_of(line.info),
            socket_no=line.number,
        )


class LeaseObject(LineObject):
    """An interface that holds something of the line besides: it is gone when that is."""

    _lease: Lease

    def __init__(self, line: BusLine, lease: Lease) -> None:
        super().__init__(line)
        self._lease = lease

    def _check(self) -> None:
        super()._check()
        self._lease.check()

    def _close(self) -> None:
        try:
            self._lease.close()
        finally:
            super()._close()


class ControlObject(LeaseObject):
    """What the control units have in common. One program at a time may have a line's."""

    _lease: ControlLease

    @vci_call
    def reset_line(self) -> None:
        """ResetLine: leave the bus at once, breaking a frame being sent; the line is not initialised then.

        A CAN line's filter lists are empty, their modes those of `init_line`; a LIN line's response table is
        empty. FIFOs keep what is in them.
        """
        self._lease.reset()

    @vci_call
    def start_line(self) -> None:
        """StartLine: take part in the bus. Raises VciNotInitialized before `init_line`."""
        self._lease.start()

    @vci_call
    def stop_line(self) -> None:
        """StopLine: leave the bus once the frame being sent is through; filters, response table and FIFOs stay."""
        self._lease.stop()


class QueueState(NamedTuple):
    """What the statuses of channels and monitors have in common; the load in percent."""

    activated: bool = False
    rx_overrun: bool = False
    rx_fifo_load: int = 0


class QueueObject(LeaseObject, Generic[T]):
    """What channels and monitors have in common: a receive FIFO, made by Initialize, and one reader at a time."""

    _lease: QueueLease
    _form: Elements[T]

    def __init__(self, line: BusLine, lease: QueueLease) -> None:
        super().__init__(line, lease)
        self._initialized = False
        self._made = 0  # so many times were there new FIFOs
        self._ends: dict[str, FifoEnd[T]] = {}  # those that are open: "reader", a channel's "writer"

    @vci_call
    def activate(self) -> None:
        """Activate: from now on messages move between FIFOs and line, as far as that runs.

        Raises VciNotInitialized before `initialize`.
        """
        self._check_initialized()
        self._lease.activate()

    @vci_call
    def deactivate(self) -> None:
        """Deactivate: no more; what waits in the FIFOs stays. Raises VciNotInitialized before `initialize`."""
        self._check_initialized()
        self._lease.deactivate()

    @vci_call
    def get_reader(self) -> FifoReader[T]:
        """GetReader: the reading end of the receive FIFO.

        Raises VciNotInitialized before `initialize`, VciAccessDenied while it is open.
        """
        self._check_free("reader")
        end = self._lease.reading
        sibling = self._siblings(end, IID_IFifoReader, self.get_reader)
        reader = FifoReader(end, self._form, partial(self._give_back, "reader"), sibling)
        self._ends["reader"] = reader
        return reader

    def _siblings(self, end: RingEnd, own: UUID, open_end: Callable[[], Unknown]) -> Sibling:
        """What opens other interfaces of one of its FIFOs, until the FIFOs are made anew."""
        made = self._made

        def gone() -> None:
            self._check()
            if self._made != made:
                raise VciError.of(VCI_E_INVHANDLE, f"{self._lease.name} was initialised again")

        return QueueFifo(end, self._form, own, open_end, gone).sibling

    def _made_anew(self) -> None:
        """The FIFOs are new; ends of the old ones are dead."""
        self._cut(f"{self._lease.name} was initialised again")
        self._initialized = True
        self._made += 1

    def _state(self) -> QueueState:
        if not self._initialized:
            return QueueState()
        status = self._lease.status()
        return QueueState(status.active, status.lost > 0, fifo_load(self._lease.reading))

    def _check_initialized(self) -> None:
        if not self._initialized:
            raise VciError.of(VCI_E_NOT_INITIALIZED, f"{self._lease.name}: call initialize first")

    def _check_free(self, end: str) -> None:
        self._check_initialized()
        if end in self._ends:
            raise VciError.of(VCI_E_ACCESSDENIED, f"{self._lease.name}: its {end} is open; release it first")

    def _give_back(self, end: str) -> None:
        del self._ends[end]

    def _cut(self, why: str) -> None:
        for end in self._ends.values():
            end.cut(why)
        self._ends.clear()

    def _close(self) -> None:
        self._cut(f"{self._lease.name} was released")
        super()._close()


def fifo_load(end: RingEnd) -> int:
    """How full a FIFO is, 0 to 100 percent."""
    return int(end.ring.fill() * 100 // end.ring.capacity)
