"""Access to the engine's thread for boards with input from outside; the world exists before the engine."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire.drivers.outside import HasFileno, Reactor


class LaterReactor:
    """A Reactor that keeps calls until the engine exists, and then passes them on."""

    def __init__(self) -> None:
        self.used = False  # a board's input comes from outside
        self._lock = threading.Lock()  # adapters' own threads may post before the engine is there
        self._engine: Reactor | None = None
        self._kept: list[Callable[[Reactor], object]] = []

    def attach(self, engine: Reactor) -> None:
        """Pass all calls on to this engine; call this before the engine's thread runs."""
        with self._lock:
            self._engine = engine
            kept, self._kept = self._kept, []
        for ask in kept:
            ask(engine)

    def watch(
        self, source: HasFileno, readable: Callable[[], object], writable: Callable[[], object] | None = None
    ) -> None:
        self._ask(lambda engine: engine.watch(source, readable, writable))

    def unwatch(self, source: HasFileno) -> None:
        self._ask(lambda engine: engine.unwatch(source))

    def post(self, work: Callable[[], object]) -> None:
        self._ask(lambda engine: engine.post(work))

    def when_closed(self, callback: Callable[[], object]) -> None:
        self._ask(lambda engine: engine.when_closed(callback))

    def forget(self, callback: Callable[[], object]) -> None:
        self._ask(lambda engine: engine.forget(callback))

    def _ask(self, ask: Callable[[Reactor], object]) -> None:
        self.used = True
        with self._lock:
            engine = self._engine
            if engine is None:
                self._kept.append(ask)
        if engine is not None:
            ask(engine)
