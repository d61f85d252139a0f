"""The operation of TX_SETUP: frames that are sent in turn, some times at one interval, then at another.

Source: the kernel's documentation, networking/can.rst 4.2; what happens in which order is the kernel's.
"""

from __future__ import annotations

import errno
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from canwire.socketcan.bcm.message import (
    SETTIMER,
    STARTTIMER,
    TX_ANNOUNCE,
    TX_COUNTEVT,
    TX_CP_CAN_ID,
    TX_EXPIRED,
    TX_RESET_MULTI_IDX,
    TX_STATUS,
    Message,
    with_id,
)
from canwire.socketcan.loop import Loop, Timer
from canwire.socketcan.ports import refuse


class Repeated(Protocol):
    """A frame that cyclic.py repeats."""

    def replace(self, frame: bytes) -> bool:
        """Send another frame at the same times; False if that is impossible."""

    def stop(self) -> None: ...


Repeat = Callable[[bytes, float], Repeated | None]


class Sending:
    """`send` puts one frame on the bus, `tell` passes a message to the program. Delays do not shift later occurrences.

    `repeat` lets the hub send one frame without end at an interval in seconds; it returns None if that is impossible.
    """

    def __init__(
        self,
        loop: Loop,
        send: Callable[[bytes], object],
        tell: Callable[[Message], object],
        setup: Message,
        repeat: Repeat = lambda _, __: None,
    ) -> None:
        self._loop = loop
        self._repeat = repeat
        self._repeated: Repeated | None = None
        self._alone = False
        self._send = send
        self._tell = tell
        self._kept = replace(setup, count=0, interval1_s=0.0, interval2_s=0.0, frames=())
        self._next = 0
        self._timer: Timer | None = None
        self._apply(setup)

    def change(self, setup: Message) -> None:
        """TX_SETUP for an existing operation; raises OSError (E2BIG) for more frames than before."""
        if len(setup.frames) > len(self._kept.frames):
            raise refuse(errno.E2BIG)
        self._apply(setup)

    def status(self) -> Message:
        """The answer to TX_READ."""
        return replace(self._kept, opcode=TX_STATUS)

    def stop(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._repeated is not None:
            self._repeated.stop()
            self._repeated = None

    def _apply(self, setup: Message) -> None:
        frames = setup.frames
        if setup.flags & TX_CP_CAN_ID:
            frames = tuple(with_id(frame, setup.can_id) for frame in frames)
        if len(frames) != len(self._kept.frames) or setup.flags & TX_RESET_MULTI_IDX:
            self._next = 0
        announces = TX_ANNOUNCE if setup.flags & STARTTIMER else 0  # which the kernel shows, too
        self._kept = replace(self._kept, flags=setup.flags | announces, frames=frames)
        repeated = self._repeated
        if repeated is not None and (setup.flags & SETTIMER or not repeated.replace(frames[0])):
            self.stop()
            self._alone = True
            self._wait(self._loop.clock_s())
        if setup.flags & SETTIMER:
            self._kept = replace(
                self._kept, count=setup.count, interval1_s=setup.interval1_s, interval2_s=setup.interval2_s
            )
            if not setup.interval1_s and not setup.interval2_s:
                self.stop()
        if setup.flags & (STARTTIMER | TX_ANNOUNCE):
            self._put()
            self._kept = replace(self._kept, count=max(0, self._kept.count - 1))
        if setup.flags & STARTTIMER:
            self.stop()
            self._alone = False
            self._wait(self._loop.clock_s())

    def _put(self) -> None:
        self._send(self._kept.frames[self._next])
        self._next = (self._next + 1) % len(self._kept.frames)

    def _wait(self, from_s: float) -> None:
        kept = self._kept
        counts = kept.interval1_s and kept.count
        interval_s = kept.interval1_s if counts else kept.interval2_s
        if interval_s and not counts and len(kept.frames) == 1 and not self._alone:
            self._repeated = self._repeat(kept.frames[0], interval_s)
            self._alone = self._repeated is None  # asked once
        if interval_s and self._repeated is None:
            due_s = from_s + interval_s
            now_s = self._loop.clock_s()
            if due_s < now_s - interval_s:  # this process could not run: nothing is made up for
                due_s = now_s
            self._timer = self._loop.call_at(due_s, lambda: self._due(due_s))

    def _due(self, due_s: float) -> None:
        kept = self._kept
        if kept.interval1_s and kept.count:
            self._kept = kept = replace(kept, count=kept.count - 1)
            if not kept.count and kept.flags & TX_COUNTEVT:
                self._tell(replace(kept, opcode=TX_EXPIRED, frames=()))
        self._put()
        self._wait(due_s)
