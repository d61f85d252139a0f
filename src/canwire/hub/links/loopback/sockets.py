"""TCP on the loopback address: listening at the port of a place file, connecting to it, and mutual authentication.

A caller sends the token, 16 random bytes and its process number. The hub reads only the token until it has checked it.
Its answer to the random bytes proves that it knows the token too, because another program may by now use the port of a
dead hub.
"""

from __future__ import annotations

import contextlib
import hmac
import os
import secrets
import socket
import struct

from canwire.errors import HubError, HubLost
from canwire.hub.links.loopback.place import TOKEN_SIZE, Place, changing_places, read_place
from canwire.platform.portable.pairs import LOOPBACK, loopback_listener

REST = struct.Struct("<16sI")  # of a caller's first bytes, after the token: nonce, process
NONCE_SIZE, PROOF_SIZE = 16, 32
_BACKLOG = 1024  # callers that wait to be let in; systems have lower limits
_CONNECT_TIMEOUT_S = 5.0  # a dead port is refused immediately, but Windows tries again for two seconds
_DIAL_TIMEOUT_S = 2.0


def listen_at(path: str) -> tuple[socket.socket, Place]:
    """A listening socket, and its place, which is written to `path`; the file of a dead hub is replaced.

    Raises HubError if a running hub listens there, or if `path` is another kind of file.
    """
    path = os.path.abspath(path)
    with changing_places():
        _make_room(path)
        listener = loopback_listener(_BACKLOG)
        try:
            place = Place(listener.getsockname()[1], secrets.token_bytes(TOKEN_SIZE))
            place.write(path)
        except BaseException:
            listener.close()
            raise
    listener.setblocking(False)
    return listener, place


def dial(address: str) -> socket.socket:
    """A connection to the hub whose place is in this file; raises HubLost if no hub answers."""
    place = read_place(address)
    if place is None:
        raise HubLost(_NOBODY.format(address))
    connection = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        connection.settimeout(_CONNECT_TIMEOUT_S)
        connection.connect((LOOPBACK, place.port))
        proven = _introduce(connection, place)
        connection.settimeout(None)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    except TimeoutError:
        connection.close()
        raise HubLost(
            f"{address}: a program listens but accepts no connection for {_DIAL_TIMEOUT_S:.0f} seconds; is the hub "
            "stopped?"
        ) from None
    except OSError:  # refused, or closed immediately: the port is free, or another program's
        proven = False
    if not proven:
        connection.close()
        raise HubLost(_NOBODY.format(address))
    return connection


def somebody_listens(path: str) -> bool:
    """Whether a running hub listens there; raises HubError if the file is another user's, or others can read it."""
    place = read_place(path)
    if place is None:
        return False
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as caller:
        caller.settimeout(_CONNECT_TIMEOUT_S)
        try:
            caller.connect((LOOPBACK, place.port))
            return _introduce(caller, place)
        except TimeoutError:  # it may be stopped, or have much to do: a sign of life
            return True
        except OSError:
            return False


def _introduce(connection: socket.socket, place: Place) -> bool:
    """Prove that this process knows the token; returns whether the other side does, too."""
    nonce = secrets.token_bytes(NONCE_SIZE)
    connection.settimeout(_DIAL_TIMEOUT_S)
    connection.sendall(place.token + REST.pack(nonce, os.getpid()))
    proof = b""
    while len(proof) < PROOF_SIZE:
        data = connection.recv(PROOF_SIZE - len(proof))
        if not data:
            return False
        proof += data
    return hmac.compare_digest(proof, place.proof(nonce))


def _make_room(path: str) -> None:
    if not os.path.lexists(path):
        if not os.path.isdir(os.path.dirname(path)):
            raise FileNotFoundError(f"no directory {os.path.dirname(path)}")
        return
    if read_place(path) is None:
        raise HubError(
            f"{path} is no socket, nor where a hub left its port; give --socket another path, or remove it"
        )
    if somebody_listens(path):
        raise HubError(f"another hub listens on {path}; connect to that one, or give --socket another path")
    with contextlib.suppress(FileNotFoundError):  # it has been removed this very moment
        os.unlink(path)


_NOBODY = "no hub listens on {0}; start one: canwire serve --socket {0}"
