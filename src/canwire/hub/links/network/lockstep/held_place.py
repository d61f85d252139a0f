"""The place of a remote program's thread in the hub's time: waits begin immediately, a thread reports their end."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire.hub.protocol.turn_wait import TurnWait

Done = Callable[[int | None], object]
"""Is called with the time at the next turn; None: no turn will come, or another wait has begun since."""


class HeldPlace:
    """A place, by the hub's page for it, until `end`. Any thread may call."""

    def __init__(self, page: TurnWait) -> None:
        self._page = page
        self._lock = threading.Lock()
        self._asked = 0
        self._done: Done | None = None
        self._ended = False
        threading.Thread(target=self._run, name="canwire-turns", daemon=True).start()

    def begin(self, until_ns: int, done: Done) -> None:
        """Begin to wait until then; `done` is called once, in another thread or in this one."""
        with self._lock:
            before = self._done
            if not self._ended:
                self._done, done = done, before or _nobody
                self._asked = self._page.begin(until_ns)
        done(None)

    def stir(self) -> None:
        """The program's threads check again; the hub is not notified yet."""
        self._page.stir()

    def end(self) -> None:
        """The link has ended."""
        with self._lock:
            self._ended = True
        self._page.end()

    def _run(self) -> None:
        while True:
            self._page.rest()
            with self._lock:
                now_ns = None if self._ended else self._page.given(self._asked)
                if now_ns is None and not self._ended:
                    continue  # told before it was over
                done, self._done = self._done or _nobody, None
                ended = self._ended
            done(now_ns)
            if ended:
                return


def _nobody(now_ns: int | None) -> None:
    """Waits."""
