"""What a bus receives: records of its channel's ring, turned into messages a batch at a time."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import can
from can.bus import LOG

from canwire import CanwireError, HubChannel
from canwire.python_can.clock import HubClock
from canwire.python_can.messages import take_messages

_BATCH = 128
_RECORD_SIZE = 80


class Receiver:
    """`ready` holds messages that are made already; `keeps` says which ones, None: all."""

    def __init__(self, channel: HubChannel, clock: HubClock, name: Any, errors: bool) -> None:
        self.ready: deque[can.Message] = deque()
        self.keeps: Callable[[can.Message], bool] | None = None
        self.watched = False
        self._end = channel.reading
        self._clock = clock
        self._name = name
        self._errors = errors
        self._virtual = channel.hub.virtual
        self._lock = threading.Lock()

    def receive(self, timeout: float | None) -> can.Message | None:
        """The oldest message, None when the time is over; raises CanwireError once nothing more will come."""
        try:
            return self._received(timeout)
        except CanwireError:
            if self.watched:
                self._end.descriptor.clear()  # told once; no event loop need turn for it for ever
            raise

    def watch(self) -> int:
        """From now on this descriptor is readable while there is something to receive."""
        self._end.lease.check()
        self.watched = True
        self.tell()
        return self._end.descriptor.fileno()

    def tell(self) -> None:
        """Have the descriptor say what is so."""
        if self._end.lease.over:
            return  # it was signalled then, and stays so until that was told
        descriptor, ring = self._end.descriptor, self._end.ring
        descriptor.clear()
        if self.ready or ring.fill():
            descriptor.signal()
        else:
            ring.arm()

    def _received(self, timeout: float | None) -> can.Message | None:
        end_s = None if timeout is None else time.monotonic() + timeout
        while True:
            with self._lock:
                moved = self._take()
            with suppress(IndexError):  # nothing passed the filters, or another thread was quicker
                message = self.ready.popleft()
                if self.watched:
                    self.tell()
                return message
            if moved:
                continue
            if self.watched:
                self.tell()
            left = None if end_s is None else end_s - time.monotonic()
            if left is not None and left <= 0:
                self._end.lease.check()
                return None
            if not self._end.wait(left) and self._virtual:
                return None

    def _take(self) -> bool:
        """Turn what has come into messages; False if nothing had."""
        ring = self._end.ring
        blocks = ring.acquire(_BATCH)
        if not blocks:
            return False
        self._clock.refresh()
        found: list[can.Message] = []
        count = 0
        for block in blocks:
            take_messages(block, self._clock.epoch_ns, self._name, found.append, errors=self._errors)
            count += len(block) // _RECORD_SIZE
        ring.release(count)
        if self.keeps is not None:
            found = [message for message in found if message.is_error_frame or self.keeps(message)]
        if LOG.isEnabledFor(can.BusABC.RECV_LOGGING_LEVEL):
            for message in found:
                LOG.log(can.BusABC.RECV_LOGGING_LEVEL, "Received: %s", message)
        self.ready.extend(found)
        return True
