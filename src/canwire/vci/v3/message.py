"""What CanMessage and LinMessage have in common.

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
    """V4's structure `raw`, whose bytes are `message[i]`: `ROOM` of them."""

    __slots__ = ("raw",)
    ROOM: ClassVar[int] = LONGEST
    raw: Raw

    @property
    def time_stamp(self) -> int:
        """TimeStamp, 32 bits. Received: ticks of TimeStampCounterDivisor / ClockFrequency seconds.

        To send on CAN: how many ticks of DelayedTXTimerDivisor / ClockFrequency seconds at least after the message
        sent before, 0 for at once. To send on LIN: 0.
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
