"""CanMessage, CanMessage2 and the cyclic messages of Ixxat.Vci4.

Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 7.3.14 to 7.3.18.
"""

from __future__ import annotations

from typing import ClassVar, Generic, Protocol

from canwire.vci.can.message import CanCyclicTxMsg, CanCyclicTxMsg2, CanMsg, CanMsg2
from canwire.vci.structures.constants import CAN_EDLC_XLT, CAN_ELEN_MAX, CAN_ELEN_XLT
from canwire.vci.v3.can import message as v3
from canwire.vci.v3.can.enums import CanCyclicTXIncMode, CanCyclicTXStatus
from canwire.vci.v3.errors import checked

_INCREMENTED = {CanCyclicTXIncMode.INC_8: 1, CanCyclicTXIncMode.INC_16: 2}  # bytes


class _FdFlags:
    """The flags of Ixxat.Vci4's messages that V3 does not have.

    `extended_data_length`: a CAN FD message; `fast_data_rate`: its data have the fast bit rate;
    `error_state_indicator`: its sender was error passive.
    """

    __slots__ = ()
    extended_data_length = v3.Flag("edl")
    fast_data_rate = v3.Flag("fdr")
    error_state_indicator = v3.Flag("esi")


class CanMessage(_FdFlags, v3.CanMessage):
    """ICanMessage: a CAN message of up to 8 bytes; `message[i]` is byte i."""

    __slots__ = ()


class _Long(_FdFlags, v3.AnyCanMessage[CanMsg2]):
    __slots__ = ()
    _KIND = CanMsg2
    ROOM: ClassVar[int] = CAN_ELEN_MAX

    @property
    def data_length(self) -> int:
        """DataLength in bytes, 0 to 64; a length that CAN FD does not have is rounded up."""
        return CAN_EDLC_XLT[self.raw.msg_info.dlc]

    @data_length.setter
    def data_length(self, length: int) -> None:
        self.raw.msg_info.dlc = CAN_ELEN_XLT[checked("data_length", length, CAN_ELEN_MAX)]


class CanMessage2(_Long):
    """ICanMessage2: a CAN message of up to 64 bytes; more than 8 need `extended_data_length`."""

    __slots__ = ()


class Sends(Protocol):
    """What the messages of a cyclic list need from the list."""

    def start(self, message: _Cyclic[CanMsg] | _Cyclic[CanMsg2], repeat_count: int) -> None: ...
    def stop(self, message: _Cyclic[CanMsg] | _Cyclic[CanMsg2]) -> None: ...
    def remove(self, message: _Cyclic[CanMsg] | _Cyclic[CanMsg2]) -> None: ...
    def state(self, message: _Cyclic[CanMsg] | _Cyclic[CanMsg2]) -> int: ...


class _Cyclic(v3.AnyCyclicTXMsg[v3.Raw], Generic[v3.Raw]):
    """A message of a cyclic list, which AddMessage of the list makes.

    Changes while it is sent take effect at the next `start`.
    """

    __slots__ = ("_list",)

    def __init__(self, of: Sends) -> None:
        super().__init__()
        self._list = of

    @property
    def status(self) -> CanCyclicTXStatus:
        """The present Status; EMPTY before the first start, and after its removal from the list."""
        return CanCyclicTXStatus(self._list.state(self))

    def start(self, repeat_count: int) -> None:
        """Start: send its present content `repeat_count` times, 1 to 65535, or without end if it is 0.

        Raises ArgumentException if the list has no room for its cycle, and VciException.
        """
        self._list.start(self, repeat_count)

    def stop(self) -> None:
        """Stop: stop sending it; nothing happens if it was not started."""
        self._list.stop(self)

    def reset(self) -> None:
        """Reset: stop it and free its place in the cycles; it can be started again."""
        self._list.remove(self)

    def _adapted(self, made: v3.Cyclic) -> v3.Cyclic:
        """`made` without an increment in bytes that are not sent: the manual refuses it, but .NET programs use it."""
        sent = len(made.data) - self.auto_increment_index
        if sent < _INCREMENTED.get(self.auto_increment_mode, 0):
            made.incr_mode = CanCyclicTXIncMode.INC_8 if sent == 1 else CanCyclicTXIncMode.NO_INC
            made.byte_index = made.byte_index if sent == 1 else 0
        return made


class CanCyclicTXMsg(_FdFlags, _Cyclic[CanMsg], v3.CanMessage):
    """ICanCyclicTXMsg: a cyclic message of up to 8 bytes."""

    __slots__ = ()

    def structure(self) -> CanCyclicTxMsg:
        """For its list: V4's structure of the same."""
        return self._adapted(self._as(CanCyclicTxMsg))


class CanCyclicTXMsg2(_Cyclic[CanMsg2], _Long):
    """ICanCyclicTXMsg2: a cyclic message of up to 64 bytes."""

    __slots__ = ()

    def structure(self) -> CanCyclicTxMsg2:
        """For its list: V4's structure of the same."""
        return self._adapted(self._as(CanCyclicTxMsg2))
