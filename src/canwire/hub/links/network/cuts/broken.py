"""When a client treats a hub as lost after its connection has ended: soon, or later if the network was cut before."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from canwire.hub.links.network.cuts.silence import was_cut
from canwire.hub.links.network.session.settings import Patience

_LAST_WORDS_NS = 100_000_000  # what was under way when a connection broke comes within so long
_FIRST_WORDS_S = 5.0  # after a new connection: systems repeat what a cut has swallowed ever more rarely


class Breaks:
    """The state of a connection, and when the hub counts as lost. No clock: times in ns are arguments."""

    def __init__(self, patience: Patience) -> None:
        self._patience = patience
        self._since_ns = 0
        self._until_ns: int | None = None

    def gone(self, now_ns: int, heard_ns: int, silent_ns: int) -> None:
        """The connection has ended. The hub's last message came at `heard_ns`; either end was silent for `silent_ns`.

        The system reports the end of a process immediately; after a silence, the other end may return.
        """
        if self.due_ns(heard_ns) is None:
            cut = was_cut(silent_ns, self._patience.lease_s)
            self._since_ns = now_ns
            self._until_ns = now_ns + _ns(self._patience.cut_s if cut else self._patience.broken_s)

    def back(self, now_ns: int) -> None:
        """The connection is back; the first message of the hub on it may take a while."""
        if self._until_ns is not None:
            self._until_ns = max(self._until_ns, now_ns + _ns(_FIRST_WORDS_S))

    def due_ns(self, heard_ns: int) -> int | None:
        """When a hub with its last message at `heard_ns` counts as lost; None: it is connected."""
        if heard_ns > self._since_ns + _LAST_WORDS_NS:
            self._until_ns = None
        return self._until_ns


class Broken:
    """Breaks with a clock: `lose` is called once the hub counts as lost. Any thread may call.

    `heard_ns` returns the time of the last message of the hub, `silent_ns` how long either end has received nothing.
    """

    def __init__(
        self,
        patience: Patience,
        heard_ns: Callable[[], int],
        silent_ns: Callable[[], int],
        lose: Callable[[str], object],
    ) -> None:
        self._breaks = Breaks(patience)
        self._heard_ns = heard_ns
        self._silent_ns = silent_ns
        self._lose = lose
        self._lock = threading.Lock()
        self._timer: threading.Timer | None = None
        self._closed = False

    def gone(self) -> None:
        """The connection is."""
        with self._lock:
            self._breaks.gone(time.monotonic_ns(), self._heard_ns(), self._silent_ns())
            self._arm()

    def back(self) -> None:
        """A connection is."""
        with self._lock:
            self._breaks.back(time.monotonic_ns())
            self._arm()

    def replaced(self, why: str) -> None:
        """Another hub has taken the place of this one: if this one is gone, it does not return."""
        with self._lock:
            gone = self._breaks.due_ns(self._heard_ns()) is not None
        if gone:
            self._lose(why)

    def close(self) -> None:
        with self._lock:
            self._closed = True
            if self._timer is not None:
                self._timer.cancel()

    def _arm(self) -> None:
        """Check when it is due, and not before; the caller holds the lock."""
        due_ns = self._breaks.due_ns(self._heard_ns())
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if due_ns is not None and not self._closed:
            self._timer = threading.Timer(max(0, due_ns - time.monotonic_ns()) / 1e9, self._look)
            self._timer.daemon = True
            self._timer.start()

    def _look(self) -> None:
        with self._lock:
            due_ns = self._breaks.due_ns(self._heard_ns())
            over = due_ns is not None and time.monotonic_ns() >= due_ns
            if not over:
                self._arm()
        if over:
            self._lose("its connection broke")


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)
