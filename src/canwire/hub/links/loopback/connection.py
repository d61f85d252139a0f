"""One client on the loopback address, once it has shown that it knows the token."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from canwire.errors import HubLost, LimitReached
from canwire.hub.links.loopback import asides
from canwire.hub.links.loopback.passing import Passing
from canwire.hub.links.stream.connection import Connection
from canwire.platform.portable.events import EventDescriptor

if TYPE_CHECKING:
    from canwire.hub.owner.engine import Engine
    from canwire.platform import Descriptor

_ASIDES = (asides.SIGNALLED, asides.FETCHED, asides.DROPPED)


class LoopbackConnection(Connection):
    """`process` is the number that the client sent, which is trusted because the client knows the token."""

    def __init__(
        self,
        engine: Engine,
        connection: socket.socket,
        closed: Callable[[Connection], object],
        process: int,
    ) -> None:
        super().__init__(engine, connection, closed)
        self.process = process
        self._passing = Passing(self._tell)
        self._ringing = False

    def close(self) -> None:
        super().close()
        self._passing.close()

    def _new_doorbell(self) -> tuple[Any, tuple[Descriptor, ...]]:
        return EventDescriptor(_Bell(self._ring)), ()

    def _forget_doorbell(self, doorbell: Any) -> None:
        """Do nothing: the doorbell exists only in this process."""

    def _sort(self, payload: bytes) -> None:
        if payload[:1] not in _ASIDES:
            super()._sort(payload)
        elif payload[:1] == asides.SIGNALLED and asides.number_in(payload) == asides.DOORBELL:
            doorbell: Any = self._doorbell
            if doorbell is not None:
                doorbell.receive()  # for those who look whether it was rung
            self._ring()
        else:
            self._passing.take(payload)

    def _ring(self) -> None:
        """Check the client's queues soon: once, for any number of signals."""
        if not self._ringing:
            self._ringing = True
            self._engine.post(self._answer_ring)

    def _answer_ring(self) -> None:
        self._ringing = False
        if not self._closed:
            self._rung()

    def _put(self, message: bytes, descriptors: tuple[Descriptor, ...], otherwise: bytes) -> None:
        if descriptors:
            self._outbox.put(self._passing.hand_over(descriptors))
        self._outbox.put(message)

    def _tell(self, number: int) -> None:
        if self._engine.inside():
            self._tell_here(number)
        else:  # another client, in this process
            with contextlib.suppress(HubLost):
                self._engine.post(partial(self._tell_here, number))

    def _tell_here(self, number: int) -> None:
        """Send immediately, because the client waits; bytes that the socket does not accept are sent later."""
        if self._closed:
            return
        try:
            self._outbox.put(asides.numbered(asides.SIGNALLED, number))
            self._outbox.flush()
        except LimitReached:  # it does not read
            self._engine.post(self.close)
        except OSError:  # it is gone, which is found out once more where it may be closed
            self._flush_soon()
        if self._outbox:
            self._flush_soon()


class _Bell:
    """The signal of the hub's end of a queue that already contains records."""

    def __init__(self, ring: Callable[[], object]) -> None:
        self._ring = ring

    def signalled(self, event: EventDescriptor) -> None:
        self._ring()

    def left(self, event: EventDescriptor) -> None:
        """The client has closed this event."""
