"""The operation of RX_SETUP: reports changed frames of an identifier, and the timeout when no more frames arrive.

Source: the kernel's documentation, networking/can.rst 4.2; what happens in which order is the kernel's.
"""

from __future__ import annotations

import errno
from collections.abc import Callable
from dataclasses import replace

from canwire.socketcan.bcm.message import (
    DATA_AT,
    LENGTH_AT,
    RX_ANNOUNCE_RESUME,
    RX_CHANGED,
    RX_CHECK_DLC,
    RX_FILTER_ID,
    RX_NO_AUTOTIMER,
    RX_RTR_FRAME,
    RX_STATUS,
    RX_TIMEOUT,
    SETTIMER,
    STARTTIMER,
    Message,
)
from canwire.socketcan.loop import Loop, Timer
from canwire.socketcan.ports import refuse

_MULTIPLEX = 8  # bytes of the first frame that choose among the others


class Watching:
    """`tell(message, stamp_ns)` passes a message to the program, `send` answers a remote frame."""

    def __init__(
        self,
        loop: Loop,
        send: Callable[[bytes], object],
        tell: Callable[[Message, int], object],
        setup: Message,
    ) -> None:
        self._loop = loop
        self._send = send
        self._tell = tell
        self._most = len(setup.frames)
        self._kept = replace(setup, frames=())
        self._last: dict[int, bytes] = {}
        self._held: dict[int, int] = {}  # places of frames whose change waits for the throttle: their times
        self._told_s = 0.0
        self._timeout: Timer | None = None
        self._throttle: Timer | None = None
        self._apply(setup)

    def change(self, setup: Message) -> None:
        """RX_SETUP for an existing operation; raises OSError (E2BIG) for more frames than before."""
        if len(setup.frames) > self._most:
            raise refuse(errno.E2BIG)
        self._apply(setup)

    def status(self) -> Message:
        """The answer to RX_READ."""
        return replace(self._kept, opcode=RX_STATUS)

    def stop(self) -> None:
        for timer in (self._timeout, self._throttle):
            if timer is not None:
                timer.cancel()
        self._timeout = self._throttle = None

    def take(self, frame: bytes, stamp_ns: int) -> None:
        """A frame with this identifier has arrived."""
        kept = self._kept
        if self._timeout is not None:
            self._timeout.cancel()
            self._timeout = None
        if kept.flags & RX_RTR_FRAME:
            self._send(kept.frames[0])
            return
        place = self._place(frame)
        if kept.flags & RX_FILTER_ID or (place is not None and self._differs(place, frame)):
            self._changed(place or 0, frame, stamp_ns)
        if not kept.flags & RX_NO_AUTOTIMER:
            self._start_timeout()

    def _apply(self, setup: Message) -> None:
        flags = setup.flags | (0 if setup.frames else RX_FILTER_ID)
        self._kept = replace(self._kept, flags=flags, frames=setup.frames)
        self._last.clear()
        if flags & RX_RTR_FRAME:
            self.stop()
            return
        if flags & SETTIMER:
            self.stop()
            self._kept = replace(
                self._kept, count=setup.count, interval1_s=setup.interval1_s, interval2_s=setup.interval2_s
            )
            self._told_s = 0.0
            self._flush()
        if flags & STARTTIMER:
            self._start_timeout()

    def _place(self, frame: bytes) -> int | None:
        """The index of the frame of RX_SETUP that it is compared with; None: none."""
        frames = self._kept.frames
        if len(frames) < 2:
            return 0
        mask = frames[0][DATA_AT : DATA_AT + _MULTIPLEX]
        seen = frame[DATA_AT : DATA_AT + _MULTIPLEX]
        for place in range(1, len(frames)):
            wanted = frames[place][DATA_AT : DATA_AT + _MULTIPLEX]
            if all(m & a == m & b for m, a, b in zip(mask, seen, wanted, strict=True)):
                return place
        return None

    def _differs(self, place: int, frame: bytes) -> bool:
        last = self._last.get(place)
        if last is None:
            return True
        mask = self._kept.frames[place][DATA_AT:]
        if any(m & a != m & b for m, a, b in zip(mask, frame[DATA_AT:], last[DATA_AT:], strict=True)):
            return True
        return bool(self._kept.flags & RX_CHECK_DLC) and frame[LENGTH_AT] != last[LENGTH_AT]

    def _changed(self, place: int, frame: bytes, stamp_ns: int) -> None:
        self._last[place] = frame
        throttle_s = self._kept.interval2_s
        now_s = self._loop.clock_s()
        if throttle_s and self._throttle is not None:
            self._held[place] = stamp_ns
        elif throttle_s and self._told_s and now_s - self._told_s < throttle_s:
            self._held[place] = stamp_ns
            self._throttle = self._loop.call_at(self._told_s + throttle_s, self._let_through)
        else:
            self._told_s = now_s
            self._tell_changed(frame, stamp_ns)

    def _let_through(self) -> None:
        self._throttle = None
        if self._held:
            self._flush()
            self._told_s = self._loop.clock_s()
            self._throttle = self._loop.call_in(self._kept.interval2_s, self._let_through)
        else:
            self._told_s = 0.0

    def _flush(self) -> None:
        held, self._held = self._held, {}
        for place, stamp_ns in held.items():
            if place in self._last:
                self._tell_changed(self._last[place], stamp_ns)

    def _tell_changed(self, frame: bytes, stamp_ns: int) -> None:
        self._tell(replace(self._kept, opcode=RX_CHANGED, frames=(frame,)), stamp_ns)

    def _start_timeout(self) -> None:
        if self._timeout is not None:
            self._timeout.cancel()
        self._timeout = None
        if self._kept.interval1_s:
            self._timeout = self._loop.call_in(self._kept.interval1_s, self._missed)

    def _missed(self) -> None:
        self._timeout = None
        self._tell(replace(self._kept, opcode=RX_TIMEOUT, frames=()), 0)
        if self._kept.flags & RX_ANNOUNCE_RESUME:
            self._last.clear()
