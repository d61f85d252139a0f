"""The receiving side of an ISO-TP socket: it joins frames to messages and sends flow control.

Source: ISO 15765-2:2016 9.6 to 9.8; errors, and frames that are ignored, are those of the kernel.
"""

from __future__ import annotations

import errno
from collections.abc import Callable

from canwire.socketcan.isotp import layout
from canwire.socketcan.isotp.options import (
    CF_BROADCAST,
    FORCE_RXSTMIN,
    LARGEST_PDU,
    LENGTHS,
    LISTEN_MODE,
    Options,
)
from canwire.socketcan.isotp.sender import Cancellable, Timers

_TIMEOUT_S = 1.0  # N_Cr
_SHORTEST_SHORT = 7  # a first frame is for more than a single one takes


class Receiver:
    """`put` sends a flow control; `deliver` gets each message with its time, `fail` an errno for an incomplete one."""

    def __init__(
        self,
        timers: Timers,
        put: Callable[[bytes], object],
        deliver: Callable[[bytes, int], object],
        fail: Callable[[int], object],
    ) -> None:
        self.options = Options()
        self._timers = timers
        self._put = put
        self._deliver = deliver
        self._fail = fail
        self._timer: Cancellable | None = None
        self._parts = bytearray()
        self._size = 0  # of the message that is on its way; 0: none
        self._frame_size = 0
        self._number = 0
        self._block = 0
        self._last_ns = 0

    def take(self, frame: bytes, stamp_ns: int) -> None:
        """Process the data of a frame whose address was already checked."""
        body = frame[self.options.extended :]
        if not body:
            return
        kind = body[0] & 0xF0
        if kind == layout.SINGLE:
            self._take_single(frame, body, stamp_ns)
        elif kind == layout.FIRST and len(body) > 1:
            self._take_first(frame, body, stamp_ns)
        elif kind == layout.CONSECUTIVE:
            self._take_consecutive(frame, body, stamp_ns)

    def stop(self) -> None:
        """The socket is closed, or its line is gone; nothing is reported."""
        self._size = 0
        self._cancel()

    def _take_single(self, frame: bytes, body: bytes, stamp_ns: int) -> None:
        self.stop()
        head, size = 1, body[0] & 0xF
        if len(frame) > 8:
            if size or len(body) < 2:
                return
            head, size = 2, body[1]
        if not size or size > len(body) - head:
            return
        if not layout.well_padded(self.options, frame, self.options.extended + head + size):
            self._fail(errno.EBADMSG)
            return
        self._deliver(body[head : head + size], stamp_ns)

    def _take_first(self, frame: bytes, body: bytes, stamp_ns: int) -> None:
        self.stop()
        if len(frame) not in LENGTHS:
            return
        head, size = 2, (body[0] & 0xF) << 8 | body[1]
        if size == 0:
            head, size = 6, int.from_bytes(body[2:6], "big")
        if size <= _SHORTEST_SHORT - self.options.extended or size <= len(body) - head:
            return
        listens = self.options.flags & (LISTEN_MODE | CF_BROADCAST)
        if size > LARGEST_PDU:
            if not listens:
                self._put(layout.flow_control(self.options, layout.OVERFLOW))
            return
        self._parts = bytearray(body[head:])
        self._size, self._frame_size = size, len(frame)
        self._number, self._last_ns = 1, stamp_ns
        if listens:
            self._block = 0
            self._wait()
        else:
            self._ask_for_more()

    def _take_consecutive(self, frame: bytes, body: bytes, stamp_ns: int) -> None:
        options = self.options
        if not self._size:
            return
        if options.flags & FORCE_RXSTMIN and stamp_ns - self._last_ns < options.rx_stmin_ns:
            return
        self._last_ns = stamp_ns
        left = self._size - len(self._parts)
        room = self._frame_size - options.extended - 1
        if len(frame) > self._frame_size or (len(frame) < self._frame_size and left > room):
            return
        if body[0] & 0xF != self._number & 0xF:
            self.stop()
            self._fail(errno.EILSEQ)
            return
        self._number += 1
        self._parts += body[1 : 1 + left]
        if len(self._parts) < self._size:
            self._went_on()
        else:
            self._complete(frame, min(left, room), stamp_ns)

    def _complete(self, frame: bytes, taken: int, stamp_ns: int) -> None:
        parts = bytes(self._parts)
        self.stop()
        if not layout.well_padded(self.options, frame, self.options.extended + 1 + taken):
            self._fail(errno.EBADMSG)
            return
        self._deliver(parts, stamp_ns)

    def _went_on(self) -> None:
        if self._block:
            self._block -= 1
            if not self._block:
                self._ask_for_more()
                return
        self._wait()

    def _ask_for_more(self) -> None:
        self._put(layout.flow_control(self.options, layout.CONTINUE))
        self._block = self.options.block_size
        self._wait()

    def _wait(self) -> None:
        self._cancel()
        self._timer = self._timers.call_in(_TIMEOUT_S, self._too_late)

    def _too_late(self) -> None:
        self.stop()
        self._fail(errno.ETIMEDOUT)

    def _cancel(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
