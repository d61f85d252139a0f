"""What threads that take turns need of whose time they keep."""

from __future__ import annotations

from typing import Protocol

NEVER = (1 << 63) - 1


class Keeper(Protocol):
    """Whose time it is: a hub's or a lab's."""

    @property
    def lost(self) -> bool:
        """Nothing passes there any more."""

    def now_ns(self) -> int: ...

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """From `now_ns` on let it pass until then, or until something is signalled; the time it is then."""
