"""The copy of a ring at the other end of a link; mirrors.py contains the original. No I/O; any thread may call."""

from __future__ import annotations

import threading
from collections.abc import Callable

from canwire.errors import BadMessage
from canwire.hub.links.network.cuts.age import Age
from canwire.hub.links.network.flow.way import WINDOW
from canwire.hub.links.network.wire import Report
from canwire.ring import Ring

REPORT_NS = 2_000_000  # between two reports of records taken one by one
_AGAIN_NS = 10_000_000  # before the same records are asked for once more
_EIGHTH = 8


class Incoming:
    """The end of a ring that is filled with the records that arrive.

    Commands older than `age` are discarded instead: `give_up` is called with their number, and their age in s.
    """

    def __init__(
        self,
        number: int,
        ring: Ring,
        age: Age | None = None,
        give_up: Callable[[int, float], object] = lambda count, age_s: None,
    ) -> None:
        self.number = number
        self._age = age
        self._give_up = give_up
        self._ring = ring
        self._lock = threading.Lock()
        self._origin = ring.taken
        self._told_received = self.received
        self._told_taken = 0
        self._told_ns = -REPORT_NS
        self._missing = False
        self._asked = False
        # what was asked for, and when: what is under way behind a gap is no reason to ask
        self._again = (-1, 0)
        self._worth_telling = max(1, min(WINDOW // ring.record_size, ring.capacity) // 4)
        self._eighth = max(1, ring.capacity // _EIGHTH)

    @property
    def received(self) -> int:
        return self._ring.written - self._origin

    @property
    def filled(self) -> int:
        """Records in the ring."""
        return self._ring.contents()

    @property
    def taken(self) -> int:
        return self._ring.taken - self._origin

    @property
    def wanted(self) -> int:
        """The position that must arrive before the program is notified; 0: the program does not wait."""
        goal = self._ring.wanted
        return goal and goal - self._origin

    def want(self, goal: int) -> bool:
        """Notify the original's writer once `goal` records are taken (0: never); returns whether they are."""
        with self._lock:
            if goal == 0:
                return False
            here = self.taken >= goal
            self._ring.free_threshold = max(1, goal - (self.received - self._ring.capacity))
            self._ring.arm_free()
            return here

    def accept(self, first: int, records: memoryview, stamp: int = 0, now_ns: int = 0) -> bool:
        """Add the records; returns whether to report immediately. Raises BadMessage if they do not fit."""
        with self._lock:
            at = self.received
            if first > at:
                self._missing = True
                return True
            size = self._ring.record_size
            rest = records[(at - first) * size :]
            if len(rest) % size or len(rest) > self._ring.free() * size:
                raise BadMessage(
                    f"ring {self.number}: {len(rest)} bytes, room for {self._ring.free()} records"
                )
            age_s = 0.0 if self._age is None else self._age.over_s(stamp, now_ns)
            if age_s and rest:
                self._origin -= len(rest) // size  # they count as come and taken
                self._give_up(len(rest) // size, age_s)
                rest = rest[:0]
            while rest:
                room = self._ring.acquire_free(len(rest) // size)
                room[:] = rest[: len(room)]
                self._ring.commit(len(room) // size)
                rest = rest[len(room) :]
            return self.received - self._told_received >= self._worth_telling

    def sent(self, position: int) -> None:
        """The other end has sent records up to `position`, and requests a report."""
        with self._lock:
            self._asked = True
            self._missing |= position > self.received

    def report(self, now_ns: int, *, at_once: bool = False) -> Report | None:
        """The report to send now, None: nothing to report; `at_once` reports every change."""
        with self._lock:
            received, taken = self.received, self._ring.taken - self._origin
            again = self._missing and (received != self._again[0] or now_ns >= self._again[1] + _AGAIN_NS)
            due = self._asked or again or received - self._told_received >= self._worth_telling
            fresh = taken - self._told_taken
            due |= fresh >= self._eighth or (fresh > 0 and (at_once or now_ns >= self._told_ns + REPORT_NS))
            if not due:
                return None
            if again:
                self._again = received, now_ns
            made = Report(self.number, received, taken, again)
            self._told_received, self._told_taken = received, taken
            self._told_ns = now_ns
            self._missing = self._asked = False
            return made

    def arm(self, now_ns: int) -> int | None:
        """Arm the ring's other event for something to report. Returns when to check without the event."""
        with self._lock:
            free = self._ring.free()
            fresh = self._ring.taken - self._origin - self._told_taken
            patient = fresh > 0 or now_ns < self._told_ns + REPORT_NS
            wanted = max(1, self._eighth - fresh) if patient else 1
            self._ring.free_threshold = max(1, min(self._ring.capacity, free + wanted))
            self._ring.arm_free()
            return self._told_ns + REPORT_NS if patient else None

    def close(self) -> None:
        self._ring.event = self._ring.free_event = None
        self._ring.close()
