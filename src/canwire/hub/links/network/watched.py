"""The counters of a FIFO that one end only monitors."""

from __future__ import annotations

import threading

from canwire.hub.links.network.wire import Count
from canwire.ring import Ring


class Watched:
    """The counters of a FIFO that one end only monitors, and may write into, at either end of the link.

    The hub's end has the FIFO, the client's end a copy of its counters. Elements that the client writes are counted
    here and written there with zeros: programs use such FIFOs only to signal each other.
    """

    def __init__(self, number: int, ring: Ring, picture: memoryview | None = None) -> None:
        self.number = number
        self._ring = ring
        self._words = None if picture is None else picture[:256].cast("Q")
        self._lock = threading.Lock()
        self._shown = self._counts()
        self._told: tuple[int, ...] = ()
        self._own = 0  # put in by the client, to the knowledge of this end

    def changed(self) -> Count | None:
        """The count to report; None: nothing new."""
        with self._lock:
            found = self._counts()
            if self._words is not None:
                self._own += found[0] + found[2] - self._shown[0] - self._shown[2]
                self._shown = found
            told = (*found, self._own)
            if told == self._told:
                return None
            self._told = told
            return Count(self.number, *told)

    def now(self) -> Count:
        """The last reported count, for an end that may have missed it."""
        with self._lock:
            return Count(self.number, *(self._told or (*self._counts(), self._own)))

    def show(self, count: Count) -> bool:
        """Accept a count of the other end; returns whether to report immediately."""
        with self._lock:
            if self._words is None:
                for _ in range(min(count.own - self._own, self._ring.capacity + 1)):
                    self._ring.put_bytes(bytes(self._ring.record_size))
                self._own = max(self._own, count.own)
                return True
            self._own += sum(self._counts()[::2]) - sum(self._shown[::2])
            if count.own == self._own:  # else it does not know yet what was put in here
                self._words[8], self._words[16], self._words[9] = count[1:4]
            self._shown = self._counts()
            return False

    def close(self) -> None:
        self._words = None
        self._ring.event = self._ring.free_event = None
        self._ring.close()

    def _counts(self) -> tuple[int, int, int]:
        return self._ring.written, self._ring.taken, self._ring.lost
