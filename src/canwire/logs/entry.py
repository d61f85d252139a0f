"""One entry of a log of any format: its time, channel, content and direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from canwire.errors import BadValue
from canwire.values.checks import whole
from canwire.values.event import BusEvent
from canwire.values.frame import Frame
from canwire.values.lin.event import LinEvent
from canwire.values.lin.frame import LinFrame
from canwire.values.named import NamedInt

MOST_TEXT = 48
"""Greatest length of a mark's text, in bytes of UTF-8."""


class LogKind(NamedInt):
    """The kind of an entry; the `kind` of a record of `log_dtype()`."""

    CAN_FRAME = 0
    CAN_EVENT = 1
    LIN_FRAME = 2
    LIN_EVENT = 3
    MARK = 4


class MarkKind(NamedInt):
    """The meaning of a mark, which describes the log.

    LOST: `count` frames or events are missing before this place. GAP: for `count` nanoseconds nothing was recorded.
    BIT_RATE: `bit_rate` and `data_bit_rate` hold from here on, in bit/s, 0 where unknown. CLOCK: `text` names the clock
    of the time stamps. NOTE: `text` is a remark.
    """

    LOST = 1
    GAP = 2
    BIT_RATE = 3
    CLOCK = 4
    NOTE = 5


@dataclass(frozen=True, slots=True)
class LogMark:
    """A statement about the log at one place: see MarkKind. `text` is cut to 48 bytes of UTF-8."""

    kind: MarkKind
    timestamp_ns: int = 0
    count: int = 0
    bit_rate: int = 0
    data_bit_rate: int = 0
    text: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.kind, MarkKind):
            raise BadValue(f"kind {self.kind!r}: one of MarkKind")
        for name, bits in (("timestamp_ns", 64), ("count", 64), ("bit_rate", 32), ("data_bit_rate", 32)):
            whole(name, getattr(self, name), 0, (1 << bits) - 1)
        cut = self.text.replace("\0", "").encode()[:MOST_TEXT].decode(errors="ignore")
        object.__setattr__(self, "text", cut)


Content = Frame | BusEvent | LinFrame | LinEvent | LogMark


class LogEntry(NamedTuple):
    """One entry of a log.

    `timestamp_ns` counts from 1970 if `Log.dated`, else from the zero of the log; the content has the same time.
    `channel` is the name in the file ("can0"), or "can0", "can1", ... made from a number. `direction` is "R"
    (received), "T" (transmitted) or None where the log does not say.
    """

    timestamp_ns: int
    channel: str
    content: Content
    direction: str | None = None

    @property
    def frame(self) -> Frame | None:
        """The CAN frame, or None for any other entry."""
        return self.content if isinstance(self.content, Frame) else None
