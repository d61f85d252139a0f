"""The server's way to wait on systems without epoll."""

from __future__ import annotations

import select
import selectors

from canwire.socketcan.loop import READABLE, WRITABLE, Polled, Waiter


class Selected:
    """For other systems: waits for sockets and events only, which is enough for socketcand's protocol."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()

    def watch(self, descriptor: int, events: int) -> None:
        if events:
            self._selector.register(descriptor, _own(events))

    def change(self, descriptor: int, events: int) -> None:
        self.forget(descriptor)
        self.watch(descriptor, events)

    def forget(self, descriptor: int) -> None:
        if descriptor in self._selector.get_map():
            self._selector.unregister(descriptor)

    def wait(self, seconds: float | None) -> list[tuple[int, int]]:
        """Descriptors and their events; empty after `seconds` (None: no limit)."""
        found = self._selector.select(seconds)
        return [
            (
                key.fd,
                (READABLE if events & selectors.EVENT_READ else 0)
                | (WRITABLE if events & selectors.EVENT_WRITE else 0),
            )
            for key, events in found
        ]

    def close(self) -> None:
        self._selector.close()


def usual() -> Waiter:
    """The best way to wait on this system."""
    return Polled() if hasattr(select, "epoll") else Selected()


def _own(events: int) -> int:
    """A selector's words for them."""
    return (selectors.EVENT_READ if events & READABLE else 0) | (
        selectors.EVENT_WRITE if events & WRITABLE else 0
    )
