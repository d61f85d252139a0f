"""A link over the loopback address: memory is opened by the name of its file, events arrive over the connection."""

from __future__ import annotations

import contextlib
import errno
import os
import weakref
from collections import deque
from typing import TYPE_CHECKING, Any

from canwire.errors import BadMessage
from canwire.hub.links.loopback import asides
from canwire.hub.links.loopback.sockets import dial
from canwire.hub.links.stream.client import HELLO_S, StreamLink
from canwire.platform.portable.events import EventDescriptor
from canwire.platform.portable.memory import Memory
from canwire.platform.portable.polling import sharpen_sleep

if TYPE_CHECKING:
    from canwire.hub.protocol.link import Answer
    from canwire.hub.protocol.messages import Message
    from canwire.hub.protocol.pending import Pending
    from canwire.platform import Descriptor

_RECEIVED_AT_ONCE = 1 << 16
_NO_ROOM = (errno.EMFILE, errno.ENFILE, errno.ENOMEM)


class LoopbackLink(StreamLink):
    """A link to the hub whose port is in the file at the path `address`."""

    _dial = staticmethod(dial)

    def __init__(self, address: str, name: str, hello_s: float = HELLO_S) -> None:
        self._events: weakref.WeakValueDictionary[int, EventDescriptor] = weakref.WeakValueDictionary()
        self._left: deque[int] = deque()  # closed events, which are reported to the hub with the next request
        sharpen_sleep()  # of the whole program: what it waits for with a timeout ends on time, too
        super().__init__(address, name, hello_s)

    def ring(self, number: int) -> None:
        """Report to the hub that this event was signalled here."""
        self._say(asides.numbered(asides.SIGNALLED, number))

    def leave(self, number: int) -> None:
        """This event was closed here; also called by the garbage collector, so that it takes no locks."""
        self._left.append(number)

    def begin(self, request: Message) -> Pending[Answer]:
        while self._left:
            with contextlib.suppress(IndexError):  # another thread was quicker
                self._say(asides.numbered(asides.DROPPED, self._left.popleft()))
        return super().begin(request)

    def _say(self, aside: bytes) -> None:
        if self._pid != os.getpid():  # in a fork: the connection is the parent's
            return
        with contextlib.suppress(OSError), self._sending:  # the receiving thread finds out what was wrong
            self._socket.sendall(aside)

    def _doorbell_of(self, descriptors: tuple[Descriptor, ...]) -> Any:
        return EventDescriptor(_Far(self, asides.DOORBELL, both_ways=True))

    # the receiving thread

    def _receive_some(self) -> bytes:
        return self._socket.recv(_RECEIVED_AT_ONCE)

    def _take(self, payload: bytes) -> None:
        letter = payload[:1]
        if letter == asides.SIGNALLED:
            event = self._events.get(asides.number_in(payload))
            if event is not None:  # else it was closed meanwhile
                event.receive()
        elif letter == asides.PASSED:
            self._open_all(asides.items_in(payload))
        else:
            super()._take(payload)

    def _open_all(self, items: list[tuple[str, int, str]]) -> None:
        try:
            for kind, number, path in items:
                self._descriptors.append(self._open(kind, number, path))
        except OSError as error:
            if error.errno not in _NO_ROOM:
                raise BadMessage(f"the hub's memory cannot be opened: {error}") from error
            self._truncated = True
        if any(kind == asides.MEMORY for kind, _, _ in items):
            self._say(asides.framed(asides.FETCHED))

    def _open(self, kind: str, number: int, path: str) -> Memory | EventDescriptor:
        if kind == asides.MEMORY:
            return Memory.open(path)
        event = EventDescriptor(_Far(self, number, both_ways=kind == asides.BOTH_WAYS))
        event.fileno()  # now, where a lack of descriptors has somebody to tell
        self._events[number] = event
        return event


class _Far:
    """The hub's side of an event."""

    def __init__(self, link: LoopbackLink, number: int, *, both_ways: bool) -> None:
        self._link = link
        self._number = number
        self._both_ways = both_ways

    def signalled(self, event: EventDescriptor) -> None:
        if self._both_ways:
            self._link.ring(self._number)

    def left(self, event: EventDescriptor) -> None:
        self._link.leave(self._number)
