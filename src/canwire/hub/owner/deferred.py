"""An answer that is given later, by the timeline."""

from __future__ import annotations

from collections.abc import Callable

from canwire.errors import CanwireError
from canwire.hub.protocol.link import Answer


class Deferred:
    """Settled once, with an answer or an error; functions that are added later are called immediately."""

    def __init__(self) -> None:
        self._result: Answer | CanwireError | None = None
        self._callbacks: list[Callable[[Answer | CanwireError], None]] = []

    @property
    def settled(self) -> bool:
        return self._result is not None

    def settle(self, result: Answer | CanwireError) -> None:
        """Set the answer or error; a second call has no effect."""
        if self._result is None:
            self._result = result
            callbacks, self._callbacks = self._callbacks, []
            for callback in callbacks:
                callback(result)

    def on_done(self, callback: Callable[[Answer | CanwireError], None]) -> None:
        if self._result is None:
            self._callbacks.append(callback)
        else:
            callback(self._result)
