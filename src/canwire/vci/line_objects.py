"""The common part of the interfaces of CAN and LIN connectors: sockets, control units, queues.

The capabilities, the configuration and the status of a line are separate, in can/line.py and lin/line.py, since the
same words mean different bits there.
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
    """Something of a line that one program holds."""

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
    """The common part of ICanSocket and ILinSocket."""

    @classmethod
    def open(cls, line: BusLine) -> Self:
        """Open a socket; BalObject calls this. Any number of programs may have one."""
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
    """An interface that also holds a lease of the line: it can be used only while the lease is valid."""

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
    """The common part of the control units. One program at a time may have the control unit of a line."""

    _lease: ControlLease

    @vci_call
    def reset_line(self) -> None:
        """ResetLine: leave the bus immediately, also in the middle of a frame; the line is not initialised afterwards.

        The filter lists of a CAN line are then empty, with the modes of `init_line`; the response table of a LIN line
        is empty. FIFOs keep their messages.
        """
        self._lease.reset()

    @vci_call
    def start_line(self) -> None:
        """StartLine: take part in the bus. Raises VciNotInitialized before `init_line`."""
        self._lease.start()

    @vci_call
    def stop_line(self) -> None:
        """StopLine: leave the bus after the frame that is being sent; filters, response table and FIFOs stay."""
        self._lease.stop()


class QueueState(NamedTuple):
    """The common part of the statuses of channels and monitors; the load is in percent."""

    activated: bool = False
    rx_overrun: bool = False
    rx_fifo_load: int = 0


class QueueObject(LeaseObject, Generic[T]):
    """The common part of channels and monitors: a receive FIFO, made by Initialize, and one reader at a time."""

    _lease: QueueLease
    _form: Elements[T]

    def __init__(self, line: BusLine, lease: QueueLease) -> None:
        super().__init__(line, lease)
        self._initialized = False
        self._made = 0  # how many times FIFOs were made
        self._ends: dict[str, FifoEnd[T]] = {}  # the open ends: "reader", and "writer" of a channel

    @vci_call
    def activate(self) -> None:
        """Activate: messages move between the FIFOs and the line from now on, while the line runs.

        Raises VciNotInitialized before `initialize`.
        """
        self._check_initialized()
        self._lease.activate()

    @vci_call
    def deactivate(self) -> None:
        """Deactivate: messages move no longer; the FIFOs keep theirs. Raises VciNotInitialized before `initialize`."""
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
        """A function that opens other interfaces of one of its FIFOs, until `initialize` makes new FIFOs."""
        made = self._made

        def gone() -> None:
            self._check()
            if self._made != made:
                raise VciError.of(VCI_E_INVHANDLE, f"{self._lease.name} was initialised again")

        return QueueFifo(end, self._form, own, open_end, gone).sibling

    def _made_anew(self) -> None:
        """After new FIFOs were made: the ends of the old FIFOs can no longer be used."""
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
    """The load of a FIFO, 0 to 100 percent."""
    return int(end.ring.fill() * 100 // end.ring.capacity)
