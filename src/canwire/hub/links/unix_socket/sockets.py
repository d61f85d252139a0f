"""Unix sockets at paths: listening for one user only, connecting, and never disturbing a running hub."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import stat
import struct
import sys

from canwire.errors import BadValue, HubError, HubLost
from canwire.places import locked_directory
from canwire.platform.linux import peer_of

_BACKLOG = 1024  # callers that wait to be let in; systems have lower limits
_DIAL_TIMEOUT_S = 2
_LONGEST_PATH = (
    107 if sys.platform == "linux" else 103
)  # bytes that sockaddr_un has room for, beside its zero
_MEANWHILE = ".new"
_TIME = struct.Struct("@ll")  # timeval
_NOBODY = (errno.ECONNREFUSED, errno.ENOENT)


def listen_at(path: str) -> socket.socket:
    """A listening socket that only this user can reach; the socket of a dead hub is replaced.

    Raises HubError if a running hub listens there or the path is not a socket, and OSError with its path if no room
    or no right exists to make one.
    """
    path = os.path.abspath(path)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        with locked_directory(os.path.dirname(path)):
            _check_room(path)
            _appear(listener, path)
    except BaseException as error:
        listener.close()
        if isinstance(error, OSError) and error.errno is not None:
            error.filename = error.filename or path  # `bind` names none: a full disk would be the output's
        raise
    listener.setblocking(False)
    return listener


def remove(path: str, identity: tuple[int, int]) -> None:
    """Remove the file of a socket, unless another hub has replaced it since."""
    with contextlib.suppress(FileNotFoundError):
        if identity_of(path) == identity:
            os.unlink(path)


def identity_of(path: str) -> tuple[int, int]:
    """An identity that distinguishes a file from a later one at the same path."""
    state = os.lstat(path)
    return state.st_dev, state.st_ino


def dial(address: str) -> socket.socket:
    """A connection to the hub at this path; raises HubLost if no hub listens there or accepts it within two seconds.

    Raises HubError if a program of another user listens, because this one would map its memory; root may call all.

    If many programs call at the same time, it waits in the queue: a socket with Python's own timeout would not.
    """
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _TIME.pack(_DIAL_TIMEOUT_S, 0))
        connection.connect(address)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _TIME.pack(0, 0))
    except BlockingIOError:
        connection.close()
        raise HubLost(
            f"{address}: a program listens but accepts no connection for {_DIAL_TIMEOUT_S} seconds; is the hub stopped?"
        ) from None
    except OSError as error:
        connection.close()
        if error.errno in _NOBODY:
            raise HubLost(
                f"no hub listens on {address}; start one: canwire serve --socket {address}"
            ) from None
        raise HubLost(f"{address}: {error.strerror or error}") from error
    peer = peer_of(connection)
    if peer is not None and os.geteuid() != 0 and peer[1] not in (os.geteuid(), 0):
        connection.close()
        raise HubError(
            f"{address}: user {peer[1]} listens there, not {os.geteuid()}; connect to a hub of yours"
        )
    return connection


def somebody_listens(path: str) -> bool:
    """Whether a running hub listens there; raises HubError if the socket is another user's."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as caller:
        caller.setblocking(False)  # a full backlog is a sign of life, not worth waiting for
        failure = caller.connect_ex(path)
    if failure == errno.EACCES:
        raise HubError(f"{path} belongs to another user; choose another path")
    return failure not in _NOBODY


def _check_room(path: str) -> None:
    try:
        mode = os.lstat(path).st_mode
    except FileNotFoundError:
        return
    if not stat.S_ISSOCK(mode):
        raise HubError(f"{path} is no socket; give --socket another path, or remove it")
    if somebody_listens(path):
        raise HubError(f"another hub listens on {path}; connect to that one, or give --socket another path")


def _appear(listener: socket.socket, path: str) -> None:
    """Move the listening socket to its path; a caller that finds the file is therefore never refused.

    It replaces the file of a dead hub. The directory is locked, so no other hub uses the temporary name.
    """
    meanwhile = os.path.join(os.path.dirname(path), _MEANWHILE)
    if max(len(os.fsencode(path)), len(os.fsencode(meanwhile))) > _LONGEST_PATH:
        raise BadValue(f"{path}: too long for a socket, about 100 bytes are possible")
    with contextlib.suppress(FileNotFoundError):
        os.unlink(meanwhile)
    os.fchmod(listener.fileno(), 0o600)  # Linux then creates the file with this mode from the start
    listener.bind(meanwhile)
    os.chmod(meanwhile, 0o600)
    listener.listen(_BACKLOG)
    os.replace(meanwhile, path)
