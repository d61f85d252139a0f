"""What threads that take turns need of whose time they keep."""

from __future__ import annotations

from typing import Protocol

from canwire.threads import originals

_CHUNK_NS = 20_000_000
NEVER = (1 << 63) - 1


class Keeper(Protocol):
    """Whose time it is: a hub's or a lab's."""

    @property
    def alone(self) -> bool:
        """Nothing comes from other programs: where nothing is for long, nothing will ever be."""

    @property
    def lost(self) -> bool:
        """Nothing passes there any more."""

    def now_ns(self) -> int: ...

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """From `now_ns` on let it pass until then, or until something is signalled; the time it is then."""

    def leave(self) -> None:
        """None of the threads takes part for now: others are not to be held up."""

    def rejoin(self) -> None:
        """One takes part again; waits for its turn among others."""


class ByTheClock:
    """After the hub has gone time goes on from where it was, as slowly as the computer's."""

    alone = False
    lost = False

    def __init__(self, now_ns: int) -> None:
        self._now_ns = now_ns

    def now_ns(self) -> int:
        return self._now_ns

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """A piece of it, after which everybody looks again."""
        chunk_ns = min(_CHUNK_NS, until_ns - now_ns)
        originals.sleep(chunk_ns / 1e9)
        if until_ns < NEVER:
            self._now_ns += chunk_ns
        return self._now_ns

    def leave(self) -> None:
        """Nobody is held up."""

    def rejoin(self) -> None:
        """See `leave`."""
