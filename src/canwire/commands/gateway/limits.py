"""Reports the frames that a gateway discards because of a limit: the first one, then the number once a minute."""

from __future__ import annotations

import time
from collections.abc import Callable

from canwire import GatewayCounts

_EVERY_S = 60.0
_KINDS = {
    "limited": "more frames than --rate allows: {0} not passed on",
    "lost": "more frames than the queues hold: {0} lost",
    "unfit": "CAN FD for a line that knows classic CAN only: {0} not passed on",
}


class Limits:
    """The limits of one direction with this `name`; `say` prints a line."""

    def __init__(
        self, name: str, say: Callable[[str], object], clock_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._name = name
        self._say = say
        self._clock_s = clock_s
        self._told = dict.fromkeys(_KINDS, 0)
        self._again_s = dict.fromkeys(_KINDS, 0.0)

    def look(self, counts: GatewayCounts) -> None:
        """Report the counts that have grown since the last report."""
        now_s = self._clock_s()
        for kind, words in _KINDS.items():
            count: int = getattr(counts, kind)
            if count > self._told[kind] and (not self._told[kind] or now_s >= self._again_s[kind]):
                self._told[kind], self._again_s[kind] = count, now_s + _EVERY_S
                self._say(f"{self._name}: {words.format(count)} so far")
