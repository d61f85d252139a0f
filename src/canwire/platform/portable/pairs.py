"""TCP sockets that only this machine can reach, and pairs of them inside one process."""

from __future__ import annotations

import socket
import struct
import sys

LOOPBACK = "127.0.0.1"
_ABORT = struct.pack("HH" if sys.platform == "win32" else "ii", 1, 0)


def loopback_listener(backlog: int) -> socket.socket:
    """A listening socket on a port that the system chooses, and that no other program can listen on meanwhile."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if hasattr(socket, "SO_EXCLUSIVEADDRUSE"):  # on Windows others could take the port over without it
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        listener.bind((LOOPBACK, 0))
        listener.listen(backlog)
    except BaseException:
        listener.close()
        raise
    return listener


def connected_pair() -> tuple[socket.socket, socket.socket]:
    """Two sockets: the first receives what the second sends. Neither blocks, and closing them frees the port."""
    with loopback_listener(8) as listener:
        writer = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            writer.connect(listener.getsockname())
            reader = _caller(listener, writer.getsockname())
        except BaseException:
            writer.close()
            raise
    for end in (reader, writer):
        end.setblocking(False)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _ABORT)
    writer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return reader, writer


def _caller(listener: socket.socket, wanted: object) -> socket.socket:
    """The connection from the `wanted` address; connections from other programs are closed."""
    while True:
        caller, address = listener.accept()
        if address == wanted:
            return caller
        caller.close()
