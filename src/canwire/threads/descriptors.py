"""select, poll and selectors for threads that take part: timeouts are in the hub's time."""

from __future__ import annotations

import selectors
from collections.abc import Callable, Iterable
from typing import Any

from canwire.threads import originals
from canwire.threads.member import current

Found = list[tuple[selectors.SelectorKey, int]]


def select(
    readers: Iterable[Any], writers: Iterable[Any], others: Iterable[Any], timeout: float | None = None, /
) -> tuple[list[Any], list[Any], list[Any]]:
    """Replaces select.select."""
    three = list(readers), list(writers), list(others)
    me = current()
    if me is None or (timeout is not None and timeout <= 0):
        return originals.select_select(*three, timeout)
    descriptors = tuple(_number(one) for some in three for one in some)

    def ready() -> bool:
        return any(originals.select_select(*three, 0))

    if not ready():
        until_ns = me.company.end_ns(timeout)
        if me.company.wait(me, ready, until_ns, f"descriptors {descriptors}", descriptors) is None:
            return originals.select_select(*three, timeout)
    return originals.select_select(*three, 0)


class Poll:
    """Replaces select.poll()."""

    def __init__(self) -> None:
        assert originals.select_poll is not None  # it is replaced only where it is
        self._poll = originals.select_poll()
        self._registered: set[int] = set()

    def register(self, descriptor: Any, *events: int) -> None:
        self._poll.register(descriptor, *events)
        self._registered.add(_number(descriptor))

    def modify(self, descriptor: Any, events: int) -> None:
        self._poll.modify(descriptor, events)

    def unregister(self, descriptor: Any) -> None:
        self._poll.unregister(descriptor)
        self._registered.discard(_number(descriptor))

    def poll(self, timeout: float | None = None) -> list[tuple[int, int]]:
        """Replaces poll's method `poll`; `timeout` is in milliseconds."""
        me = current()
        if me is None or timeout == 0:
            return self._poll.poll(timeout)
        found = self._poll.poll(0)
        if found:
            return found
        descriptors = tuple(self._registered)
        until_ns = me.company.end_ns(None if timeout is None or timeout < 0 else timeout / 1e3)
        what = f"descriptors {descriptors}"
        if me.company.wait(me, lambda: bool(self._poll.poll(0)), until_ns, what, descriptors) is None:
            return self._poll.poll(timeout)
        return self._poll.poll(0)


def selecting(original: Callable[..., Found]) -> Callable[..., Found]:
    """Replaces a selector's method `select`."""

    def select_in_time(selector: selectors.BaseSelector, timeout: float | None = None) -> Found:
        me = current()
        if me is None or (timeout is not None and timeout <= 0):
            return original(selector, timeout)
        found = original(selector, 0)
        if found:
            return found
        descriptors = tuple(key.fd for key in selector.get_map().values())
        what = f"descriptors {descriptors}"
        until_ns = me.company.end_ns(timeout)
        if me.company.wait(me, lambda: bool(original(selector, 0)), until_ns, what, descriptors) is None:
            return original(selector, timeout)
        return original(selector, 0)

    return select_in_time


def _number(descriptor: Any) -> int:
    return descriptor if isinstance(descriptor, int) else descriptor.fileno()
