"""Elements in the memory of a FIFO, which a program accesses without copying.

Source: VCI V4 manual 4.1.1 and 4.1.2, figures 9 and 12.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, TypeVar, overload

from canwire.vci.structures.errors import VCI_E_INVHANDLE, VciError

if TYPE_CHECKING:
    import numpy

    from canwire.vci.fifo.elements import Elements

T = TypeVar("T")


class FifoBlock(Sequence[T]):
    """The result of AcquireRead or AcquireWrite: contiguous elements, the oldest first.

    A writer's `block[i]` is the element in the FIFO's memory: a change of it changes what is sent, as through C's
    pointer; `block[i] = element` copies an element. A reader's `block[i]` is a separate structure, the same one each
    time, which a program may keep. A block is valid until its interface reads, writes or releases elements; then the
    block and a writer's elements raise VciError with VCI_E_INVHANDLE, and arrays and memoryviews of them must not be
    used any longer.
    """

    def __init__(self, cells: memoryview, form: Elements[T], *, writable: bool) -> None:
        self._cells: memoryview | None = cells if writable else cells.toreadonly()
        self._form = form
        self._writable = writable
        self._count = len(cells) // form.cell
        self._taken: dict[int, T] = {}

    @property
    def memory(self) -> memoryview:
        """The elements as contiguous memory of the FIFO, read-only for a reader.

        The FIFOs of an ICanChannel and an ILinMonitor have gaps between the CANMSGs or LINMSGs: for their reader this
        is a copy, for a channel's writer it raises VciNotImplemented.
        """
        return self._form.compact(self._alive(), writable=self._writable)

    @property
    def records(self) -> numpy.ndarray:
        """A numpy array over the FIFO's memory. Its dtype is canmsg2_dtype(), canmsg_view_dtype() for an ICanChannel,
        linmsg_view_dtype() for an ILinMonitor.

        The elements of a FIFO made by `create_fifo` are rows of bytes. Needs canwire[arrays].
        """
        return self._form.records(self._alive())

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> T: ...
    @overload
    def __getitem__(self, index: slice) -> list[T]: ...
    def __getitem__(self, index: int | slice) -> T | list[T]:
        if isinstance(index, slice):
            return [self[at] for at in range(*index.indices(self._count))]
        taken = self._taken.get(index)
        if taken is None:
            taken = self._taken[index] = self._made(index)
        return taken

    def __setitem__(self, index: int, element: T) -> None:
        cell = self._cell(index)
        if not self._writable:
            raise TypeError("a reader's block cannot be written")
        cell[:] = self._form.store(element)

    def _made(self, index: int) -> T:
        cells, at = self._alive(), self._place(index)
        if index < 0:
            return self[index + self._count]
        return self._form.place(partial(self._cell, index)) if self._writable else self._form.load(cells, at)

    def settle(self, count: int) -> None:
        """For its writer: check the first `count` elements before the reader gets them."""
        self._form.settle(self._alive()[: count * self._form.cell])

    def end(self) -> None:
        """End the block: its elements can no longer be used through it."""
        cells, self._cells = self._cells, None
        self._taken.clear()
        if cells is not None:
            with contextlib.suppress(BufferError):  # the user is responsible for arrays over it
                cells.release()

    def _alive(self) -> memoryview:
        if self._cells is None:
            raise VciError.of(VCI_E_INVHANDLE, "this block of a FIFO was released; acquire another")
        return self._cells

    def _cell(self, index: int) -> memoryview:
        cells, at = self._alive(), self._place(index)
        return cells[at : at + self._form.cell]

    def _place(self, index: int) -> int:
        """The position at which an element's cell begins."""
        at = index + self._count if index < 0 else index
        if not 0 <= at < self._count:
            raise IndexError(f"element {index} of {self._count}")
        return at * self._form.cell
