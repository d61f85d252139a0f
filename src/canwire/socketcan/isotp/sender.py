"""The sending side of an ISO-TP socket: one message at a time, paced by the receiver.

Times begin when a frame is on the bus: `confirm` is called for each frame that came back from the bus.
Source: ISO 15765-2:2016 9.7 and 9.8; errors are those of the kernel.
"""

from __future__ import annotations

import errno
from collections.abc import Callable
from enum import Enum
from typing import Protocol

from canwire.socketcan.isotp import layout
from canwire.socketcan.isotp.options import (
    CF_BROADCAST,
    FORCE_TXSTMIN,
    SF_BROADCAST,
    USUAL_FRAME_TIME_NS,
    Options,
)

_TIMEOUT_S = 1.0  # N_Bs
_WINDOW = 32  # frames that wait for the bus where no separation time is asked for


class Cancellable(Protocol):
    def cancel(self) -> None: ...


class Timers(Protocol):
    """loop.py's."""

    def call_in(self, seconds: float, call: Callable[[], object]) -> Cancellable: ...


class State(Enum):
    IDLE = 0
    ENDING = 1  # the last frame is on its way
    WAITING = 2  # for flow control
    SENDING = 3


class Sender:
    """`put` sends one frame's data; `over` is called once for each message, with 0 or an errno."""

    def __init__(
        self,
        timers: Timers,
        put: Callable[[bytes], object],
        over: Callable[[int], object],
    ) -> None:
        self.options = Options()
        self.state = State.IDLE
        self._timers = timers
        self._put = put
        self._over = over
        self._timer: Cancellable | None = None
        self._left = b""
        self._number = 0
        self._block: int | None = None  # frames until the next flow control; None: none will come
        self._gap_ns = 0
        self._unconfirmed = 0
        self._waits = 0

    def fits(self, size: int) -> bool:
        """True if a message of this size can be sent (without a receiver that answers: only in a single frame)."""
        alone = self.options.flags & SF_BROADCAST
        return size > 0 and (not alone or layout.single(self.options, bytes(size)) is not None)

    def send(self, data: bytes) -> None:
        """Begin a message; only while IDLE."""
        whole = layout.single(self.options, data)
        self._waits = 0
        if whole is not None:
            self._left = b""
            self._end_with(whole)
            return
        frame, taken = layout.first(self.options, data)
        self._left, self._number = data[taken:], 1
        self._emit(frame)
        if self.options.flags & CF_BROADCAST:
            self._start_block(None, self.options.tx_stmin_ns)
        else:
            self.state = State.WAITING

    def confirm(self, count: int) -> None:
        """Note that `count` frames from `put` were on the bus."""
        self._unconfirmed = max(0, self._unconfirmed - count)
        if self.state is State.ENDING and not self._unconfirmed:
            self._finish(0)
        elif self.state is State.WAITING and not self._unconfirmed and self._timer is None:
            self._wait_for_flow_control()
        elif self.state is State.SENDING:
            self._go_on()

    def flow_control(self, frame: bytes) -> None:
        """Process a flow control, whose address bytes were removed."""
        if self.state is not State.WAITING:
            return
        if len(frame) < 3:
            self._finish(errno.EBADMSG)
            return
        self._cancel()
        status = frame[0] & 0xF
        if status == layout.CONTINUE:
            gap_ns = layout.gap_ns(frame[2])
            if self.options.flags & FORCE_TXSTMIN:
                gap_ns = self.options.tx_stmin_ns
            self._start_block(frame[1] or None, gap_ns)
        elif status == layout.WAIT:
            self._wait_for_flow_control()
        else:
            self._finish(errno.EMSGSIZE if status == layout.OVERFLOW else errno.EBADMSG)

    def stop(self) -> None:
        """The socket is closed, or its line is gone; nothing is reported."""
        self._cancel()
        self.state = State.IDLE

    def _start_block(self, frames: int | None, gap_ns: int) -> None:
        self._block = frames
        frame_ns = self.options.frame_time_ns
        self._gap_ns = gap_ns + (frame_ns if frame_ns > USUAL_FRAME_TIME_NS else 0)
        self.state = State.SENDING
        self._go_on()

    def _go_on(self) -> None:
        """Sends as many frames as may be on their way; with a gap, one after each that was on the bus."""
        if self._gap_ns:
            if not self._unconfirmed and self._timer is None:
                self._timer = self._timers.call_in(self._gap_ns / 1e9, self._next_after_gap)
            return
        while self.state is State.SENDING and self._unconfirmed < _WINDOW:
            self._next()

    def _next_after_gap(self) -> None:
        self._timer = None
        self._next()

    def _next(self) -> None:
        frame, taken = layout.consecutive(self.options, self._number, self._left)
        self._left = self._left[taken:]
        self._number += 1
        if not self._left:
            self._end_with(frame)
            return
        self._emit(frame)
        if self._block is not None:
            self._block -= 1
            if self._block == 0:
                self.state = State.WAITING

    def _end_with(self, frame: bytes) -> None:
        self.state = State.ENDING
        self._emit(frame)

    def _emit(self, frame: bytes) -> None:
        self._unconfirmed += 1
        self._put(frame)

    def _wait_for_flow_control(self) -> None:
        self._cancel()
        self._timer = self._timers.call_in(_TIMEOUT_S, lambda: self._finish(errno.ECOMM))

    def _finish(self, error: int) -> None:
        self._cancel()
        self.state = State.IDLE
        self._unconfirmed = 0
        self._over(error)

    def _cancel(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
