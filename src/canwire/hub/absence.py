"""The time that a program spends without its hub or a board, if it waits for them to come back."""

from __future__ import annotations

import time
from collections.abc import Callable

from canwire.errors import CanwireError, HubLost
from canwire.values.checks import instance, shown

_FIRST_S, _LONGEST_S = 0.1, 2.0  # before it tries again


class Absence:
    """Since when a hub or a board is away, why, and how long a program waits before it tries again."""

    def __init__(self, clock_s: Callable[[], float] = time.monotonic) -> None:
        if not callable(clock_s):
            raise TypeError(f"clock_s {shown(clock_s)}: must be a function, such as time.monotonic")
        self._clock_s = clock_s
        self._since_s: float | None = None
        self._reason = ""
        self._pause_s = _FIRST_S

    def __repr__(self) -> str:
        return f"<away: {self._reason}>" if self.lasts else "<not away>"

    @property
    def lasts(self) -> bool:
        """True between `failed` and `end`."""
        return self._since_s is not None

    @property
    def reason(self) -> str:
        """The error of the last attempt; "" while the absence does not last."""
        return self._reason

    @property
    def pause_s(self) -> float:
        """Seconds to wait before the next attempt: 0.1 after a loss, and twice as long after each failure, up to 2."""
        return self._pause_s

    def failed(self, error: CanwireError) -> bool:
        """Record a loss, or an attempt that failed; True if its reason is a new one, which users want to read."""
        instance("error", error, CanwireError)
        lost = isinstance(error, HubLost) and not self.lasts
        self._pause_s = _FIRST_S if lost else min(2 * self._pause_s, _LONGEST_S)
        if self._since_s is None:
            self._since_s = self._clock_s()
        new = str(error) != self._reason
        self._reason = str(error)
        return new

    def end(self) -> float | None:
        """Record that all is back: the seconds without it, or None if nothing was away."""
        since_s, self._since_s, self._reason = self._since_s, None, ""
        return None if since_s is None else self._clock_s() - since_s
