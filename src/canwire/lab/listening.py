"""A temporary second listener for records that arrive in a ring."""

from __future__ import annotations

from collections.abc import Callable

from canwire.ring import Ring


class Listening:
    """Inside the `with` block, `callback` is called after the previous listener of the ring."""

    def __init__(self, ring: Ring, callback: Callable[[], None]) -> None:
        self._ring = ring
        self._callback = callback

    def __enter__(self) -> None:
        self._before = self._ring.listener
        before, callback = self._before, self._callback
        if before is None:
            self._ring.listener = callback
        else:

            def both() -> None:
                before()
                callback()

            self._ring.listener = both

    def __exit__(self, *_: object) -> None:
        self._ring.listener = self._before
