"""When a client gives a hub up whose connection is gone: soon, unless the way to it was cut before that."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from canwire.hub.links.network.session.settings import Patience, was_cut

_LAST_WORDS_NS = 100_000_000  # what was under way when a connection broke comes within so long


class Broken:
    """`heard_ns` says when the hub was last heard of, `lose` is called once it is given up. Any thread may call."""

    def __init__(
        self, patience: Patience, heard_ns: Callable[[], int], lose: Callable[[str], object]
    ) -> None:
        self._patience = patience
        self._heard_ns = heard_ns
        self._lose = lose
        self._lock = threading.Lock()
        self._timers: list[threading.Timer] = []
        self._closed = False

    def gone(self) -> None:
        """The connection is. A process that ended says so at once, by its system; what is silent first may be back."""
        cut = was_cut(self._heard_ns(), self._patience.lease_s)
        self._wait(self._patience.cut_s if cut else self._patience.broken_s)

    def back(self) -> None:
        """A connection is: but not to this hub if that is not heard of soon."""
        self._wait(self._patience.broken_s)

    def close(self) -> None:
        with self._lock:
            self._closed = True
            for timer in self._timers:
                timer.cancel()

    def _wait(self, span_s: float) -> None:
        timer = threading.Timer(span_s, self._give_up, (time.monotonic_ns(),))
        timer.daemon = True
        with self._lock:
            self._timers = [one for one in self._timers if one.is_alive()]
            if not self._closed:
                self._timers.append(timer)
                timer.start()

    def _give_up(self, broken_ns: int) -> None:
        if self._heard_ns() <= broken_ns + _LAST_WORDS_NS:
            self._lose("its connection broke")
