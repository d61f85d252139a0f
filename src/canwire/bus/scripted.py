"""A scripted disturbance: how often it has struck, how often it still will, and how it ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(slots=True, eq=False, kw_only=True)
class Scripted:
    """One disturbance on a bus. Each time it takes effect, `times` counts down (None: no limit) and `struck` counts up.

    `listener` is called each time, in the middle of the bus's step, and when the disturbance is `cancelled`; it may
    only set timers.
    """

    times: int | None = 1
    struck: int = 0
    listener: Callable[[], object] | None = None
    remove: Callable[[Any], object] | None = field(default=None, repr=False)
    cancelled: bool = False

    @property
    def times_left(self) -> int | None:
        """How often it will still strike; None: without end."""
        return self.times

    def strike(self) -> None:
        """The bus calls this when the disturbance has taken effect."""
        self.struck += 1
        if self.times is not None:
            self.times -= 1
        if self.listener is not None:
            self.listener()

    def cancel(self) -> None:
        """End the disturbance; a second call does nothing."""
        if self.cancelled:
            return
        self.cancelled, self.times = True, 0
        if self.remove is not None:
            self.remove(self)
        if self.listener is not None:
            self.listener()
