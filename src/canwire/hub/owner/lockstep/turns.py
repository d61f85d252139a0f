"""The order of turns of programs in lockstep. No I/O and no clock: times are arguments.

One participant runs at a time. Time passes only while all of them wait. At one instant, the participants whose time has
come, or that have received a signal, run one after the other in the order of their places, in rounds until none is
left. So the order of their actions on the buses does not depend on the system's scheduler.
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
    """A thread of a program. `until_ns` counts while it `waits`; `woken`: it has a turn at this instant.

    A `deaf` one ignores signals: only `Turns.wake` ends its wait.
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
    """All participants in order: first as in `names`, then by name (`ecu2` before `ecu10`).

    Turns begin once `expected` participants and all of `names` have joined; later ones may join and leave at any time.
    """

    def __init__(self, expected: int = 1, names: Sequence[str] = ()) -> None:
        self.running: Participant | None = None
        self.given = 0  # turns so far
        self._expected = expected
        self._names = tuple(names)
        self._begun = False
        self._everybody: list[Participant] = []
        self._last: Participant | None = None  # had the last turn of this instant ...
        self._after: Place | None = None  # ... and its place, should it be gone
        self._instant_ns = -1

    @property
    def everybody(self) -> Sequence[Participant]:
        """All participants, in the order of their turns."""
        return self._everybody

    @property
    def missing(self) -> str:
        """The participants still expected, as text; "" once time has begun."""
        if self._begun:
            return ""
        absent = [name for name in self._names if all(one.name != name for one in self._everybody)]
        if absent:
            return ", ".join(absent)
        short = self._expected - len(self._everybody)
        return f"{short} of {self._expected} programs" if short > 0 else ""

    def add(self, name: str, program: int, thread: int) -> Participant:
        """Add a participant, with a turn at this instant. Equal names are ordered by `program`, then by `thread`."""
        rank = self._names.index(name) if name in self._names else len(self._names)
        new = Participant(name, thread, (rank, _natural(name), program, thread))
        insort(self._everybody, new, key=_place_of)
        self._begun = self._begun or not self.missing
        return new

    def remove(self, one: Participant) -> None:
        """Remove a participant; a second call has no effect."""
        if one is self.running:
            self.running = None
        if one in self._everybody:
            self._everybody.remove(one)

    def wait(self, one: Participant, until_ns: int, *, deaf: bool = False) -> None:
        """End its turn; the next one is at `until_ns` (NEVER: only at a signal), or sooner if it is woken."""
        one.deaf = deaf
        if one is self.running:
            self.running = None
        one.waits = True
        one.until_ns = until_ns

    def wake(self, one: Participant) -> None:
        """Give it a turn at this instant; if it is running, after its next wait."""
        one.woken, one.deaf = True, False

    def next(self, now_ns: int) -> Participant | None:
        """The participant that runs from now on; None if one runs, one is missing, or none is due."""
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
        """The time up to which time may pass, NEVER: until a signal. Call it after `next`, while all wait.

        0 if there is no participant, or if one is missing or runs: time must not pass.
        """
        if self.running is not None or not self._begun or not self._everybody:
            return 0
        soonest = _NEVER
        for one in self._everybody:
            soonest = min(soonest, one.until_ns)
        return soonest

    def _first_due(self, now_ns: int) -> Participant | None:
        """The next one due after the last turn, in rounds, so that one that never waits does not block the others."""
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
    """A key for sorting in which numbers count by value."""
    return tuple((0, int(n), "") if n else (1, 0, text) for n, text in _PIECES.findall(name))
