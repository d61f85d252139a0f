"""A ring and its copy at the other end of a link: what was written there appears here, what was taken here goes there.

Both have the same capacity, and a record stays in the original until the copy's reader has taken it. So the original
fills up and counts what it loses just as if its reader were here, and whatever the link loses is still there to be
sent again, but for commands that have become too old. No I/O, time handed in; any thread may call.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from canwire.errors import BadMessage
from canwire.hub.links.network import wire
from canwire.hub.links.network.cuts.age import Age, OtherClock
from canwire.hub.links.network.wire import Report
from canwire.ring import Ring

BATCH = 64  # records sent together at most (MANY times that where as many wait: each payload costs time) ...
HOLD_NS = 1_000_000  # ... or those that came within so long ...
AT_ONCE = 4  # ... once there were so many smaller batches in that time
WINDOW = 1 << 19  # bytes under way at most, that nobody has said to have come
REPORT_NS = 2_000_000  # between two reports of records taken one by one
_LARGEST_BATCH = 1 << 16
MANY = 4
_MOST = 32  # batches made at a time ...
FULL = _MOST // MANY  # ... which are so many payloads at least, and fewer are all that there is
_AGAIN_NS = 10_000_000  # before the same records are asked for once more
_EIGHTH = 8
_MOMENT_NS = 20_000_000


class Outgoing:
    """The end of a ring whose records are sent; a `filled` ring has so many that the other end has already.

    With the other end's `clock` they are commands, each sent with when it was given.
    """

    def __init__(self, number: int, ring: Ring, filled: int = 0, clock: OtherClock | None = None) -> None:
        self._clock = clock
        self._given: deque[tuple[int, int]] = deque()  # up to which position, and by when at the latest
        self.number = number
        self._ring = ring
        self._lock = threading.Lock()
        self._origin = ring.taken
        self._sent = self._received = filled
        self._began_ns = -HOLD_NS  # the span of HOLD_NS that ...
        self._batches = 0  # ... so many batches went out in
        self._window = max(1, WINDOW // ring.record_size)
        most = max(1, _LARGEST_BATCH // ring.record_size)
        self._batch, self._many = min(BATCH, most), min(MANY * BATCH, most)

    @property
    def sent(self) -> int:
        return self._sent

    @property
    def written(self) -> int:
        """Where the ring's writer is."""
        return self._ring.written - self._origin

    @property
    def unconfirmed(self) -> bool:
        """Something was sent that has not come, as far as is known."""
        return self._sent != self._received

    def batches(self, now_ns: int, *, at_once: bool = False) -> list[bytes]:
        """What is to be sent now; `at_once` does not wait for more."""
        with self._lock:
            unsent = self._unsent()
            if self._clock is not None:
                self._mark(self._sent + unsent, now_ns)
            count = min(unsent, _MOST * self._batch, self._window - (self._sent - self._received))
            if not at_once and count % self._batch and self._holds(now_ns):
                count -= count % self._batch
            if count <= 0:
                return []
            if now_ns >= self._began_ns + HOLD_NS:
                self._began_ns, self._batches = now_ns, 0
            self._batches += 1
            return self._cut(count)

    def acknowledge(self, report: Report) -> None:
        """The copy is so far; raises BadMessage for what cannot be."""
        with self._lock:
            taken = self._ring.taken - self._origin
            if not (report.taken <= report.received <= taken + self._ring.fill()):
                raise BadMessage(f"ring {self.number}: {report} of {self.written} records")
            self._received = max(self._received, report.received)
            self._sent = max(self._sent, self._received)
            if report.again:
                self._sent = self._received
            if report.taken > taken:
                self._ring.release(report.taken - taken)

    def arm(self, now_ns: int) -> int | None:
        """Have the ring's event signalled when there is something to send; when to look without it, None: never."""
        with self._lock:
            waiting = self._unsent() if self._sent - self._received < self._window else 0
            held = self._sent - (self._ring.taken - self._origin)
            holding = waiting > 0 or self._holds(now_ns)
            wanted = self._batch if holding else 1
            self._ring.threshold = max(1, min(self._ring.capacity, held + wanted))
            self._ring.arm()
            return self._began_ns + HOLD_NS if holding else None

    @property
    def wanted(self) -> int:
        """How much the copy's reader has to have taken for the program to be told, 0: nobody waits for that."""
        goal = self._ring.free_wanted
        return goal and goal - self._origin

    def want(self, taken: int, goal: int) -> bool:
        """The copy's reader has taken so many, and is to be told at so many written (0: never); are they here?"""
        self.acknowledge(Report(self.number, taken, taken, False))
        with self._lock:
            if goal == 0:
                self._ring.disarm()
                return False
            here = self.written >= goal
            self._ring.threshold = max(1, goal - (self._ring.taken - self._origin))
            self._ring.arm()
            return here

    def close(self) -> None:
        self._ring.event = self._ring.free_event = None
        self._ring.close()

    def _holds(self, now_ns: int) -> bool:
        """There were so many small batches that the next one should be larger."""
        return now_ns < self._began_ns + HOLD_NS and self._batches >= AT_ONCE

    def _unsent(self) -> int:
        return self._ring.taken - self._origin + self._ring.fill() - self._sent

    def _cut(self, count: int) -> list[bytes]:
        """So many records that were not sent yet, in batches."""
        size = self._ring.record_size
        step = size * (self._many if count >= self._many else self._batch)
        skip = (self._sent - (self._ring.taken - self._origin)) * size
        found = []
        for block in self._ring.acquire(skip // size + count):
            at = skip
            while at < len(block):
                alike, stamp = self._alike()
                records = block[at : at + min(step, alike * size)]
                found.append(wire.frames(self.number, self._sent, records, stamp))
                self._sent += len(records) // size
                at += len(records)
            skip = max(0, skip - len(block))
        return found

    def _mark(self, end: int, now_ns: int) -> None:
        """Commands up to there have been given by now; those of one moment are marked together."""
        given = self._given
        while given and given[0][0] <= self._received:
            given.popleft()
        last, at_ns = given[-1] if given else (self._received, -_MOMENT_NS)
        if end > last and now_ns < at_ns + _MOMENT_NS:
            given[-1] = end, at_ns
        elif end > last:
            given.append((end, now_ns))

    def _alike(self) -> tuple[int, int]:
        """How many of the records that are to be sent next were given at the same time, and its stamp."""
        for end, at_ns in self._given:
            if end > self._sent and self._clock is not None:
                return end - self._sent, self._clock.stamp(at_ns)
        return self._ring.capacity, 0


class Incoming:
    """The end of a ring that is filled with what comes.

    Commands older than `age` are given up instead: `give_up` gets how many, and how old they were in s.
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
        self._again = (
            -1,
            0,
        )  # what was asked for, and when: what is under way behind a gap is no reason to ask
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
        """How much has to have come for the program to be told, 0: nobody waits for that."""
        goal = self._ring.wanted
        return goal and goal - self._origin

    def want(self, goal: int) -> bool:
        """The original's writer is to be told once so many are taken (0: never); are they?"""
        with self._lock:
            if goal == 0:
                return False
            here = self.taken >= goal
            self._ring.free_threshold = max(1, goal - (self.received - self._ring.capacity))
            self._ring.arm_free()
            return here

    def accept(self, first: int, records: memoryview, stamp: int = 0, now_ns: int = 0) -> bool:
        """Put them in; is there something to be told at once? Raises BadMessage for more than there is room for."""
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
        """The other end has sent so much, and wants to know."""
        with self._lock:
            self._asked = True
            self._missing |= position > self.received

    def report(self, now_ns: int, *, at_once: bool = False) -> Report | None:
        """What is to be told now, None: nothing; `at_once` tells everything new."""
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
        """Have the ring's other event signalled when there is something to tell; when to look without it."""
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
