"""What lies in a FIFO: plain bytes, CANMSG, CANMSG2 or LINMSG, and how they lie there.

A channel's FIFOs hold records of 80 bytes, CANMSG2's layout; ICanChannel sees CANMSG in them. A monitor's records
are as long; LINMSG's time lies at 0, uMsgInfo and abData at 12.
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
_INFO_AT, _DATA_END = 12, 24  # in a record, behind CANMSG's eight bytes of data
_ONLY_CANMSG2 = 1 << 10 | 1 << 11  # edl, fdr


class Elements(Protocol[T_co]):
    """How elements lie in a FIFO: `size` bytes for the user, `cell` bytes in memory."""

    size: int
    cell: int

    def load(self, cells: bytes | memoryview, at: int = 0) -> T_co:
        """The element in the cell that begins there, as a copy."""

    def place(self, cell: Cell) -> T_co:
        """The element in a writer's cell, to be written there; the cell is asked for at every use."""

    def store(self, element: object) -> bytes:
        """The cell for an element, which may be given as its bytes; raises VciInvalidArgument."""

    def settle(self, cells: memoryview) -> None:
        """Look over what a user wrote into cells by hand; raises VciInvalidArgument."""

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        """Cells as a C program would see them."""

    def records(self, cells: memoryview) -> numpy.ndarray:
        """Cells as an array over the same memory. Raises ExtraMissing without numpy."""


class Plain:
    """Elements of any size, as bytes."""

    def __init__(self, size: int) -> None:
        self.size = self.cell = size

    def load(self, cells: bytes | memoryview, at: int = 0) -> bytes:
        return bytes(cells[at : at + self.cell])

    def place(self, cell: Cell) -> Any:
        """A memoryview: these elements have no fields."""
        return cell()

    def store(self, element: object) -> bytes:
        return _bytes_of(element, self.size)

    def settle(self, cells: memoryview) -> None:
        """Anything goes."""

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        return cells

    def records(self, cells: memoryview) -> numpy.ndarray:
        return _array(cells, "u1").reshape(-1, self.size)


class CanMsg2Elements:
    """CANMSG2, as it lies there. Without `fd` the controller is a classic one, and CAN FD messages are refused."""

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
        """Refuse what the controller can never send; the hub looks at each message anyway."""
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
        """Refuse what needs ICanChannel2, and clear what a CANMSG does not have."""
        if _any_fd(cells, self.cell):
            raise VciError.of(VCI_E_INVALIDARG, "a CANMSG has no edl and no fdr: use ICanChannel2")
        for at in range(0, len(cells), self.cell):
            cells[at + 4 : at + 8] = bytes(4)
            cells[at + _DATA_END : at + self.cell] = bytes(self.cell - _DATA_END)

    def compact(self, cells: memoryview, *, writable: bool) -> memoryview:
        if writable:
            what = "CANMSGs do not lie side by side here: write block[i], or into block.records"
            raise VciError.of(VCI_E_NOT_IMPLEMENTED, what)
        starts = range(0, len(cells), self.cell)
        return memoryview(
            b"".join(bytes(cells[at : at + 4]) + cells[at + 8 : at + _DATA_END] for at in starts)
        )

    def records(self, cells: memoryview) -> numpy.ndarray:
        return _array(cells, canmsg_view_dtype())


class LinMsgElements:
    """LINMSG in a monitor's records: a word of time, and the other twelve bytes further on."""

    size, cell = LinMsg.SIZE, CanMsg2.SIZE

    def load(self, cells: bytes | memoryview, at: int = 0) -> LinMsg:
        return LinMsg.from_bytes(linmsg_of_record(cells[at : at + self.cell]))

    def place(self, cell: Cell) -> LinMsg:
        """A monitor has no writer, so this is a copy."""
        return self.load(cell())

    def store(self, element: object) -> bytes:
        return record_of_linmsg(_bytes_of(element, self.size, LinMsg))

    def settle(self, cells: memoryview) -> None:
        """Nobody writes here but the hub."""

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
    """An element's bytes: those of a structure, or any buffer of that size."""
    if isinstance(element, kind):
        raw = element.to_bytes()
    elif isinstance(element, bytes | bytearray | memoryview):
        raw = bytes(element)
    else:
        wanted = "bytes" if kind is Structure else f"a {kind.__name__}"
        raise VciError.of(VCI_E_INVALIDARG, f"{wanted} belongs here, not {element!r:.60}")
    if len(raw) != size:
        raise VciError.of(VCI_E_INVALIDARG, f"an element here has {size} bytes, not {len(raw)}")
    return raw
