"""The listening socket of a hub: it accepts clients, each with a separate connection."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
from collections import Counter
from typing import TYPE_CHECKING

from canwire.errors import BadValue, HubLost
from canwire.hub.links.stream.connection import Connection
from canwire.hub.links.stream.greetings import Greetings
from canwire.hub.owner.engine import VIRTUAL

if TYPE_CHECKING:
    from canwire.hub.owner.engine import Engine

_NO_DESCRIPTORS = (errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ENOBUFS)


class StreamServer:
    """Listens at `path` (mode 0600) for an engine with a thread, until `close`.

    Raises HubError if a running hub listens there; the file of a dead hub is replaced.
    """

    def __init__(self, engine: Engine, path: str) -> None:
        if engine.time == VIRTUAL:
            raise BadValue("virtual time is for hubs inside a process; a server has real or fast time")
        self.path = os.path.abspath(path)
        self._engine = engine
        self._listener = self._listen()
        self._connections: set[Connection] = set()
        self._processes: Counter[int] = Counter()
        self._greetings = Greetings(engine)
        self._resting = False
        self._spare = open(os.devnull)  # noqa: SIM115
        self._closed = False
        engine.when_closed(self._close)
        engine.call(lambda: engine.watch(self._listener, self._accept))

    # what a kind of stream adds

    def _listen(self) -> socket.socket:
        """A socket that clients find at `path`; raises HubError."""
        raise NotImplementedError

    def _remove(self) -> None:
        """Remove the file, so that clients do not find the hub any more."""
        raise NotImplementedError

    def _came(self, caller: socket.socket) -> None:
        """A program called: `let_in` a connection, immediately or once the caller is authenticated."""
        raise NotImplementedError

    # for everybody

    def close(self) -> None:
        """Close all connections and remove the socket; a second call does nothing."""
        if not self._engine.closed:
            with contextlib.suppress(HubLost):  # it ends this very moment, and closes this on its way
                self._engine.call(self._close)

    def _close(self) -> None:
        if self._closed:
            return
        self._closed = True
        self._remove()
        self._engine.unwatch(self._listener)
        self._engine.forget(self._close)
        self._listener.close()
        self._spare.close()
        for connection in list(self._connections):
            connection.close()

    def _accept(self) -> None:
        try:
            caller, _ = self._listener.accept()
        except OSError as error:
            if error.errno in _NO_DESCRIPTORS and not self._greetings.make_room():
                self._turn_away()
            return  # else it has gone already, or is let in at the next turn
        self._came(caller)

    def let_in(self, connection: Connection) -> None:
        """Accept the connection as a client's."""
        beside = self._processes[connection.process]
        self._processes[connection.process] += 1
        self._connections.add(connection)
        connection.open(self._greetings, beside if connection.process else 0)

    def _closed_one(self, connection: Connection) -> None:
        self._connections.discard(connection)
        self._processes[connection.process] -= 1
        if not self._processes[connection.process]:
            del self._processes[connection.process]
        self.accept_again()

    def accept_again(self) -> None:
        """Accept waiting callers, because a descriptor was released."""
        if self._resting and not self._closed:
            self._resting = False
            self._spare_again()

    def _turn_away(self) -> None:
        """No descriptors are left: without this the call would stay pending without end."""
        self._spare.close()
        with contextlib.suppress(OSError):  # it has gone by itself, or somebody took the spare one
            caller, _ = self._listener.accept()
            caller.close()
        self._spare_again()

    def _spare_again(self) -> None:
        """Reserve a descriptor for refusing callers; without one they wait until a client disconnects."""
        try:
            self._spare = open(os.devnull)  # noqa: SIM115
        except OSError:
            self._resting = True
            self._engine.unwatch(self._listener)
        else:
            self._engine.watch(self._listener, self._accept)
