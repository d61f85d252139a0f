"""A hub on the loopback address: a caller becomes a client once it has proved that it knows the token."""

from __future__ import annotations

import hmac
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.hub.links.loopback.connection import LoopbackConnection
from canwire.hub.links.loopback.place import TOKEN_SIZE, Place, remove_place
from canwire.hub.links.loopback.sockets import REST, listen_at
from canwire.hub.links.stream.server import StreamServer
from canwire.places import runtime_directory
from canwire.platform.portable.memory import remove_stale

if TYPE_CHECKING:
    from canwire.hub.owner.engine import Engine

_MOST_STRANGERS = 64  # callers that have not shown yet who they are; the oldest makes room


class LoopbackServer(StreamServer):
    """A hub's server; `path` is the path of the file with port and token."""

    def _listen(self) -> socket.socket:
        self._strangers: dict[Caller, None] = {}
        remove_stale(runtime_directory())
        listener, self._place = listen_at(self.path)
        return listener

    def _remove(self) -> None:
        remove_place(self.path, self._place)
        for stranger in list(self._strangers):
            stranger.close()

    def _came(self, caller: socket.socket) -> None:
        stranger = Caller(self._engine, caller, self._place, self._known, self._strange)
        if len(self._strangers) >= _MOST_STRANGERS:
            next(iter(self._strangers)).close()
        self._strangers[stranger] = None
        self._greetings.wait_for(stranger)
        stranger.open()

    def _known(self, stranger: Caller, process: int) -> None:
        del self._strangers[stranger]
        self._greetings.over(stranger)
        self.let_in(LoopbackConnection(self._engine, stranger.socket, self._closed_one, process))

    def _strange(self, stranger: Caller) -> None:
        del self._strangers[stranger]
        self._greetings.over(stranger)
        self.accept_again()


class Caller:
    """A caller that has not yet proved that it knows the token. Nothing after the token is read before that."""

    def __init__(
        self,
        engine: Engine,
        caller: socket.socket,
        place: Place,
        known: Callable[[Caller, int], object],
        closed: Callable[[Caller], object],
    ) -> None:
        self.socket = caller
        self._engine = engine
        self._place = place
        self._known = known
        self._closed = closed
        self._token = b""
        self._rest = b""
        caller.setblocking(False)

    def open(self) -> None:
        """Watch the caller; if the system can watch no more sockets, close the connection."""
        try:
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._engine.watch(self.socket, self._readable)
        except OSError:
            self.close()

    def let_go(self, why: str) -> None:
        """Close the connection of an unknown caller, without an answer."""
        self.close()

    def close(self) -> None:
        self._engine.unwatch(self.socket)
        self.socket.close()
        self._closed(self)

    def _readable(self) -> None:
        try:
            if len(self._token) < TOKEN_SIZE:
                self._token += self._some(TOKEN_SIZE - len(self._token))
                if len(self._token) < TOKEN_SIZE:
                    return
                if not hmac.compare_digest(self._token, self._place.token):
                    self.close()
                    return
            self._rest += self._some(REST.size - len(self._rest))
            if len(self._rest) == REST.size:
                self._answer(*REST.unpack(self._rest))
        except BlockingIOError:
            return
        except OSError:
            self.close()

    def _some(self, most: int) -> bytes:
        data = self.socket.recv(most)
        if not data:
            raise ConnectionResetError
        return data

    def _answer(self, nonce: bytes, process: int) -> None:
        self.socket.send(self._place.proof(nonce))  # the first bytes on this socket: they fit
        self._engine.unwatch(self.socket)
        self._known(self, process)
