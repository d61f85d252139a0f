"""The address for socketcand's clients: a TCP port, a Unix socket in the file system, or an abstract one (@name)."""

from __future__ import annotations

import contextlib
import os
import socket
import stat

from canwire import BadValue

PORT = 29536
Address = tuple[str, int] | str


def parse_address(text: str) -> Address:
    """Host and port of "127.0.0.1:29536", each of which may be left out; a path or @name unchanged. Raises BadValue."""
    if "/" in text or text.startswith("@"):
        if not hasattr(socket, "AF_UNIX"):
            raise BadValue(f"{text}: this system has no Unix sockets; HOST:PORT such as 127.0.0.1:{PORT}")
        return text
    host, colon, port = text.rpartition(":")
    if not colon:
        host, port = (text, "") if not text.isdecimal() else ("", text)
    if port and not (port.isdecimal() and int(port) < 1 << 16):
        raise BadValue(f"{text}: HOST:PORT such as 127.0.0.1:{PORT}, or the path of a Unix socket")
    return host.strip("[]") or "127.0.0.1", int(port or PORT)


def listener(address: Address) -> socket.socket:
    """A listening, non-blocking socket. Only this user can open a path. Raises OSError."""
    if isinstance(address, str):
        made = _unix_listener(address)
    else:
        family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        made = socket.create_server(address, family=family)
    made.setblocking(False)
    return made


def forget(address: Address) -> None:
    """Remove the file of a Unix socket."""
    if isinstance(address, str) and not address.startswith("@"):
        with contextlib.suppress(FileNotFoundError):
            os.unlink(address)


def shown(address: Address) -> str:
    """The address as text."""
    return address if isinstance(address, str) else f"{address[0]}:{address[1]}"


def _unix_listener(path: str) -> socket.socket:
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        if path.startswith("@"):
            made.bind(f"\0{path[1:]}")
        else:
            _remove_dead(path)
            before = os.umask(0o177)
            try:
                made.bind(path)
            finally:
                os.umask(before)
        made.listen()
    except OSError as error:
        made.close()
        raise OSError(error.errno, error.strerror, path) from None
    return made


def _remove_dead(path: str) -> None:
    """Removes the socket file of a server that was killed."""
    with contextlib.suppress(FileNotFoundError, ConnectionRefusedError):
        if not stat.S_ISSOCK(os.stat(path).st_mode):
            return
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
            probe.connect(path)
        return
    forget(path)
