"""The common part of CanMessage and LinMessage.

Source: VCI V3 .NET manual 4.2.3.2 and 4.3.3.1.
"""

from __future__ import annotations

from typing import ClassVar, Generic, TypeVar

from canwire.vci.arguments import UINT8, UINT32
from canwire.vci.can.message import CanMsg, CanMsg2
from canwire.vci.lin.message import LinMsg
from canwire.vci.v3.errors import checked

LONGEST = 8  # bytes
Raw = TypeVar("Raw", CanMsg, CanMsg2, LinMsg)


class Message(Generic[Raw]):
    """A message over V4's structure `raw`; `message[i]` is byte i of its `ROOM` bytes of data."""

    __slots__ = ("raw",)
    ROOM: ClassVar[int] = LONGEST
    raw: Raw

    @property
    def time_stamp(self) -> int:
        """TimeStamp, 32 bits. In a received message: ticks of TimeStampCounterDivisor / ClockFrequency seconds.

        In a message to send on CAN: the least delay after the previous message, in ticks of DelayedTXTimerDivisor /
        ClockFrequency seconds; 0 means no delay. In a message to send on LIN: 0.
        """
        return self.raw.time

    @time_stamp.setter
    def time_stamp(self, ticks: int) -> None:
        self.raw.time = checked("time_stamp", ticks, UINT32)

    @property
    def possible_overrun(self) -> bool:
        """PossibleOverrun: messages were lost, on CAN just before this one, on LIN just after it."""
        return bool(self.raw.msg_info.ovr)

    def __getitem__(self, index: int) -> int:
        return self.raw.ab_data[checked("index", index, self.ROOM - 1)]

    def __setitem__(self, index: int, byte: int) -> None:
        self.raw.ab_data[checked("index", index, self.ROOM - 1)] = checked("byte", byte, UINT8)

    def __eq__(self, other: object) -> bool:
        return self.raw == other.raw if isinstance(other, Message) else NotImplemented

    __hash__ = None  # type: ignore[assignment]
