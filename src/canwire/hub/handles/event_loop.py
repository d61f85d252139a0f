"""asyncio in a hub's virtual time: a loop with the hub's clock. When all tasks wait, its thread waits at the hub."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextvars import Context
from selectors import DefaultSelector, SelectorKey
from typing import Any, Protocol, TypeVar, TypeVarTuple

Result = TypeVar("Result")
Ts = TypeVarTuple("Ts")


class Waiting(Protocol):
    """The methods of a client of the hub that the loop uses."""

    def now_ns(self) -> int: ...
    def advance(self, ready: Callable[[], bool], timeout: float | None) -> bool: ...
    def stir(self) -> None: ...


class HubLoop(asyncio.SelectorEventLoop):
    """`time()` is the hub's time in seconds."""

    def __init__(self, hub: Waiting) -> None:
        self._hub = hub
        super().__init__(_WaitingThere(hub))
        self._clock_resolution = 1e-9  # a timer is due at its nanosecond

    def time(self) -> float:
        return self._hub.now_ns() / 1e9

    def call_soon_threadsafe(
        self, callback: Callable[[*Ts], object], *args: *Ts, context: Context | None = None
    ) -> asyncio.Handle:
        handle = super().call_soon_threadsafe(callback, *args, context=context)
        self._hub.stir()
        return handle


class _WaitingThere(DefaultSelector):
    """Lets the hub's time pass instead of sleeping, until a descriptor of an event or a bus is readable."""

    def __init__(self, hub: Waiting) -> None:
        super().__init__()
        self._hub = hub

    def select(self, timeout: float | None = None) -> list[tuple[SelectorKey, int]]:
        found = super().select(0)
        if found or (timeout is not None and timeout <= 0):
            return found
        self._hub.advance(lambda: bool(super(_WaitingThere, self).select(0)), timeout)
        return super().select(0)


def run(hub: Waiting, main: Coroutine[Any, Any, Result]) -> Result:
    """Like asyncio.run, in the hub's time."""
    with asyncio.Runner(loop_factory=lambda: HubLoop(hub)) as runner:
        return runner.run(main)
