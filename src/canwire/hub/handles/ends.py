"""A client's end of a ring that it shares with the hub or another client."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.errors import WrongState
from canwire.hub.handles.lease import Lease
from canwire.hub.handles.lent import LentMemory, LentRing
from canwire.platform import EventDescriptor
from canwire.ring import Ring
from canwire.values.checks import nanoseconds

if TYPE_CHECKING:
    from canwire.hub.handles.event import Event

Advance = Callable[[Callable[[], bool], float | None], bool]


class RingEnd:
    """One end of a ring. Once its lease is over, `check` raises, and waiting threads wake up.

    An Event assigned to the reading end is signalled by each write that leaves `threshold` records, and one assigned
    to the writing end by each read that leaves room for `threshold` (source: rulings 8).
    """

    def __init__(
        self,
        lease: Lease,
        ring: Ring,
        descriptor: EventDescriptor,
        *,
        reads: bool,
        memory: LentMemory | None = None,
        begin: int = 0,
    ) -> None:
        """`memory` contains the ring from byte `begin` on, for `lend`."""
        self._memory = memory
        self._begin = begin
        self._over_told: Callable[[], object] | None = None
        self.lease = lease
        self.ring = ring
        self.reads = reads
        self._own = descriptor
        self._event: Event | None = None
        self._lock = threading.Lock()
        self._waiting = 0  # threads in `wait`, whose last one closes the descriptor
        self._closed = False
        if reads:
            ring.event = descriptor
        else:
            ring.free_event = descriptor

    @property
    def descriptor(self) -> EventDescriptor:
        """The descriptor that the other side signals."""
        return self._own

    @property
    def advance(self) -> Advance | None:
        """See hub/handles/event.py, Signal."""
        return self.lease.hub.advance if self.lease.hub.virtual else None

    @property
    def clock(self) -> Callable[[], int] | None:
        """See hub/handles/event.py, Signal."""
        return self.lease.hub.now_ns if self.lease.hub.virtual else None

    @property
    def threshold(self) -> int:
        """Records (reading) or room for records (writing) at which events and waiters are woken; 1..capacity."""
        return int(self.ring.threshold if self.reads else self.ring.free_threshold)

    @threshold.setter
    def threshold(self, count: int) -> None:
        count = max(1, min(count, self.ring.capacity))
        if self.reads:
            self.ring.threshold = count
        else:
            self.ring.free_threshold = count
        if self._event is not None:
            self.rearm()

    def assign(self, event: Event | None) -> None:
        """Signal this event from now on, instead of an earlier one; None: no event."""
        if self._event is not None:
            self._event.unbind(self)
        self._event = event
        if event is not None:
            self._own.clear()  # what was signalled before it was assigned is not meant for it
            event.bind(self)
            self.rearm()

    def rearm(self) -> None:
        """Request a signal from the other side at the next change from the present state."""
        if self.reads:
            self.ring.fill()
        else:
            self.ring.free()
        self._arm()

    def touched(self) -> None:
        """Records were read or written here: the event is signalled at the next change after that."""
        if self._event is not None:
            self._arm()

    def wait(self, timeout: float | None) -> bool:
        """Block until the threshold is met, at most `timeout` seconds (None: no limit); raises if the lease ends."""
        if timeout is not None:
            timeout = nanoseconds("timeout", timeout) / 1e9
        self.lease.check()
        with self._lock:
            if self._closed:
                return False
            self._waiting += 1
        try:
            if self.lease.hub.virtual:
                self.lease.hub.advance(self._met_or_armed, timeout)
            elif self.reads:
                self.ring.sleep(timeout, self._over)
            else:
                self.ring.sleep_until_free(timeout, self._over)
            self.touched()
            met = self._met()
        finally:
            self._waited()
        if not (met and self.reads):  # what has come can still be read, but nothing more goes out
            self.lease.check()
        return met

    def lend(self, told: Callable[[], object]) -> LentRing:
        """Let another process use this end; `told` is called once the end or its lease is over.

        Raises WrongState unless the connection lends queues (Client.lends).
        """
        peer = self.ring.free_event if self.reads else self.ring.event
        if self._memory is None or not isinstance(peer, EventDescriptor | None):
            raise WrongState(f"{self.lease.name}: its connection does not lend queues to other processes")
        self._over_told = told
        return LentRing(self._memory, self._begin, self._own, peer)

    def wake(self) -> None:
        """The lease is over: wake all waiting threads."""
        if self._over_told is not None:
            self._over_told()
        with self._lock:
            if not self._closed:
                self._own.signal()
                self.stir()

    def stir(self) -> None:
        """See hub/handles/event.py, Signal."""
        self.lease.hub.stir()

    def show(self, more: bool) -> None:
        """Make the descriptor readable while the threshold is met, or with `more`; no effect once the lease is over."""
        with self._lock:
            if self._closed or self.lease.over:
                return  # the cause of the signal stays until it was reported
            self._own.clear()
            if more or self._met():
                self._own.signal()
            else:
                self._arm()

    def quieten(self) -> None:
        """Clear the signal that reported the end of the lease."""
        with self._lock:
            self._own.clear()

    def contents(self) -> str:
        """How full the ring is, as text."""
        ring = self.ring
        return f"{ring.contents()} of {ring.capacity} {'received' if self.reads else 'to send'}"

    def __repr__(self) -> str:
        return f"<end of {self.lease.name}'s queue: {'closed' if self._closed else self.contents()}>"

    def leave_to_parent(self) -> None:
        """In a fork, use a private ring that is empty and full. This uses no locks, see Client."""
        self._event = None
        self._lock = threading.Lock()
        self.ring.close()

    def close(self) -> None:
        """Close the end and wake the threads that wait; a second call has no effect."""
        if self._over_told is not None and not self._closed:
            self._over_told()
            self._own.signal()
        self.assign(None)
        with self._lock:
            closed, self._closed = self._closed, True
            if self._waiting:
                self._own.signal()
                if not self.lease.hub.lost:
                    self.stir()
            elif not closed:
                self._own.close()
        self.ring.close()

    def _waited(self) -> None:
        """A thread has stopped waiting; if the end is closed, wake the other threads one after the other."""
        with self._lock:
            self._waiting -= 1
            if self._waiting and self._over():
                self._own.signal()
            elif self._closed:
                self._own.close()

    def _met(self) -> bool:
        if self.reads:
            return self.ring.fill() >= self.ring.threshold
        return self.ring.free() >= self.ring.free_threshold

    def _met_or_armed(self) -> bool:
        if self._met() or self._over():
            return True
        self._arm()  # the signal also ends the passing of virtual time
        return False

    def _over(self) -> bool:
        return self._closed or self.lease.over

    def _arm(self) -> None:
        if self.reads:
            self.ring.arm()
        else:
            self.ring.arm_free()
