"""One client on a Unix socket: the system reports its user, and passes descriptors on."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.errors import HubError
from canwire.hub.links.stream.connection import Connection
from canwire.platform import Descriptor, EventDescriptor
from canwire.platform.linux import peer_of

if TYPE_CHECKING:
    from canwire.hub.owner.engine import Engine


class SocketConnection(Connection):
    """A client that belongs to this user or to root."""

    def __init__(
        self, engine: Engine, connection: socket.socket, closed: Callable[[Connection], object]
    ) -> None:
        super().__init__(engine, connection, closed)
        self._peer = peer_of(connection)
        self.process = 0 if self._peer is None else self._peer[0]

    def check_caller(self) -> None:
        if self._peer is not None and self._peer[1] not in (os.geteuid(), 0):
            raise HubError(f"this hub belongs to user {os.geteuid()}")

    def _new_doorbell(self) -> tuple[EventDescriptor, tuple[Descriptor, ...]]:
        doorbell = EventDescriptor(shared=True)
        try:
            copies = doorbell.copies()
        except OSError:
            doorbell.close()
            raise

        self._engine.watch(doorbell, self._rung)
        return doorbell, copies

    def _forget_doorbell(self, doorbell: EventDescriptor) -> None:
        self._engine.unwatch(doorbell)
