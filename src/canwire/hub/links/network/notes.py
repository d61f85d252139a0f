"""Notices on their way to a client: the same guarantees as for rings, for messages of any length. No I/O."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from canwire.errors import BadMessage
from canwire.hub.links.network import wire
from canwire.hub.links.network.wire import Report


class OutgoingNotes:
    """Notices on their way, records of different lengths; kept until they have arrived."""

    number = wire.NOTES

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: deque[bytes] = deque()
        self._sent = self._received = 0

    def add(self, notice: bytes) -> None:
        with self._lock:
            self._kept.append(notice)

    @property
    def sent(self) -> int:
        return self._sent

    @property
    def written(self) -> int:
        with self._lock:
            return self._received + len(self._kept)

    @property
    def unconfirmed(self) -> bool:
        return self._sent != self._received

    def batches(self, now_ns: int, *, at_once: bool = False) -> list[bytes]:
        """The notices that were not sent yet."""
        if not self._kept:
            return []
        with self._lock:
            waiting = list(self._kept)[self._sent - self._received :]
            found = [
                wire.frames(self.number, self._sent + place, memoryview(notice))
                for place, notice in enumerate(waiting)
            ]
            self._sent += len(found)
            return found

    def acknowledge(self, report: Report) -> None:
        """The client has received this many notices."""
        with self._lock:
            if report.received > self._received + len(self._kept):
                raise BadMessage(f"{report} of {self._received + len(self._kept)} notices")
            while self._received < report.received:
                self._kept.popleft()
                self._received += 1
            self._sent = self._received if report.again else max(self._sent, self._received)

    def arm(self, now_ns: int) -> int | None:
        return None

    def close(self) -> None:
        with self._lock:
            self._kept.clear()
            self._sent = self._received


class IncomingNotes:
    """The client's end: `tell` gets each notice once, in order, and must not wait."""

    number = wire.NOTES

    def __init__(self, tell: Callable[[bytes], object]) -> None:
        self._tell = tell
        self._lock = threading.Lock()
        self._missing = self._asked = False
        self.received = 0

    def accept(self, first: int, records: memoryview) -> bool:
        """Accept the notice of this number."""
        with self._lock:
            self._missing |= first > self.received
            self._asked = True
            if first == self.received:
                self.received += 1
                self._tell(bytes(records))
            return True

    def sent(self, position: int) -> None:
        """The other end has sent this many, and requests a report."""
        with self._lock:
            self._asked = True
            self._missing |= position > self.received

    def report(self, now_ns: int, *, at_once: bool = False) -> Report | None:
        """The report to send now."""
        if not (self._asked or self._missing):
            return None
        with self._lock:
            made = Report(self.number, self.received, self.received, self._missing)
            self._missing = self._asked = False
            return made

    def arm(self, now_ns: int) -> int | None:
        return None

    def close(self) -> None:
        """Do nothing: there is nothing to release."""
