"""The interface through which threads that take turns let the time of a hub or a lab pass."""

from __future__ import annotations

from typing import Protocol

from canwire.threads import originals

_CHUNK_NS = 20_000_000
NEVER = (1 << 63) - 1


class Keeper(Protocol):
    """Controls the time of a hub or a lab."""

    @property
    def alone(self) -> bool:
        """True if no other program can cause an event: a long silence then lasts forever."""

    @property
    def lost(self) -> bool:
        """True once this time no longer passes."""

    def now_ns(self) -> int: ...

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """Let time pass from `now_ns` up to `until_ns` or a signal; returns the time after that."""

    def leave(self) -> None:
        """Leave the turns while no thread takes part: other programs need not wait for this one."""

    def rejoin(self) -> None:
        """Rejoin the turns when a thread takes part again; wait for the turn of this program."""


class ByTheClock:
    """After the end of the hub: time continues from its last value, at the pace of the real clock."""

    alone = False
    lost = False

    def __init__(self, now_ns: int) -> None:
        self._now_ns = now_ns

    def now_ns(self) -> int:
        return self._now_ns

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """Let a part of the span pass, after which all threads check their conditions."""
        chunk_ns = min(_CHUNK_NS, until_ns - now_ns)
        originals.sleep(chunk_ns / 1e9)
        if until_ns < NEVER:
            self._now_ns += chunk_ns
        return self._now_ns

    def leave(self) -> None:
        """Do nothing: no other program waits."""

    def rejoin(self) -> None:
        """Do nothing, like `leave`."""
