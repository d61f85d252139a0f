"""The receiving part of a bus: it turns records of the channel's ring into messages, a batch at a time."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import can
from can.bus import LOG

from canwire import BusEvent, CanwireError, Closed, ErrorState, EventKind, HubChannel, LineStatus
from canwire.python_can.clock import HubClock
from canwire.python_can.ending import OPEN_BUSES
from canwire.python_can.messages import take_messages

_BATCH = 128
_RECORD_SIZE = 80


class Receiver:
    """`ready` holds finished messages; without `errors` it contains no error frames.

    `on_state` is called once for each change of the controller's `state` that is received.
    """

    def __init__(
        self,
        channel: HubChannel,
        clock: HubClock,
        name: Any,
        errors: bool,
        on_state: Callable[[BusEvent], object],
        ready: deque[can.Message],
    ) -> None:
        self.ready = ready
        self.watched = False
        self.state = ErrorState.ERROR_ACTIVE
        self._keeps: Callable[[can.Message], bool] | None = None
        self._keeps_until: int | None = None
        self._on_state = on_state
        self._closed = False
        self._end = channel.reading
        self._clock = clock
        self._name = name
        self._errors = errors
        self._virtual = channel.hub.virtual
        self._now_s = channel.hub.clock_s
        self._lock = threading.Lock()

    def begin(self, before: LineStatus, now: LineStatus) -> None:
        """Add an error frame for a change between the status `before` and `now`, which the channel has not received.

        The line was running, so a line that does not run now was stopped by another program.
        """
        self.state = ErrorState(now.state)
        if now.running and (now.state != ErrorState.BUS_OFF or before.state == ErrorState.BUS_OFF):
            return
        missed = BusEvent(EventKind.STATE, now.time_ns, state=self.state, tec=now.tec, rec=now.rec)
        self._make_messages(memoryview(missed.to_record()), self.ready.append, self._on_state)

    def keep(self, keeps: Callable[[can.Message], bool] | None, *, exact: bool) -> None:
        """Keep only such messages from now on. `exact`: the hub filters exactly; test only earlier messages."""
        with self._lock:
            self._keeps = keeps
            self._keeps_until = self._end.ring.written if exact else None
            if keeps is not None:
                kept = [message for message in self.ready if message.is_error_frame or keeps(message)]
                self.ready.clear()
                self.ready.extend(kept)

    def receive(self, timeout: float | None) -> can.Message | None:
        """The oldest message; None after `timeout` seconds, or if the bus is shut down meanwhile.

        Raises CanwireError if no more messages can arrive.
        """
        try:
            self._check()
        except Closed:
            if OPEN_BUSES.outlasts(timeout):
                return None
            raise
        try:
            return self._received(timeout)
        except Closed:
            return None
        except CanwireError:
            if self.watched:
                self._end.quieten()  # reported once, so that an event loop does not spin
            raise

    def drain(self) -> None:
        """The hub or the board is gone: turn into messages what has arrived before."""
        with self._lock:
            while self._take()[0]:
                pass

    def watch(self) -> int:
        """A descriptor that is readable from now on while a message waits."""
        self._check()
        self._end.lease.check()
        self.watched = True
        self.tell()
        return self._end.descriptor.fileno()

    def tell(self) -> None:
        """Update whether the descriptor is readable."""
        self._end.show(bool(self.ready))

    def close(self) -> None:
        """Call this before the channel is closed: a waiting `receive` returns None, later calls raise Closed."""
        self._closed = True
        self.ready.clear()

    def _check(self) -> None:
        if self._closed:
            raise Closed(str(self._name))

    def _received(self, timeout: float | None) -> can.Message | None:
        end_s = None if timeout is None else self._now_s() + timeout
        while True:
            with self._lock:
                moved, events = self._take()
            for event in events:
                self.state = event.state
                self._on_state(event)
            with suppress(IndexError):  # nothing passed the filters, or another thread was quicker
                message = self.ready.popleft()
                if self.watched:
                    self.tell()
                return message
            if moved:
                continue
            if self.watched:
                self.tell()
            left = None if end_s is None else end_s - self._now_s()
            if left is not None and left <= 0:
                self._end.lease.check()
                return None
            if not self._end.wait(left) and self._virtual:
                return None

    def _take(self) -> tuple[bool, list[BusEvent]]:
        """Turn received records into messages; returns whether there were any, and the changes of state."""
        ring = self._end.ring
        blocks = ring.acquire(_BATCH)
        states: list[BusEvent] = []
        if not blocks:
            return False, states
        self._clock.refresh()
        found: list[can.Message] = []
        count = 0
        for block in blocks:
            self._make_messages(block, found.append, states.append)
            count += len(block) // _RECORD_SIZE
        ring.release(count)
        keeps = self._keeps
        if keeps is not None:
            found = [message for message in found if message.is_error_frame or keeps(message)]
            if self._keeps_until is not None and ring.taken >= self._keeps_until:
                self._keeps = None  # the hub sorts by itself what came after that
        if LOG.isEnabledFor(can.BusABC.RECV_LOGGING_LEVEL):
            for message in found:
                LOG.log(can.BusABC.RECV_LOGGING_LEVEL, "Received: %s", message)
        self.ready.extend(found)
        return True, states

    def _make_messages(
        self,
        block: memoryview,
        append: Callable[[can.Message], object],
        tell: Callable[[BusEvent], object],
    ) -> None:
        take_messages(block, self._clock.epoch_ns, self._name, append, tell, errors=self._errors)
