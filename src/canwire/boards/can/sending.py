"""Sends frames one by one on the line of a node: the compiled part of a lab's node."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager
from typing import Any, Never, Protocol

from canwire.boards.can.channel import Channel
from canwire.boards.can.line import Line
from canwire.errors import BadValue
from canwire.values.checks import LONGEST_NS, check_frame, more_than_a_frame
from canwire.values.frame import Frame
from canwire.values.record import HIGH_PRIORITY, SELF_RECEPTION, SINGLE_SHOT

_SINGLE_SHOT, _HIGH_PRIORITY = SINGLE_SHOT, HIGH_PRIORITY
_NO_DELAY = 0  # who gives none has not to be checked


class Time(Protocol):
    """The time in which a node runs, and the waiters for its events.

    A `pacer` makes that time pass by the clock; a `selection` leaves out some frames.
    """

    @property
    def pacer(self) -> object: ...
    @property
    def selection(self) -> object: ...
    @property
    def waiters(self) -> dict[Any, int]: ...
    def touch(self) -> AbstractContextManager[None]: ...
    def active(self) -> None: ...


class Sending:
    """Sends frames through a channel of a line."""

    def __init__(self, time: Time, line: Line, channel: Channel, self_reception: bool) -> None:
        self._time = time
        self.line = line
        self._channel = channel
        self._flags = SELF_RECEPTION if self_reception else 0
        self._plain = time.pacer is None and time.selection is None
        self._waiters = time.waiters
        self._closed = False

    def send(
        self,
        frame: Frame,
        *wrong: Never,
        single_shot: bool = False,
        high_priority: bool = False,
        delay_ns: int = _NO_DELAY,
    ) -> None:
        """Queue a frame; it is sent when the bus permits.

        `single_shot`: one attempt, abandoned at a lost arbitration or error. `high_priority`: before the frame that
        waits in the controller. `delay_ns`: not before this long after the node's previous frame.
        Raises QueueFull, LineError (an FD frame on a classic line, a listen-only node), Closed.
        """
        if wrong:
            raise more_than_a_frame(frame, wrong)
        if type(frame) is not Frame:
            check_frame(frame, Frame)
        flags = self._flags
        if single_shot:
            flags |= _SINGLE_SHOT
        if high_priority:
            flags |= _HIGH_PRIORITY
        if self._closed:
            self._check_open()
        if delay_ns is not _NO_DELAY and not 0 <= delay_ns <= LONGEST_NS:
            raise BadValue(f"delay_ns {delay_ns}: from 0 to {LONGEST_NS}")
        if self._plain:
            self.line.send(self._channel, frame, flags, delay_ns)
        elif self._takes(frame):
            with self._time.touch():
                self.line.send(self._channel, frame, flags, delay_ns)
        if self._waiters:
            self._time.active()

    def send_many(self, frames: Iterable[Frame]) -> int:
        """Queue frames in order; returns how many.

        Raises errors like `send`; the frames before the error stay queued.
        """
        count = 0
        for frame in frames:
            self.send(frame)
            count += 1
        return count

    def _takes(self, frame: Frame) -> bool:
        """Whether the frame is sent; a frame that is left out counts as sent, and never reaches the queue."""
        raise NotImplementedError

    def _check_open(self) -> None:
        """Raise Closed after `close`."""
        raise NotImplementedError
