"""Signals to clients, given together so that a client is not woken separately for each frame."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial

from canwire.platform import EventDescriptor


class LateSignal:
    """An event whose signals wait until the bells are rung."""

    __slots__ = ("signal",)

    def __init__(self, event: EventDescriptor, due: deque[EventDescriptor]) -> None:
        self.signal: Callable[[], None] = partial(due.append, event)

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("only the other end of a ring waits here")


class Bells:
    """`due` are the events to signal, in order; the hub's pace rings them before it waits."""

    def __init__(self) -> None:
        self.due: deque[EventDescriptor] = deque()

    def late(self, event: EventDescriptor) -> LateSignal:
        """The object for this event at the hub's end of a ring."""
        return LateSignal(event, self.due)

    def ring(self) -> None:
        """Signal all events that are due."""
        while self.due:
            self.due.popleft().signal()
