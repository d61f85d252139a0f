"""Whose turn it is among programs that keep one time. No I/O, no clock: time is handed in.

One participant runs at a time. Time passes only while all of them wait; at an instant those whose time has come, or to
whom something was signalled, run one after the other in the order of their places, in rounds until nobody is left. So
what they do reaches the buses in an order that no scheduler has a part in.
"""

from __future__ import annotations

import re
from bisect import bisect_right, insort
from collections.abc import Sequence
from operator import attrgetter

from canwire.timeline import NEVER

Place = tuple[int, tuple[tuple[int, int, str], ...], int, int]
_NEVER = NEVER
_PIECES = re.compile(r"(\d+)|(\D+)")


class Participant:
    """A thread of a program. `until_ns` counts while it `waits`; `woken`: its turn comes at this very instant.

    One that is `deaf` waits for something that only `Turns.wake` tells of.
    """

    __slots__ = ("deaf", "name", "place", "thread", "until_ns", "waits", "woken")

    def __init__(self, name: str, thread: int, place: Place) -> None:
        self.name = name
        self.thread = thread
        self.place = place
        self.waits = True
        self.woken = True
        self.deaf = False
        self.until_ns = NEVER

    def __repr__(self) -> str:
        return f"<{self.name}, thread {self.thread}, {'waits' if self.waits else 'runs'}>"


_place_of = attrgetter("place")


class Turns:
    """Everybody who takes part, in order: as `names` has them, then by name (`ecu2` before `ecu10`).

    Nobody gets a turn before `expected` participants are there and every one of `names`; from then on they come and go.
    """

    def __init__(self, expected: int = 1, names: Sequence[str] = ()) -> None:
        self.running: Participant | None = None
        self.given = 0  # turns so far
        self._expected = expected
        self._names = tuple(names)
        self._begun = False
        self._everybody: list[Participant] = []
        self._last: Participant | None = None  # who had the last turn of this instant ...
        self._after: Place | None = None  # ... and its place, should it be gone
        self._instant_ns = -1

    @property
    def everybody(self) -> Sequence[Participant]:
        """In the order of their turns."""
        return self._everybody

    @property
    def missing(self) -> str:
        """Who is still expected, in words; "" once time has begun."""
        if self._begun:
            return ""
        absent = [name for name in self._names if all(one.name != name for one in self._everybody)]
        if absent:
            return ", ".join(absent)
        short = self._expected - len(self._everybody)
        return f"{short} of {self._expected} programs" if short > 0 else ""

    def add(self, name: str, program: int, thread: int) -> Participant:
        """Somebody new, whose turn comes at this instant. Among equal names `program` decides, then `thread`."""
        rank = self._names.index(name) if name in self._names else len(self._names)
        new = Participant(name, thread, (rank, _natural(name), program, thread))
        insort(self._everybody, new, key=_place_of)
        self._begun = self._begun or not self.missing
        return new

    def remove(self, one: Participant) -> None:
        """It takes part no longer; a second time nothing happens."""
        if one is self.running:
            self.running = None
        if one in self._everybody:
            self._everybody.remove(one)

    def wait(self, one: Participant, until_ns: int, *, deaf: bool = False) -> None:
        """Its turn is over; the next one comes at `until_ns` (NEVER: at a signal only), sooner if it is woken."""
        one.deaf = deaf
        if one is self.running:
            self.running = None
        one.waits = True
        one.until_ns = until_ns

    def wake(self, one: Participant) -> None:
        """It looks again at this instant; one that runs does so at its next wait."""
        one.woken, one.deaf = True, False

    def next(self, now_ns: int) -> Participant | None:
        """Who runs from now on; None while somebody runs already, is missing, or nobody's time has come."""
        if self.running is not None or not self._begun:
            return None
        if now_ns != self._instant_ns:
            self._instant_ns, self._last, self._after = now_ns, None, None
        found = self._first_due(now_ns)
        if found is not None:
            found.waits = found.woken = False
            self._last, self._after = found, found.place
            self.running = found
            self.given += 1
        return found

    def until_ns(self) -> int:
        """Until when time may pass, NEVER: until something is signalled. Only while everybody waits, and after `next`.

        Where nobody takes part, or somebody is missing, that is the beginning: it must not pass.
        """
        if self.running is not None or not self._begun or not self._everybody:
            return 0
        soonest = _NEVER
        for one in self._everybody:
            soonest = min(soonest, one.until_ns)
        return soonest

    def _first_due(self, now_ns: int) -> Participant | None:
        """Rounds: after the one who had the last turn first, so that whoever waits for nothing holds up nobody."""
        count, begin = len(self._everybody), self._begin()
        for k in range(count):
            one = self._everybody[begin + k if begin + k < count else begin + k - count]
            if (one.woken and not one.deaf) or one.until_ns <= now_ns:
                return one
        return None

    def _begin(self) -> int:
        if self._last is None:
            return 0
        for k in range(len(self._everybody)):
            if self._everybody[k] is self._last:
                return k + 1
        return bisect_right(self._everybody, self._after, key=_place_of)


def _natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """For sorting: numbers by their value."""
    return tuple((0, int(n), "") if n else (1, 0, text) for n, text in _PIECES.findall(name))
