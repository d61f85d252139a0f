"""Late commands of one client: refused, counted, and reported in one line for several of them."""

from __future__ import annotations

import threading
from collections.abc import Callable

from canwire.errors import HubError
from canwire.hub.links.network.calls import Asked
from canwire.hub.links.network.cuts.age import Age
from canwire.hub.protocol import messages as m


class Late:
    """`age` is the limit; `tell` calls `warn` with a line about the commands since the last one. Thread-safe."""

    def __init__(self, limit_s: float, warn: Callable[[str], object]) -> None:
        self.age = Age(limit_s)
        self._warn = warn
        self._lock = threading.Lock()
        self._count = 0
        self._oldest_s = 0.0

    def refusal(self, asked: Asked, now_ns: int) -> HubError | None:
        """The error of a call that was in transit for too long: its program may have continued without it.

        Raises BadMessage.
        """
        age_s = self.age.over_s(asked.stamp, now_ns)
        if not age_s:
            return None
        _, request = m.decode_request(asked.request)
        if isinstance(request, (m.Hello, m.Close)):  # to give something back is never too late
            return None
        what = f"{type(request).__name__} came after {age_s:.1f} s, and is not carried out"
        self._warn(what)
        return HubError(f"{what} beyond {self.age.limit_s:g} s (`canwire offer --age`)")

    def frames(self, count: int, age_s: float) -> None:
        """Count frames that are not sent."""
        with self._lock:
            self._count += count
            self._oldest_s = max(self._oldest_s, age_s)

    def tell(self) -> None:
        """Now and then."""
        with self._lock:
            count, oldest_s = self._count, self._oldest_s
            self._count, self._oldest_s = 0, 0.0
        if count:
            self._warn(
                f"{count} frames came after {oldest_s:.1f} s, and are not sent beyond {self.age.limit_s:g} s"
            )
