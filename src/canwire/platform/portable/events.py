"""Events for systems that cannot send descriptors: each process has a copy, and links pass signals on to the others.

Inside a process an event is a pair of sockets, made at the first wait for it or the first call of `fileno`.
"""

from __future__ import annotations

import contextlib
import threading
from socket import socket
from typing import Protocol

from canwire.platform.portable.pairs import connected_pair
from canwire.platform.waiting import Waiting, wait_readable

_ALL = 1 << 16


class Beyond(Protocol):
    """The access of an event to its other copies."""

    def signalled(self, event: EventDescriptor) -> None:
        """This copy was signalled here: signal the other copies, if they are meant to receive it."""

    def left(self, event: EventDescriptor) -> None:
        """This copy was closed."""


class Follower(Protocol):
    """Is notified when an event is signalled, here or by another copy, and when the signal is cleared."""

    def heard(self) -> None: ...
    def cleared(self) -> None: ...
    def ended(self) -> None:
        """The hub has closed its event: no other copy is signalled any more."""


class EventDescriptor(Waiting):
    """A wake-up that threads and processes share: `signal` it, `wait` for it, select on `fileno()`."""

    def __init__(self, beyond: Beyond | None = None, *, shared: bool = False) -> None:
        self._beyond = SharedEvent(both_ways=True).joined_by(self) if shared else beyond
        self._followers: tuple[Follower, ...] = ()
        self._lock = threading.Lock()  # while the pair is made and closed
        self._pair: tuple[socket, socket] | None = None
        self._pending = False  # signalled before there was a pair
        self._closed = False

    @classmethod
    def adopt(cls, *copies: EventDescriptor) -> EventDescriptor:
        """Take over a copy that arrived over a link."""
        return copies[0]

    @classmethod
    def adopt_each(cls, copies: tuple[EventDescriptor, ...], count: int) -> list[EventDescriptor]:
        """`count` events."""
        return list(copies[:count])

    def __repr__(self) -> str:
        state = "closed" if self._closed else "idle" if self._pair is None else str(self._pair[0].fileno())
        return f"<event descriptor {state}>"

    def copies(self) -> tuple[EventDescriptor, ...]:
        """One more copy of this `shared` event, in this process; the caller owns it."""
        assert isinstance(self._beyond, SharedEvent), "only a shared event is passed on"
        return self._beyond.copies()

    def fileno(self) -> int:
        pair = self._pair
        if pair is None:
            with self._lock:
                pair = self._pair or self._make_pair()
        return pair[0].fileno()

    @property
    def beyond(self) -> Beyond | None:
        """The access to the other copies."""
        return self._beyond

    def signal(self) -> None:
        """Wake a waiting thread; signals that were not consumed yet count as one."""
        self.receive()
        self.tell_others()

    def tell_others(self) -> None:
        """Signal the other copies, if they are meant to receive signals of this one."""
        beyond = self._beyond
        if beyond is not None:
            beyond.signalled(self)

    def receive(self) -> None:
        """Another copy was signalled."""
        pair = self._pair
        if pair is None:
            self._pending = True
            pair = self._pair  # made this very moment, without having seen it
        if pair is not None:
            self._send(pair[1])
        for follower in self._followers:
            follower.heard()

    def is_set(self) -> bool:
        """Whether it is signalled now; does not consume the signal."""
        pair = self._pair
        if self._closed or pair is None:
            return self._pending
        return wait_readable([pair[0].fileno()], 0)

    def wait(self, timeout: float | None = None) -> bool:
        """Consume a signal, waiting at most `timeout` seconds for it (None: forever); False if none came."""
        if self._closed:
            return False
        if self._pair is None and timeout == 0:
            taken, self._pending = self._pending, False
        else:
            taken = wait_readable([self.fileno()], timeout) and self._drain()
        if taken:
            self._tell_cleared()
        return taken

    def take(self) -> bool:
        """Consume a pending signal without waiting; returns whether one was pending."""
        taken, self._pending = self._pending, False
        if self._pair is not None:
            taken = self._drain() or taken
        self._tell_cleared()
        return taken

    def clear(self) -> None:
        """Consume a pending signal without waiting."""
        self.take()

    def follow(self, follower: Follower) -> None:
        """Notify this follower of signals, and of their clearing, from now on."""
        with self._lock:
            self._followers = (*self._followers, follower)

    def unfollow(self, follower: Follower) -> None:
        with self._lock:
            self._followers = tuple(other for other in self._followers if other is not follower)

    def end(self) -> None:
        """The hub has closed the original event of this copy."""
        for follower in self._followers:
            follower.ended()

    def close(self) -> None:
        """Close it; a second call does nothing. Later calls signal nothing."""
        with self._lock:
            closed, self._closed = self._closed, True
            pair, self._followers = self._pair, ()
        if closed:
            return
        for end in pair or ():
            end.close()
        if self._beyond is not None:
            self._beyond.left(self)
            self._beyond = None

    def __del__(self) -> None:
        if not getattr(self, "_closed", True):
            self.close()

    def _make_pair(self) -> tuple[socket, socket]:
        if self._closed:
            raise OSError("this event was closed")
        pair = self._pair = connected_pair()
        if self._pending:
            self._pending = False
            self._send(pair[1])
        return pair

    def _send(self, end: socket) -> None:
        try:
            end.send(b"\x01")
        except BlockingIOError:
            pass  # full: the reader has a wake-up pending anyway
        except OSError:
            if not self._closed:
                raise

    def _drain(self) -> bool:
        assert self._pair is not None
        with contextlib.suppress(BlockingIOError):  # there is none, or another waiter was quicker
            try:
                return bool(self._pair[0].recv(_ALL))
            except OSError:
                if not self._closed:
                    raise
        return False

    def _tell_cleared(self) -> None:
        for follower in self._followers:
            follower.cleared()


class SharedEvent:
    """An event of the hub: each client has a copy of it, in this process or over a link."""

    def __init__(self, both_ways: bool) -> None:
        self._both_ways = both_ways
        self._lock = threading.Lock()
        self._copies: tuple[EventDescriptor, ...] = ()

    def copies(self) -> tuple[EventDescriptor, ...]:
        """One more copy, for a client; the caller owns it."""
        copy = EventDescriptor(self)
        self.joined_by(copy)
        return (copy,)

    def joined_by(self, copy: EventDescriptor) -> SharedEvent:
        """Make this event a copy from now on."""
        with self._lock:
            self._copies = (*self._copies, copy)
        return self

    @property
    def both_ways(self) -> bool:
        """Whether clients signal each other."""
        return self._both_ways

    def signal(self) -> None:
        """Wake the threads that wait for a copy."""
        for copy in self._copies:
            copy.receive()

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("clients wait for their copies")

    def signalled(self, event: EventDescriptor) -> None:
        if self._both_ways:
            for copy in self._copies:
                if copy is not event:
                    copy.receive()

    def left(self, event: EventDescriptor) -> None:
        with self._lock:
            self._copies = tuple(copy for copy in self._copies if copy is not event)

    def close(self) -> None:
        """End it: nothing is signalled any more; clients keep their copies."""
        with self._lock:
            copies, self._copies = self._copies, ()
        for copy in copies:
            copy.end()


def shared_event(*, both_ways: bool = False) -> SharedEvent:
    """An event of the hub; clients get `copies` of it. It signals them; `both_ways`: they also signal each other."""
    return SharedEvent(both_ways)


class AnyOf:
    """One descriptor that is readable while any of these events is signalled."""

    def __init__(self, events: list[EventDescriptor]) -> None:
        self._own = EventDescriptor()
        self._events: tuple[EventDescriptor, ...] = ()
        for event in events:
            self.add(event)

    def fileno(self) -> int:
        return self._own.fileno()

    def add(self, event: EventDescriptor) -> None:
        self._events = (*self._events, event)
        event.follow(self)
        self.cleared()

    def remove(self, event: EventDescriptor) -> None:
        """Remove an event; must be called before it is closed."""
        event.unfollow(self)
        self._events = tuple(other for other in self._events if other is not event)
        self.cleared()

    def heard(self) -> None:
        self._own.signal()

    def cleared(self) -> None:
        """Check all events again; `heard` reports a signal in the meantime after this has cleared `_own`."""
        self._own.clear()
        if any(event.is_set() for event in self._events):
            self._own.signal()

    def ended(self) -> None:
        """Nothing to do: the owner of the event may still signal it."""

    def close(self) -> None:
        for event in self._events:
            event.unfollow(self)
        self._own.close()
