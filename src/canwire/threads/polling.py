"""Threads that poll without waiting, for the time or for an event: time passes for them, too."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

from canwire.threads.member import Member, never

_POLLS = 1000  # questions without a wait, after which each further ...
_POLLED = 100  # ... so many let time pass,
_FIRST_STEP_NS, _LAST_STEP_NS = 10_000, 1_000_000  # twice as much each time


class Polling(ABC):
    """The part of Turns for threads that poll."""

    @abstractmethod
    def now_ns(self) -> int:
        """Turns.now_ns."""

    @abstractmethod
    def wait(
        self,
        me: Member,
        ready: Callable[[], bool],
        until_ns: int,
        what: str,
        descriptors: tuple[int, ...] = (),
    ) -> bool | None:
        """Turns.wait."""

    def asks(self, me: Member) -> int:
        """Return the time; the query counts as a poll."""
        self.polls(me, never)
        return self.now_ns()

    def polls(self, me: Member, ready: Callable[[], bool]) -> bool:
        """Count a query without a wait. After many of them time passes; returns whether `ready` became true."""
        me.asked += 1
        if me.asked < _POLLS or me.asked % _POLLED:
            return False
        doubled = min((me.asked - _POLLS) // _POLLED, 16)
        step_ns = min(_FIRST_STEP_NS << doubled, _LAST_STEP_NS)
        asked = me.asked
        answer = self.wait(me, ready, self.now_ns() + step_ns, "what it asks for again and again")
        me.asked = asked
        return bool(answer)
