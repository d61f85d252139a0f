"""Passes the notices of a hub to the listeners of a link."""

from __future__ import annotations

import sys
import threading
import traceback
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire.hub.protocol.link import Listener
    from canwire.hub.protocol.messages import Message


class Notices:
    """Calls every listener with every notice, in order, in a thread that runs only while notices are pending.

    So a listener may block, take locks and call the hub. The exception of a listener is printed to stderr.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._listeners: list[Listener] = []
        self._waiting: deque[Message | None] = deque()
        self._telling = False
        self._closed = False

    def listen(self, listener: Listener) -> None:
        with self._lock:
            self._listeners.append(listener)

    def tell(self, notice: Message | None) -> None:
        """Pass a notice on soon, from any thread; no effect once closed."""
        if self._is_next(notice):
            try:
                threading.Thread(target=self._tell_all, name="canwire-notices", daemon=True).start()
            except RuntimeError:  # the interpreter is on its way out and starts no threads
                self._tell_all()

    def tell_here(self, notice: Message | None) -> None:
        """Pass a notice on in this thread, unless another thread is already passing on notices."""
        if self._is_next(notice):
            self._tell_all()

    def close(self) -> None:
        """Stop passing on notices."""
        with self._lock:
            self._closed = True
            self._waiting.clear()

    def _is_next(self, notice: Message | None) -> bool:
        """Queue the notice; True if the caller must pass it on."""
        with self._lock:
            if self._closed or not self._listeners:
                return False
            self._waiting.append(notice)
            telling, self._telling = self._telling, True
            return not telling

    def _tell_all(self) -> None:
        while True:
            with self._lock:
                if not self._waiting:
                    self._telling = False
                    return
                notice = self._waiting.popleft()
                listeners = list(self._listeners)
            for listener in listeners:
                try:
                    listener(notice)
                except Exception:  # a listener's own mistake: the others still want to know
                    traceback.print_exc(file=sys.stderr)
