"""A row of the transmit list, and its content."""

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
    """A frame, possibly of a message with typed signals, possibly with changes; or a sequence of `steps` (`text`)."""

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
        """Return the frame number `number`, from 0; raises BadSignals if signals do not fit together."""
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
    """Return the frame with other data of the same length."""
    if isinstance(frame, LinFrame):
        return LinFrame(frame.id, data, enhanced=frame.enhanced)
    return Frame(frame.id, data, extended=frame.extended, fd=frame.fd, bit_rate_switch=frame.bit_rate_switch)


@dataclass(frozen=True)
class Row:
    """A row for one line (its address). `cycle_ms` 0: sent only by hand. `most`: the number of frames, 0 for no limit.

    `exact`: the hub's cyclic list sends the row. `running`: its cycle runs now. `queued` counts the frames since it was
    added, `failed` those that could not be sent, and `trouble` is the last such error. `step` is the next step of a
    sequence.
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
        """The first frame of the row."""
        return self.content.frame

    def refused(self, why: str) -> Row:
        return replace(self, failed=self.failed + 1, trouble=why)

    def sent(self) -> Row:
        return replace(self, queued=self.queued + 1, trouble="")
