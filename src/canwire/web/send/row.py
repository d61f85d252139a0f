"""A row of the transmit list, and what it sends."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from canwire import Frame, LinFrame

if TYPE_CHECKING:
    from canwire.web.send.changing import Change
    from canwire.web.send.steps import Step

Sent = Frame | LinFrame


@dataclass(frozen=True)
class Content:
    """A frame, perhaps made of a message's signals (as typed), perhaps changing; or a sequence of `steps` (`text`)."""

    frame: Sent
    message: str = ""
    signals: Mapping[str, str] = field(default_factory=dict)
    changes: tuple[Change, ...] = ()
    steps: tuple[Step, ...] = ()
    text: str = ""
    encode: Callable[[str, dict[str, str]], Sent] | None = None

    @property
    def lin(self) -> bool:
        return isinstance(self.frame, LinFrame)

    def at(self, number: int) -> Sent:
        """The frame that is sent after `number` others; raises BadSignals where signals do not fit together."""
        if not self.changes:
            return self.frame
        values = {one.name: f"{one.value(number):.12g}" for one in self.changes if one.byte < 0}
        frame = self.frame
        if values and self.encode is not None:
            frame = self.encode(self.message, {**self.signals, **values})
        data = bytearray(frame.data)
        for one in self.changes:
            if 0 <= one.byte < len(data):
                data[one.byte] = int(one.value(number))
        return with_data(frame, bytes(data))


def with_data(frame: Sent, data: bytes) -> Sent:
    """The same frame with other data of the same length."""
    if isinstance(frame, LinFrame):
        return LinFrame(frame.id, data, enhanced=frame.enhanced)
    return Frame(frame.id, data, extended=frame.extended, fd=frame.fd, bit_rate_switch=frame.bit_rate_switch)


@dataclass(frozen=True)
class Row:
    """For one line (its address). `cycle_ms` 0: by hand alone; `most` 0: without end, else so many times.

    `exact`: the hub's cyclic list keeps the cycle. `running`: it is sent in its cycle now; `queued` counts the frames
    since it was made, `failed` those that could not be, and `trouble` says why the last one could not. `step` is how
    far a sequence is.
    """

    number: int
    line: str
    content: Content
    cycle_ms: float = 0.0
    key: str = ""
    most: int = 0
    comment: str = ""
    exact: bool = False
    running: bool = False
    queued: int = 0
    left: int = 0
    failed: int = 0
    trouble: str = ""
    step: int = 0

    @property
    def frame(self) -> Sent:
        """The first one."""
        return self.content.frame

    def refused(self, why: str) -> Row:
        return replace(self, failed=self.failed + 1, trouble=why)

    def sent(self) -> Row:
        return replace(self, queued=self.queued + 1, trouble="")
