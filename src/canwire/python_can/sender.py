"""What a bus sends: records into its channel's ring, and waiting for room there."""

from __future__ import annotations

import threading
import time

from can import CanOperationError, CanTimeoutError

from canwire import ErrorState, HubChannel, LineStatus

_LOOK_S = 0.5  # whoever waits for room looks so often whether the line still runs
_STUCK_S = 0.2  # what has not got any further for so long is given up at the end
_FLUSH_LOOK_S = 0.002


class Sender:
    """The sending end of a channel, for any number of threads."""

    def __init__(self, channel: HubChannel) -> None:
        self._channel = channel
        self._end = channel.writing
        self._end.threshold = self._end.ring.capacity // 8  # who waits for room gets some
        self._lock = threading.Lock()

    def send(self, record: bytes, timeout: float | None) -> None:
        """Queue it, waiting for room as CanwireBus.send says."""
        self._channel.check()
        ring = self._end.ring
        with self._lock:
            if not ring.free():
                self._wait_for_room(timeout)
            ring.put_bytes(record)

    def flush(self) -> None:
        """Wait until the bus has taken everything, or gets no further."""
        hub = self._channel.hub
        before, end_s = -1, 0.0
        while pending := self._channel.status().pending:
            if pending != before:
                before, end_s = pending, time.monotonic() + _STUCK_S
            elif time.monotonic() >= end_s:
                return
            if hub.virtual:
                hub.run_for(_FLUSH_LOOK_S)
            else:
                time.sleep(_FLUSH_LOOK_S)

    def _wait_for_room(self, timeout: float | None) -> None:
        """Holding the lock: who comes later sends later."""
        ring = self._end.ring
        end_s = None if timeout is None else time.monotonic() + timeout
        while not ring.free():
            left = _LOOK_S if end_s is None else min(_LOOK_S, end_s - time.monotonic())
            if left <= 0:
                what = f"{self._channel.name}: {ring.capacity} messages wait already"
                if not timeout:
                    raise CanOperationError(f"{what}; {_why(self._status())}")
                raise CanTimeoutError(f"{what}, and none went out in {timeout:g} s; {_why(self._status())}")
            if not self._end.wait(left) and not ring.free():
                status = self._status()
                if not status.running or status.state == ErrorState.BUS_OFF:
                    raise CanOperationError(f"{self._channel.name}: {_why(status)}")

    def _status(self) -> LineStatus:
        return self._channel.hub.line_status(self._channel.board, self._channel.line)


def _why(status: LineStatus) -> str:
    if not status.running:
        return f"the line does not run; its control is held by {status.control_holder or 'nobody'}"
    if status.mode is not None and status.mode.listen_only:
        return "the line only listens"
    if status.state == ErrorState.BUS_OFF:
        return "bus-off; state = BusState.ACTIVE begins again"
    return f"{ErrorState(status.state).name.lower().replace('_', ' ')}, TEC {status.tec}"
