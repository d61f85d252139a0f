"""A ring whose copy (incoming.py) is at the other end of a link: what is written here appears there.

Both have the same capacity, and a record stays in the original until the copy's reader has taken it. So the original
fills up and counts lost records as if its reader were local, and records that the link loses can be sent again, except
commands that have become too old. No I/O; times are arguments; any thread may call.
"""

from __future__ import annotations

import threading

from canwire.errors import BadMessage
from canwire.hub.links.network import wire
from canwire.hub.links.network.cuts.age import OtherClock
from canwire.hub.links.network.flow.under_way import Given, UnderWay
from canwire.hub.links.network.flow.way import Way
from canwire.hub.links.network.wire import Report
from canwire.ring import Ring

BATCH = 64  # records sent together at most (MANY times that where as many wait: each payload costs time)
_LARGEST_BATCH = 1 << 16
MANY = 4
_MOST = 32  # batches made at a time ...
FULL = _MOST // MANY  # ... which are so many payloads at least, and fewer are all that there is
_PACKED = 24  # bytes of a packed frame, roughly


class Outgoing:
    """The end of a ring whose records are sent. `filled`: the number of records that the other end already has.

    `frames`: the records are frames, which are packed. With the other end's `clock` they are commands, each sent with
    the time when it was given. `way` is the flow control of the link, once the ring belongs to one.
    """

    def __init__(
        self,
        number: int,
        ring: Ring,
        filled: int = 0,
        clock: OtherClock | None = None,
        *,
        frames: bool = False,
    ) -> None:
        self._given = None if clock is None else Given(clock)
        self._frames = frames
        self.number = number
        self._ring = ring
        self._lock = threading.Lock()
        self._origin = ring.taken
        self._sent = self._received = filled
        self._began_ns = -(1 << 62)  # a span of time that small batches wait in once ...
        self._batches = 0  # ... so many have gone out in it
        most = max(1, _LARGEST_BATCH // ring.record_size)
        self._batch, self._many = min(BATCH, most), min(MANY * BATCH, most)
        self.belongs_to(Way())

    def belongs_to(self, way: Way) -> None:
        """Use the flow control of this link, which all its rings share."""
        self._way = way
        self._under_way = UnderWay(way)

    @property
    def sent(self) -> int:
        return self._sent

    @property
    def written(self) -> int:
        """The position of the ring's writer."""
        return self._ring.written - self._origin

    @property
    def unconfirmed(self) -> bool:
        """Whether something was sent that is not known to have arrived."""
        return self._sent != self._received

    def batches(self, now_ns: int, *, at_once: bool = False) -> list[bytes]:
        """The payloads to send now; `at_once` does not wait for more records."""
        with self._lock:
            unsent = self._unsent()
            if self._given is not None:
                self._given.mark(self._received, self._sent + unsent, now_ns)
            together = self._together
            count = min(unsent, _MOST * together)
            if not at_once and count % together and self._holds(now_ns):
                count -= count % together
            if count <= 0 or not self._way.room():
                return []
            if now_ns >= self._began_ns + self._way.hold_ns:
                self._began_ns, self._batches = now_ns, 0
            self._batches += 1
            return self._cut(count, now_ns)

    def acknowledge(self, report: Report, now_ns: int = 0) -> None:
        """Accept a report on the copy that arrived at `now_ns` (0: unknown); raises BadMessage if it is impossible."""
        with self._lock:
            taken = self._ring.taken - self._origin
            if not (report.taken <= report.received <= taken + self._ring.fill()):
                raise BadMessage(f"ring {self.number}: {report} of {self.written} records")
            self._received = max(self._received, report.received)
            self._sent = max(self._sent, self._received)
            self._under_way.came(self._received, now_ns)
            if report.again:
                self._sent = self._received
                self._under_way.forget()
            if report.taken > taken:
                self._ring.release(report.taken - taken)

    def arm(self, now_ns: int) -> int | None:
        """Arm the ring's event for new records to send. Returns when to check without the event, None: never."""
        with self._lock:
            waiting = self._unsent() if self._way.room() else 0
            held = self._sent - (self._ring.taken - self._origin)
            holding = waiting > 0 or self._holds(now_ns)
            wanted = self._together if holding else 1
            self._ring.threshold = max(1, min(self._ring.capacity, held + wanted))
            self._ring.arm()
            return self._began_ns + self._way.hold_ns if holding else None

    @property
    def wanted(self) -> int:
        """The position that the copy's reader must reach before the program is notified; 0: it does not wait."""
        goal = self._ring.free_wanted
        return goal and goal - self._origin

    def want(self, taken: int, goal: int) -> bool:
        """The copy's reader is at `taken`, and is notified at `goal` written (0: never); returns whether they are."""
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
        with self._lock:
            self._under_way.forget()
        self._ring.close()

    @property
    def _together(self) -> int:
        """So many records wait for no more."""
        return self._many if self._way.slow else self._batch

    def _holds(self, now_ns: int) -> bool:
        """Whether to hold back the next batch, as there were so many small ones that it should be larger."""
        return now_ns < self._began_ns + self._way.hold_ns and self._batches >= self._way.at_once

    def _unsent(self) -> int:
        return self._ring.taken - self._origin + self._ring.fill() - self._sent

    def _cut(self, count: int, now_ns: int) -> list[bytes]:
        """So many records that were not sent yet, in batches, as long as there is room for them on the way."""
        size = self._ring.record_size
        most = self._many if count >= self._many else self._batch
        skip = (self._sent - (self._ring.taken - self._origin)) * size
        found: list[bytes] = []
        for block in self._ring.acquire(skip // size + count):
            at = skip
            while at < len(block) and (room := self._way.room()):
                alike, stamp = (0, 0) if self._given is None else self._given.alike(self._sent)
                step = min(most, alike or most, max(1, room // (_PACKED if self._frames else size)))
                records = block[at : at + step * size]
                payload = self._payload(records, stamp)
                found.append(payload)
                self._sent += len(records) // size
                self._under_way.add(self._sent, len(payload), now_ns)
                at += len(records)
            if at < len(block):
                break  # no more room
            skip = max(0, skip - len(block))
        return found

    def _payload(self, records: memoryview, stamp: int) -> bytes:
        if self._frames:
            return wire.packed_frames(self.number, self._sent, records, stamp, squeeze=self._way.squeezes)
        return wire.frames(self.number, self._sent, records, stamp)
