"""Callers that have not sent a greeting: each has a time limit, and is closed if descriptors run out."""

from __future__ import annotations

import time
from itertools import islice
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from canwire.hub.owner.engine import Engine

_ROOM = 4  # descriptors that the next caller needs: its connection's and its doorbell's


class Silent(Protocol):
    """A caller that has not sent a greeting."""

    def let_go(self, why: str) -> None:
        """Close its connection, and send the reason if possible; `over` is called meanwhile."""


class Greetings:
    """The silent callers of one server, oldest first. Everything runs in the engine's thread."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._limit_s = engine.world.limits.greeting_seconds
        self._silent: dict[Silent, float] = {}  # when its time is over, by the monotonic clock
        self._reminded = False

    def wait_for(self, caller: Silent) -> None:
        """Start its time limit, which parts of a greeting do not extend."""
        self._silent[caller] = time.monotonic() + self._limit_s
        if not self._reminded:
            self._remind(self._limit_s)

    def over(self, caller: Silent) -> None:
        """The caller has sent its greeting, or is gone; unknown ones are ignored."""
        self._silent.pop(caller, None)

    def make_room(self) -> bool:
        """Close the oldest callers, because descriptors have run out. False if no caller is silent."""
        oldest = list(islice(self._silent, _ROOM))
        for caller in oldest:
            caller.let_go("the hub has no more descriptors, and you have not said who you are; connect again")
        return bool(oldest)

    def _remind(self, seconds: float) -> None:
        self._reminded = True
        self._engine.remind(seconds, self._look)

    def _look(self) -> None:
        self._reminded = False
        now = time.monotonic()
        for caller, ends in list(self._silent.items()):
            if ends > now:
                self._remind(ends - now)
                return
            caller.let_go(
                f"no greeting within {self._limit_s} seconds; connect again, or set greeting_seconds under [limits] "
                f"in the hub's canwire.toml"
            )
