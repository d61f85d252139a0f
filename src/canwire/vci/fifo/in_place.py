"""Messages that are written in place in a FIFO, as C++ does through a pointer into the block of AcquireWrite.

A channel's cells have the same layout for CANMSG and CANMSG2: 32-bit words for time, reserved, identifier and message
information, then the data.
Source: VCI V4 manual 4.1.2, 5.2.2 and 7.3.14 to 7.3.16.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, cast

from canwire.packed.kinds import limited, number
from canwire.packed.layout import Misfit
from canwire.vci.can.message import CanMsg, CanMsg2
from canwire.vci.can.msg_info import CanMsgInfo
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError

Cell = Callable[[], memoryview]
_WORD = number("I")
_TIME, _RESERVED, _MSG_ID, _INFO, _DATA = 0, 4, 8, 12, 16


class _Placed(Protocol):
    """An object in a cell, which `_cell` returns while the cell's block is valid."""

    _cell: Cell


class Word:
    """A 32-bit number in a cell. Assigning any other value raises VciInvalidArgument."""

    __slots__ = ("at", "c_name")

    def __init__(self, c_name: str, at: int) -> None:
        self.c_name = c_name
        self.at = at

    def __get__(self, placed: _Placed | None, owner: type) -> Any:
        if placed is None:
            return self
        return int.from_bytes(placed._cell()[self.at : self.at + 4], "little")

    def __set__(self, placed: _Placed, value: int) -> None:
        try:
            word = _WORD.fit(value)
        except Misfit as misfit:
            raise VciError(VCI_E_INVALIDARG, f"{self.c_name} is {value!r:.60}: not {misfit.wants}") from None
        placed._cell()[self.at : self.at + 4] = word.to_bytes(4, "little")


class InfoInPlace(CanMsgInfo):
    """uMsgInfo of a message in its cell."""

    __slots__ = ("_cell",)
    value = cast(int, Word("CANMSGINFO.dwMsgInfo", _INFO))

    def __init__(self, cell: Cell) -> None:
        self._cell = cell


class _InPlace:
    """The common part of CANMSG and CANMSG2 in a cell; it must be the first base class."""

    __slots__ = ()
    _cell: Cell
    ROOM: int
    time = cast(int, Word("dwTime", _TIME))
    msg_id = cast(int, Word("dwMsgId", _MSG_ID))

    @property
    def msg_info(self) -> CanMsgInfo:
        return InfoInPlace(self._cell)

    @msg_info.setter
    def msg_info(self, info: CanMsgInfo) -> None:
        InfoInPlace(self._cell).value = info.value

    @property
    def ab_data(self) -> Any:
        """The whole data field, a memoryview, which must not be used after the block is released."""
        return self._cell()[_DATA : _DATA + self.ROOM]

    @ab_data.setter
    def ab_data(self, data: bytes | bytearray | memoryview) -> None:
        try:
            raw = limited(data, self.ROOM)
        except (TypeError, ValueError):
            raise VciError(VCI_E_INVALIDARG, f"abData has {self.ROOM} bytes, not {data!r:.60}") from None
        self._cell()[_DATA : _DATA + self.ROOM] = raw.ljust(self.ROOM, b"\0")


class CanMsgInPlace(_InPlace, CanMsg):
    """A CANMSG in its cell; `copy` returns a CanMsg, which stays valid after the block."""

    __slots__ = ("_cell",)

    def __init__(self, cell: Cell) -> None:
        self._cell = cell

    def copy(self) -> Any:
        return CanMsg.from_bytes(self.to_bytes())

    def __repr__(self) -> str:
        return repr(self.copy())


class CanMsg2InPlace(_InPlace, CanMsg2):
    """A CANMSG2 in its cell; `copy` returns a CanMsg2, which stays valid after the block."""

    __slots__ = ("_cell",)
    reserved = cast(int, Word("_rsvd_", _RESERVED))

    def __init__(self, cell: Cell) -> None:
        self._cell = cell

    def copy(self) -> Any:
        return CanMsg2.from_bytes(self.to_bytes())

    def __repr__(self) -> str:
        return repr(self.copy())
