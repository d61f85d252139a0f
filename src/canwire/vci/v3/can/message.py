"""CanMessage and CanCyclicTXMsg.

Source: VCI V3 .NET manual 4.2.3.2, 4.2.3.3 and 4.2.5; reference/vci.md section 7a.
"""

from __future__ import annotations

from typing import Any, ClassVar, Generic, Self, TypeVar, overload

from canwire.vci.arguments import UINT16, UINT32
from canwire.vci.can.message import CanCyclicTxMsg, CanCyclicTxMsg2, CanMsg, CanMsg2
from canwire.vci.structures.constants import CAN_SDLC_MAX
from canwire.vci.v3.can.enums import (
    V3_ERRORS,
    CanCyclicTXIncMode,
    CanCyclicTXStatus,
    CanMsgAccReason,
    CanMsgError,
    CanMsgFrameType,
)
from canwire.vci.v3.errors import checked
from canwire.vci.v3.message import Message

Raw = TypeVar("Raw", CanMsg, CanMsg2)
Cyclic = TypeVar("Cyclic", CanCyclicTxMsg, CanCyclicTxMsg2)


class Flag:
    """A bit of CANMSGINFO as True or False."""

    __slots__ = ("bit",)

    def __init__(self, bit: str) -> None:
        self.bit = bit

    @overload
    def __get__(self, message: None, owner: type) -> Self: ...
    @overload
    def __get__(self, message: AnyCanMessage[Any], owner: type) -> bool: ...
    def __get__(self, message: AnyCanMessage[Any] | None, owner: type) -> Self | bool:
        return self if message is None else bool(getattr(message.raw.msg_info, self.bit))

    def __set__(self, message: AnyCanMessage[Any], value: bool) -> None:
        setattr(message.raw.msg_info, self.bit, int(bool(value)))


class AnyCanMessage(Message[Raw], Generic[Raw]):
    """A CAN message; a new one is a data message without data. `message[i]` is byte i.

    `self_reception_request` in a message to send: the sender also receives it; in a received message: it is such a
    message. Other flags are `remote_transmission_request`, `extended_frame_format` (29 bits), `single_shot_mode` and
    `high_priority_msg`. `raw` is V4's structure. Assigning an invalid value raises ArgumentOutOfRangeException.
    """

    __slots__ = ()
    _KIND: ClassVar[type[Any]]

    self_reception_request = Flag("srr")
    remote_transmission_request = Flag("rtr")
    extended_frame_format = Flag("ext")
    single_shot_mode = Flag("ssm")
    high_priority_msg = Flag("hpm")

    def __init__(self) -> None:
        self.raw = self._KIND()

    @property
    def identifier(self) -> int:
        """Identifier, 11 or 29 bits; 0xFFFFFFFF for INFO, ERROR and STATUS, the number of overruns for TIME_OVERRUN."""
        return self.raw.msg_id

    @identifier.setter
    def identifier(self, identifier: int) -> None:
        self.raw.msg_id = checked("identifier", identifier, UINT32)

    @property
    def frame_type(self) -> CanMsgFrameType:
        """FrameType; only DATA is sent, a line refuses and counts other messages."""
        return CanMsgFrameType(self.raw.msg_info.type)

    @frame_type.setter
    def frame_type(self, kind: int) -> None:
        self.raw.msg_info.type = checked("frame_type", kind, max(CanMsgFrameType))

    @property
    def accept_reason(self) -> CanMsgAccReason:
        """AcceptReason: the filter that accepted the message."""
        return CanMsgAccReason(self.raw.msg_info.afc)

    def clear(self) -> None:
        """Clear: set all fields to 0."""
        self.raw = self._KIND()

    def __repr__(self) -> str:
        raw = self.raw
        kind = CanMsgFrameType(raw.msg_info.type).name.lower()
        shown = raw.data if raw.msg_info.type == CanMsgFrameType.DATA else bytes(raw.ab_data)
        return f"<{type(self).__name__} {kind} {raw.msg_id:#x} [{raw.msg_info.dlc}] {shown.hex(' ')}>"


class CanMessage(AnyCanMessage[CanMsg]):
    """A CAN message of up to 8 bytes."""

    __slots__ = ()
    _KIND = CanMsg

    @property
    def data_length(self) -> int:
        """DataLength: the data length code, 0 to 8; in a received message it can be higher, which means 8."""
        return self.raw.msg_info.dlc

    @data_length.setter
    def data_length(self, length: int) -> None:
        self.raw.msg_info.dlc = checked("data_length", length, CAN_SDLC_MAX)


class AnyCyclicTXMsg(AnyCanMessage[Raw], Generic[Raw]):
    """A message that the cyclic list sends repeatedly; its `time_stamp` is ignored.

    Two such messages are equal only if they are the same object.
    """

    __slots__ = ("_cycle_ticks", "_index", "_mode", "_status")

    def __init__(self) -> None:
        super().__init__()
        self._cycle_ticks = 0
        self._mode = CanCyclicTXIncMode.NO_INC
        self._index = 0
        self._status = CanCyclicTXStatus.EMPTY

    @property
    def status(self) -> CanCyclicTXStatus:
        """Status at the last ICanScheduler.UpdateStatus; EMPTY before the first start and outside the list."""
        return self._status

    @property
    def cycle_ticks(self) -> int:
        """CycleTicks: 1 to MaxCyclicMessageTicks, of CyclicMessageTimerDivisor / ClockFrequency seconds each."""
        return self._cycle_ticks

    @cycle_ticks.setter
    def cycle_ticks(self, ticks: int) -> None:
        self._cycle_ticks = checked("cycle_ticks", ticks, UINT16)

    @property
    def auto_increment_mode(self) -> CanCyclicTXIncMode:
        """AutoIncrementMode: the part that is incremented after each transmission."""
        return self._mode

    @auto_increment_mode.setter
    def auto_increment_mode(self, mode: int) -> None:
        self._mode = CanCyclicTXIncMode(checked("auto_increment_mode", mode, max(CanCyclicTXIncMode)))

    @property
    def auto_increment_index(self) -> int:
        """AutoIncrementIndex: the index, from 0, of the data byte that is incremented, of two bytes the low one."""
        return self._index

    @auto_increment_index.setter
    def auto_increment_index(self, index: int) -> None:
        self._index = checked("auto_increment_index", index, self.ROOM - 1)

    def clear(self) -> None:
        super().clear()
        self._cycle_ticks = self._index = 0
        self._mode = CanCyclicTXIncMode.NO_INC

    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]

    def told(self, status: int) -> None:
        """For its list: set the state of the message."""
        self._status = CanCyclicTXStatus(status)

    def _as(self, kind: type[Cyclic]) -> Cyclic:
        """V4's structure for this message."""
        made = kind(
            cycle_time=self._cycle_ticks,
            incr_mode=self._mode,
            byte_index=self._index,
            msg_id=self.raw.msg_id,
            msg_info=self.raw.msg_info,
        )
        made.ab_data = bytearray(self.raw.ab_data)
        return made


class CanCyclicTXMsg(AnyCyclicTXMsg[CanMsg], CanMessage):
    """A cyclic message of up to 8 bytes.

    AddMessage copies it: later changes take effect at the next AddMessage.
    """

    __slots__ = ()

    def structure(self) -> CanCyclicTxMsg:
        """For its list: V4's structure for this message."""
        return self._as(CanCyclicTxMsg)


def received(raw: CanMsg, message: CanMessage | None = None) -> CanMessage:
    """V3's message for V4's message, in `message` if that is given; an error gets V3's number."""
    made = CanMessage() if message is None else message
    if raw.msg_info.type == CanMsgFrameType.ERROR:
        raw.ab_data[0] = V3_ERRORS.get(raw.ab_data[0], CanMsgError.OTHER)
    made.raw = raw
    return made
