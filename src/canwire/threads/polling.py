"""Threads that ask again and again without a wait, for the time or for what is not there: time passes for them, too."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

from canwire.threads.member import Member, never

_POLLS = 1000  # questions without a wait, after which each further ...
_POLLED = 100  # ... so many let time pass,
_FIRST_STEP_NS, _LAST_STEP_NS = 10_000, 1_000_000  # twice as much each time


class Polling(ABC):
    """What Turns has for them."""

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
        """The time, for somebody who asks."""
        self.polls(me, never)
        return self.now_ns()

    def polls(self, me: Member, ready: Callable[[], bool]) -> bool:
        """It asks without a wait. Who does so again and again is taken to poll: time passes; is it ready meanwhile?"""
        me.asked += 1
        if me.asked < _POLLS or me.asked % _POLLED:
            return False
        doubled = min((me.asked - _POLLS) // _POLLED, 16)
        step_ns = min(_FIRST_STEP_NS << doubled, _LAST_STEP_NS)
        asked = me.asked
        answer = self.wait(me, ready, self.now_ns() + step_ns, "what it asks for again and again")
        me.asked = asked
        return bool(answer)
