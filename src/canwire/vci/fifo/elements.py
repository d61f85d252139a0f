"""The elements of a FIFO, plain bytes, CANMSG, CANMSG2 or LINMSG, and their memory layout.

A channel's FIFOs contain records of 80 bytes with the layout of CANMSG2; ICanChannel reads and writes CANMSG in them.
A monitor's records also have 80 bytes: LINMSG's time is at offset 0, uMsgInfo at 12 and abData at 16.
Source: VCI V4 manual 4.1, 5.2.2 and 5.3.2; reference/vci.md section 5.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from canwire import linmsg_of_record, record_of_linmsg
from canwire.vci.arrays import load_numpy
from canwire.vci.can.dtypes import canmsg2_dtype, canmsg_view_dtype
from canwire.vci.can.message import CanMsg, CanMsg2
from canwire.vci.fifo.in_place import CanMsg2InPlace, CanMsgInPlace, Cell
from canwire.vci.lin.dtypes import linmsg_view_dtype
from canwire.vci.lin.message import LinMsg
from canwire.vci.structures.errors import (
    VCI_E_INVALIDARG,
    VCI_E_NOT_IMPLEMENTED,
    VCI_E_NOT_SUPPORTED,
    VciError,
)
from canwire.vci.structures.structure import Structure

if TYPE_CHECKING:
    import numpy

T_co = TypeVar("T_co", covariant=True)
_INFO = struct.Struct("<I")
_CANMSG = struct.Struct("<I4xII8s")  # in a record
_CANMSG2 = struct.Struct("<IIII64s")
_INFO_AT, _DATA_END = (
    12,
    24,
)  # in a record: the offset of uMsgInfo, and the end of CANMSG's eight bytes of data
_ONLY_CANMSG2 = 1 << 10 | 1 << 11  # edl, fdr


class Elements(Protocol[T_co]):
    """The layout of elements in a FIFO: `size` bytes for the user, `cell` bytes in memory."""

    size: int
    cell: int

    def load(self, cells: bytes | memoryview, at: int = 0) -> T_co:
        """A copy of the element in the cell that begins at `at`."""

    def place(self, cell: Cell) -> T_co:
        """The element in a writer's cell, for writing in place; `cell()` is called at each use."""

    def store(self, element: object) -> bytes:
        """The cell for an element, or for the bytes of one; raises VciInvalidArgument."""

    def settle(self, cells: memoryview) -> None:
        """Check what a user wrote into cells in place; raises VciInvalidArgument."""

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        """The elements as a C program sees them, contiguous."""

    def records(self, cells: memoryview) -> numpy.ndarray:
        """The cells as an array over the same memory. Raises ExtraMissing without numpy."""


class Plain:
    """Elements of any size, as bytes."""

    def __init__(self, size: int) -> None:
        self.size = self.cell = size

    def load(self, cells: bytes | memoryview, at: int = 0) -> bytes:
        return bytes(cells[at : at + self.cell])

    def place(self, cell: Cell) -> Any:
        """A memoryview, since these elements have no fields."""
        return cell()

    def store(self, element: object) -> bytes:
        return _bytes_of(element, self.size)

    def settle(self, cells: memoryview) -> None:
        """Accepts all bytes."""

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        return cells

    def records(self, cells: memoryview) -> numpy.ndarray:
        return _array(cells, "u1").reshape(-1, self.size)


class CanMsg2Elements:
    """CANMSG2, which has the layout of a record. Without `fd`, for a classic controller, it refuses CAN FD messages."""

    size = cell = CanMsg2.SIZE

    def __init__(self, *, fd: bool = True) -> None:
        self._fd = fd

    def load(self, cells: bytes | memoryview, at: int = 0) -> CanMsg2:
        return CanMsg2.made(*_CANMSG2.unpack_from(cells, at))

    def place(self, cell: Cell) -> CanMsg2:
        return CanMsg2InPlace(cell)

    def store(self, element: object) -> bytes:
        raw = _bytes_of(element, self.size, CanMsg2)
        self.settle(memoryview(raw))
        return raw

    def settle(self, cells: memoryview) -> None:
        """Refuse what the controller can never send; the hub also checks each message."""
        if not self._fd and _any_fd(cells, self.cell):
            what = "a message with edl or fdr: this controller lacks CAN_FEATURE_EXTDATA and CAN_FEATURE_FASTDATA"
            raise VciError.of(VCI_E_NOT_SUPPORTED, what)

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        return cells

    def records(self, cells: memoryview) -> numpy.ndarray:
        return _array(cells, canmsg2_dtype())


class CanMsgElements:
    """CANMSG in the cells of CANMSG2: no reserved word, eight bytes of data."""

    size, cell = CanMsg.SIZE, CanMsg2.SIZE

    def load(self, cells: bytes | memoryview, at: int = 0) -> CanMsg:
        return CanMsg.made(*_CANMSG.unpack_from(cells, at))

    def place(self, cell: Cell) -> CanMsg:
        return CanMsgInPlace(cell)

    def store(self, element: object) -> bytes:
        raw = _bytes_of(element, self.size, CanMsg)
        made = bytearray(self.cell)
        made[:4], made[8:_DATA_END] = raw[:4], raw[4:]
        self.settle(memoryview(made))
        return bytes(made)

    def settle(self, cells: memoryview) -> None:
        """Refuse bits that need ICanChannel2, and set the bytes to 0 that a CANMSG does not have."""
        if _any_fd(cells, self.cell):
            raise VciError.of(VCI_E_INVALIDARG, "a CANMSG has neither edl nor fdr: use ICanChannel2")
        for at in range(0, len(cells), self.cell):
            cells[at + 4 : at + 8] = bytes(4)
            cells[at + _DATA_END : at + self.cell] = bytes(self.cell - _DATA_END)

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        if writable:
            what = "CANMSGs are not contiguous in this FIFO: write block[i] or block.records"
            raise VciError.of(VCI_E_NOT_IMPLEMENTED, what)
        starts = range(0, len(cells), self.cell)
        return memoryview(
            b"".join(bytes(cells[at : at + 4]) + cells[at + 8 : at + _DATA_END] for at in starts)
        )

    def records(self, cells: memoryview) -> numpy.ndarray:
        return _array(cells, canmsg_view_dtype())


class LinMsgElements:
    """LINMSG in a monitor's records: the time at offset 0, the other twelve bytes from offset 12."""

    size, cell = LinMsg.SIZE, CanMsg2.SIZE

    def load(self, cells: bytes | memoryview, at: int = 0) -> LinMsg:
        return LinMsg.from_bytes(linmsg_of_record(cells[at : at + self.cell]))

    def place(self, cell: Cell) -> LinMsg:
        """A copy, since a monitor has no writer."""
        return self.load(cell())

    def store(self, element: object) -> bytes:
        return record_of_linmsg(_bytes_of(element, self.size, LinMsg))

    def settle(self, cells: memoryview) -> None:
        """Nothing to check, since only the hub writes into these cells."""

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        starts = range(0, len(cells), self.cell)
        return memoryview(b"".join(linmsg_of_record(cells[at : at + self.cell]) for at in starts))

    def records(self, cells: memoryview) -> numpy.ndarray:
        return _array(cells, linmsg_view_dtype())


CAN_MSGS = CanMsgElements()
CAN_MSG2S = CanMsg2Elements()
CLASSIC_CAN_MSG2S = CanMsg2Elements(fd=False)
LIN_MSGS = LinMsgElements()


def _any_fd(cells: memoryview, cell: int) -> bool:
    infos = range(_INFO_AT, len(cells), cell)
    return any(_INFO.unpack_from(cells, at)[0] & _ONLY_CANMSG2 for at in infos)


def _array(cells: memoryview, dtype: numpy.dtype[numpy.void] | str) -> numpy.ndarray:
    array: numpy.ndarray = load_numpy().frombuffer(cells, dtype)
    return array


def _bytes_of(element: object, size: int, kind: type[Structure] = Structure) -> bytes:
    """The bytes of an element, which is a structure or a buffer of `size` bytes."""
    if isinstance(element, kind):
        raw = element.to_bytes()
    elif isinstance(element, bytes | bytearray | memoryview):
        raw = bytes(element)
    else:
        wanted = "bytes" if kind is Structure else f"a {kind.__name__}"
        raise VciError.of(VCI_E_INVALIDARG, f"{wanted} belongs here, not {element!r:.60}")
    if len(raw) != size:
        raise VciError.of(VCI_E_INVALIDARG, f"an element of this FIFO has {size} bytes, not {len(raw)}")
    return raw
