"""The sending part of a bus: it puts records into the channel's ring, and waits for room there."""

from __future__ import annotations

import threading

from can import CanOperationError, CanTimeoutError

from canwire import ErrorState, HubChannel, LineStatus
from canwire.python_can.company import Company
from canwire.python_can.receiver import Receiver

_SILENT = (ErrorState.BUS_OFF, ErrorState.STOPPED)
_LOOK_S = 0.5  # while a thread waits for room: interval of checks whether the line still runs
_STUCK_S = 0.2  # messages that make no progress for this long are discarded at the end
_FLUSH_LOOK_S = 0.002


class Sender:
    """The sending end of a channel, for any number of threads."""

    def __init__(self, channel: HubChannel, receiver: Receiver, company: Company) -> None:
        self._channel = channel
        self._now_s = channel.hub.clock_s
        self._receiver = receiver
        self._company = company
        self._taken, self._taken_s = -1, 0.0
        self._end = channel.writing
        self._end.threshold = self._end.ring.capacity // 8  # who waits for room gets some
        self._lock = threading.Lock()

    def send(self, record: bytes, timeout: float | None) -> None:
        """Queue a record; wait for room as described for CanwireBus.send."""
        ring = self._end.ring
        with self._lock:
            self._channel.check()
            free = ring.free()
            if free < ring.capacity or self._receiver.state in _SILENT:
                self._check_moving()
            else:
                self._taken, self._taken_s = ring.taken, self._now_s()
            if not free:
                self._wait_for_room(timeout)
            ring.put_bytes(record)

    def left(self) -> int:
        """The hub or the board is gone: how many messages it had not taken."""
        with self._lock:
            return self._end.ring.fill()

    def flush(self) -> None:
        """Wait until all messages were sent; if they make no progress, log that and return."""
        hub = self._channel.hub
        before, end_s = -1, 0.0
        while pending := self._channel.status().pending:
            if pending != before:
                before, end_s = pending, self._now_s() + _STUCK_S
            elif self._now_s() >= end_s:
                self._company.gave_up(pending, _why(self._status()))
                return
            hub.sleep(_FLUSH_LOOK_S)

    def _check_moving(self) -> None:
        """Raise CanOperationError if waiting messages could never be sent; checked after a while without progress."""
        taken, now_s = self._end.ring.taken, self._now_s()
        if self._receiver.state not in _SILENT:
            if taken != self._taken:
                self._taken, self._taken_s = taken, now_s
            if now_s - self._taken_s < _LOOK_S:
                return
            self._taken_s = now_s
        self._check_able(self._status())

    def _check_able(self, status: LineStatus) -> None:
        self._company.look(status)
        self._receiver.state = ErrorState(status.state)
        if not status.running or status.state == ErrorState.BUS_OFF:
            raise CanOperationError(f"{self._channel.name}: {_why(status)}")

    def _wait_for_room(self, timeout: float | None) -> None:
        """Wait with the lock held, so that records keep the order of the calls."""
        ring = self._end.ring
        end_s = None if timeout is None else self._now_s() + timeout
        while not ring.free():
            left = _LOOK_S if end_s is None else min(_LOOK_S, end_s - self._now_s())
            if left <= 0:
                what = f"{self._channel.name}: {ring.capacity} messages already wait"
                if not timeout:
                    raise CanOperationError(f"{what}; {_why(self._status())}")
                raise CanTimeoutError(f"{what}, and none was sent in {timeout:g} s; {_why(self._status())}")
            if not self._end.wait(left) and not ring.free():
                self._check_able(self._status())

    def _status(self) -> LineStatus:
        return self._channel.hub.line_status(self._channel.board, self._channel.line)


def _why(status: LineStatus) -> str:
    if status.obstacle:
        return status.obstacle
    if not status.running:
        return f"the line does not run; its control is held by {status.control_holder or 'no program'}"
    if status.mode is not None and status.mode.listen_only:
        return "the line is in listen-only mode"
    if status.state == ErrorState.BUS_OFF:
        return "the line is bus-off; set state = BusState.ACTIVE to restart it"
    return f"{ErrorState(status.state).name.lower().replace('_', ' ')}, TEC {status.tec}"
