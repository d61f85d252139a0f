"""The rings that one end of a link moves, by their role, and the events that signal work to do."""

from __future__ import annotations

import threading

from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.lockstep.stirs import IncomingStirs, OutgoingStirs
from canwire.hub.links.network.mirrors import Outgoing
from canwire.hub.links.network.notes import IncomingNotes, OutgoingNotes
from canwire.hub.links.network.watched import Watched
from canwire.platform import EventDescriptor, Poller

Sender = Outgoing | OutgoingNotes | OutgoingStirs
Taker = Incoming | IncomingNotes | IncomingStirs
Mirror = Sender | Taker | Watched


class Moved:
    """`senders`, `takers` and `watched` are new dictionaries after each change, so they can be read without a lock."""

    def __init__(self, always: tuple[EventDescriptor, ...]) -> None:
        self._lock = threading.Lock()
        self._events: dict[int, tuple[EventDescriptor, ...]] = {}
        self._bells: dict[int, EventDescriptor] = {}  # by descriptor
        self._poller = Poller()
        self.senders: dict[int, Sender] = {}
        self.takers: dict[int, Taker] = {}
        self.watched: dict[int, Watched] = {}
        for event in always:
            self._hear(event)

    def numbers(self) -> tuple[int, ...]:
        return tuple(self._events)

    def mirrors(self) -> tuple[Mirror, ...]:
        return (*self.senders.values(), *self.takers.values(), *self.watched.values())

    def mirror(self, number: int) -> Mirror | None:
        """The mirror of this number, if it is still moved."""
        return self.senders.get(number) or self.takers.get(number) or self.watched.get(number)

    def add(self, mirror: Mirror, events: tuple[EventDescriptor, ...]) -> None:
        """Move this mirror; `wait` also waits for the first of `events`."""
        number = mirror.number
        with self._lock:
            self._events[number] = events
            if isinstance(mirror, Sender):
                self.senders = {**self.senders, number: mirror}
            elif isinstance(mirror, Taker):
                self.takers = {**self.takers, number: mirror}
            else:
                self.watched = {**self.watched, number: mirror}
            for event in events[:1]:
                self._hear(event)

    def remove(self, number: int) -> tuple[Mirror | None, tuple[EventDescriptor, ...]]:
        """Remove a mirror; returns it (None: unknown) and its events, which the caller has to close."""
        with self._lock:
            events = self._events.pop(number, ())
            mirror = self.mirror(number)
            self.senders = {n: one for n, one in self.senders.items() if n != number}
            self.takers = {n: one for n, one in self.takers.items() if n != number}
            self.watched = {n: one for n, one in self.watched.items() if n != number}
            for event in events[:1]:
                del self._bells[event.fileno()]
                self._poller.unwatch(event.fileno())
        return mirror, events

    def wait(self, timeout: float) -> None:
        """Wait for any of the events, at most `timeout` seconds, and consume them."""
        found = self._poller.wait(timeout)
        with self._lock:
            for descriptor, _ in found:
                bell = self._bells.get(descriptor)
                if bell is not None:
                    bell.clear()

    def close(self) -> None:
        self._poller.close()

    def _hear(self, event: EventDescriptor) -> None:
        self._bells[event.fileno()] = event
        self._poller.watch(event.fileno(), Poller.READABLE)
