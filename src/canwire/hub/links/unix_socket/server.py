"""A hub on a Unix socket."""

from __future__ import annotations

import socket

from canwire.hub.links.stream.server import StreamServer
from canwire.hub.links.unix_socket.connection import SocketConnection
from canwire.hub.links.unix_socket.sockets import identity_of, listen_at, remove


class Server(StreamServer):
    """Listens on the Unix socket `path`."""

    def _listen(self) -> socket.socket:
        listener = listen_at(self.path)
        self._identity = identity_of(self.path)
        return listener

    def _remove(self) -> None:
        remove(self.path, self._identity)

    def _came(self, caller: socket.socket) -> None:
        self.let_in(SocketConnection(self._engine, caller, self._closed_one))
