"""Events for changes of the list of boards."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.hub.handles.event import Event
from canwire.hub.protocol import messages as m
from canwire.platform import EventDescriptor
from canwire.values.checks import instance

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client


class BoardWatch:
    """Passes notices of the hub on to any number of events: each change signals each event once."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._lock = threading.Lock()
        self._watchers: list[Watcher] = []
        self._asked = False

    def assign(self, event: Event) -> None:
        """Signal this event from now on; while it is already signalled, further changes have no effect."""
        instance("event", event, Event)
        if not self._asked:
            self._client.call(m.Watch())
            self._asked = True
        with self._lock:
            if any(watcher.event is event for watcher in self._watchers):
                return
            watcher = Watcher(event, self._client)
            self._watchers.append(watcher)
        event.bind(watcher)

    def unassign(self, event: Event) -> None:
        """Undo `assign`; an unknown event is ignored."""
        with self._lock:
            found = [watcher for watcher in self._watchers if watcher.event is event]
            self._watchers = [watcher for watcher in self._watchers if watcher.event is not event]
        self._end(found)

    def notice(self, notice: m.Message | None) -> None:
        """Signal the events at BoardsChanged, and at None: a hub that is gone has no boards."""
        if not isinstance(notice, m.Gone):
            with self._lock:
                for watcher in self._watchers:
                    watcher.descriptor.signal()
                    if notice is not None:
                        watcher.stir()

    def close(self) -> None:
        with self._lock:
            found, self._watchers = self._watchers, []
        self._end(found)

    @staticmethod
    def _end(watchers: list[Watcher]) -> None:
        for watcher in watchers:
            watcher.event.unbind(watcher)
            watcher.descriptor.close()


class Watcher:
    """One event's signal (hub/handles/event.py)."""

    def __init__(self, event: Event, client: Client) -> None:
        self.event = event
        self._client = client
        self.descriptor = EventDescriptor()

    @property
    def advance(self) -> Callable[[Callable[[], bool], float | None], bool] | None:
        return self._client.advance if self._client.timed else None

    @property
    def clock(self) -> Callable[[], int] | None:
        return self._client.now_ns if self._client.timed else None

    def rearm(self) -> None:
        """Nothing: every change signals."""

    def stir(self) -> None:
        self._client.stir()
