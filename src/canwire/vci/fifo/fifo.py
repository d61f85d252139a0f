"""The two ends of a FIFO.

Source: VCI V4 manual 4.1 and 6.4; rulings.md 8 and 12.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, TypeVar, overload
from uuid import UUID

from canwire.vci.arguments import UINT32, within
from canwire.vci.fifo.block import FifoBlock
from canwire.vci.structures.errors import (
    VCI_E_INVALID_STATE,
    VCI_E_INVHANDLE,
    VCI_E_RXQUEUE_EMPTY,
    VCI_E_TXQUEUE_FULL,
    VciError,
)
from canwire.vci.structures.guids import (
    IID_IFifoReader,
    IID_IFifoWriter,
    IID_IUnknown,
)
from canwire.vci.unknown import Unknown, vci_call

if TYPE_CHECKING:
    from canwire import Event, RingEnd
    from canwire.vci.fifo.elements import Elements

T = TypeVar("T")
Sibling = Callable[[UUID], Unknown]


class FifoEnd(Unknown, Generic[T]):
    """The common part of IFifoReader and IFifoWriter. Each end of a FIFO can be open once at a time.

    Elements are `bytes`, in a channel's FIFOs CanMsg or CanMsg2, in a monitor's LinMsg. Source: manual 6.4.1.
    """

    def __init__(
        self, end: RingEnd, form: Elements[T], given_back: Callable[[], None], sibling: Sibling
    ) -> None:
        """`sibling` opens other interfaces of the same FIFO."""
        super().__init__()
        self._sibling = sibling
        self._end = end
        self._ring = end.ring
        self._form = form
        self._given_back = given_back
        self._mutex = threading.RLock()
        self._block: FifoBlock[T] | None = None
        self._event: Event | None = None
        self._cut = ""

    @property
    def end(self) -> RingEnd:
        """The queue's end, for a program in C, which reads and writes the memory itself."""
        return self._end

    @property
    def form(self) -> Elements[T]:
        """The layout of its elements, for a program in C."""
        return self._form

    @vci_call
    def check(self) -> None:
        """Raises VciError if it cannot be used; for a program in C."""

    @vci_call
    def query_interface(self, iid: UUID) -> Any:
        """QueryInterface: this or another interface of the FIFO (VciFifo.query_interface)."""
        return super().query_interface(iid) if iid in self.interfaces else self._sibling(iid)

    @vci_call
    def lock(self) -> None:
        """Lock: wait until no other thread holds the lock. Calls nest: each `lock` needs its `unlock`.

        Threads that share an end call `lock` before and `unlock` after each call except `get_capacity` and
        `get_entry_size`.
        """
        self._mutex.acquire()

    @vci_call
    def unlock(self) -> None:
        """Unlock; raises VciInvalidState if the calling thread does not hold the lock."""
        try:
            self._mutex.release()
        except RuntimeError as error:
            raise VciError.of(VCI_E_INVALID_STATE, str(error)) from None

    @vci_call
    def assign_event(self, event: Event | None) -> None:
        """AssignEvent: signal this event at the threshold; it replaces the previous event, None removes that.

        A reader's event is signalled when an element is written and at least `threshold` elements then wait; a
        writer's event when an element is removed and at least `threshold` elements are then free.
        """
        self._event = event
        self._end.assign(event)

    @vci_call
    def set_threshold(self, threshold: int) -> None:
        """SetThreshold: 1 to the capacity; a higher number means the capacity, 0 means 1."""
        self._end.threshold = within("threshold", threshold, 0, UINT32)

    @vci_call
    def get_threshold(self) -> int:
        """GetThreshold: the threshold, 1 at first."""
        return self._end.threshold

    @vci_call
    def get_capacity(self) -> int:
        """GetCapacity: the number of elements that the FIFO can contain."""
        return self._ring.capacity

    @vci_call
    def get_entry_size(self) -> int:
        """GetEntrySize: the number of bytes of an element: 16 for LINMSG, 20 for CANMSG, 80 for CANMSG2."""
        return self._form.size

    @vci_call
    def get_fill_count(self) -> int:
        """GetFillCount: the number of elements that wait to be read."""
        return self._ring.fill()

    @vci_call
    def get_free_count(self) -> int:
        """GetFreeCount: the number of free elements."""
        return self._ring.free()

    def cut(self, why: str) -> None:
        """For its channel: the FIFO no longer exists, and each further call raises VciError with VCI_E_INVHANDLE."""
        self._cut = why
        self._drop_block()

    def _check(self) -> None:
        super()._check()
        if self._cut:
            raise VciError.of(VCI_E_INVHANDLE, self._cut)
        self._end.lease.check()

    def _close(self) -> None:
        self._drop_block()
        if not self._cut:
            self._end.assign(None)
            self._end.threshold = 1
            self._given_back()

    def _hand_out(self, cells: memoryview, *, writable: bool) -> tuple[FifoBlock[T], int]:
        self._drop_block()
        self._block = FifoBlock(cells, self._form, writable=writable)
        return self._block, len(self._block)

    def _acquired(self, count: int) -> FifoBlock[T] | None:
        """The acquired block; raises VciInvalidArgument if it has fewer than `count` elements."""
        within("count", count, 0, len(self._block) if self._block is not None else 0)
        return self._block

    def _drop_block(self) -> None:
        if self._block is not None:
            self._block.end()
            self._block = None


class FifoReader(FifoEnd[T]):
    """IFifoReader: the end of a FIFO from which elements are read. Source: manual 4.1.1 and 6.4.1."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IFifoReader})

    @overload
    def get_data_entry(self, *, discard: Literal[False] = False) -> T: ...
    @overload
    def get_data_entry(self, *, discard: Literal[True]) -> None: ...
    def get_data_entry(self, *, discard: bool = False) -> T | None:
        """GetDataEntry: remove the oldest element and return it; with `discard` (C's null pointer) return None.

        Raises VciRxQueueEmpty if the FIFO is empty.
        """
        record = self._take()
        return None if discard else self._form.load(record)

    @vci_call
    def _take(self) -> bytes:
        self._drop_block()
        record = self._ring.take_bytes()
        if record is None:
            raise VciError.of(VCI_E_RXQUEUE_EMPTY, self._end.lease.name)
        self._end.touched()
        return record

    @vci_call
    def acquire_read(self) -> tuple[FifoBlock[T], int]:
        """AcquireRead: a block of the oldest elements that are contiguous, and their number.

        Nothing is copied; `release_read` removes elements. Elements after the end of the FIFO's memory are in the next
        block. Raises VciRxQueueEmpty if the FIFO is empty.
        """
        blocks = self._ring.acquire(self._ring.capacity)
        if not blocks:
            raise VciError.of(VCI_E_RXQUEUE_EMPTY, self._end.lease.name)
        return self._hand_out(blocks[0], writable=False)

    @vci_call
    def release_read(self, count: int) -> None:
        """ReleaseRead: remove the first `count` of the acquired elements from the FIFO; the others stay.

        Raises VciInvalidArgument if `count` is more than `acquire_read` returned.
        """
        self._acquired(count)
        self._drop_block()
        if count:
            self._ring.release(count)
        self._end.touched()


class FifoWriter(FifoEnd[T]):
    """IFifoWriter: the end of a FIFO to which elements are written. Source: manual 4.1.2 and 6.4.1."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_IFifoWriter})
    obstacle: Callable[[], str] = staticmethod(str)
    """Returns the obstacle that keeps its line off the bus, "" if there is none."""

    @vci_call
    def put_data_entry(self, data: Any) -> None:
        """PutDataEntry: append an element, a structure or bytes of the entry size.

        Raises VciTxQueueFull if the FIFO is full, VciInvalidArgument for an element of another size or type.
        """
        cell = self._form.store(data)
        self._drop_block()
        if not self._ring.free():
            raise self._full()
        self._ring.put_bytes(cell)
        self._end.touched()

    @vci_call
    def acquire_write(self) -> tuple[FifoBlock[T], int]:
        """AcquireWrite: a block of free elements that are contiguous, and their number.

        They contain their previous values. Raises VciTxQueueFull if the FIFO is full.
        """
        cells = self._ring.acquire_free(self._ring.capacity)
        if not cells:
            raise self._full()
        return self._hand_out(cells, writable=True)

    @vci_call
    def release_write(self, count: int) -> None:
        """ReleaseWrite: pass the first `count` of the acquired elements to the reader.

        Raises VciInvalidArgument if `count` is more than `acquire_write` returned, and for a CANMSG with bits that
        need ICanChannel2.
        """
        block = self._acquired(count)
        if block is not None:
            block.settle(count)
        self._drop_block()
        if count:
            self._ring.commit(count)
        self._end.touched()

    def _full(self) -> VciError:
        why = self.obstacle()
        return VciError.of(VCI_E_TXQUEUE_FULL, self._end.lease.name + (f": {why}" if why else ""))
