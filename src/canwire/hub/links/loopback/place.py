"""How programs find a hub on the loopback address: a file with its port and a token, which only its user can read."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import re
import sqlite3
import stat
from collections.abc import Iterator
from dataclasses import dataclass, field

from canwire.errors import HubError
from canwire.places import runtime_directory
from canwire.platform.portable.memory import check_private

TOKEN_SIZE = 32
_TEXT = re.compile(rb"canwire hub on loopback, version 1\nport (\d{1,5})\ntoken ([0-9a-f]{64})\n")
_LARGEST = 256  # bytes of such a file; more is none
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
_OLD = os.O_RDONLY
for _flag in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_BINARY", "O_NOINHERIT"):
    _OLD |= getattr(os, _flag, 0)
_NO_PLACE = (errno.ENOENT, errno.ENOTDIR, errno.ELOOP, errno.ENXIO, errno.EISDIR)  # nothing, a link, a socket
_LOCK_PATIENCE_S = 10.0


@dataclass(frozen=True)
class Place:
    """The port of a hub, and the token that its callers must know."""

    port: int
    token: bytes = field(repr=False)

    def proof(self, nonce: bytes) -> bytes:
        """The answer to this nonce, which only a program that knows the token can compute."""
        return hashlib.blake2b(nonce, key=self.token, digest_size=32, person=b"canwire hub").digest()

    def write(self, path: str) -> None:
        """Write the file at `path` atomically, readable for this user only; an existing file is replaced."""
        own = f"{path}.new"
        with contextlib.suppress(FileNotFoundError):  # of a hub that was killed while it wrote
            os.unlink(own)
        text = f"canwire hub on loopback, version 1\nport {self.port}\ntoken {self.token.hex()}\n"
        try:
            descriptor = os.open(own, _NEW, 0o600)
            with open(descriptor, "wb") as file:
                file.write(text.encode())
            os.replace(own, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(own)
            raise


def read_place(path: str) -> Place | None:
    """The place that a hub wrote there; None if the file does not exist or has other contents.

    Raises HubError if other users than this one (or root) could have written the file, or can read it.
    """
    try:
        descriptor = os.open(path, _OLD)
    except PermissionError:
        raise HubError(f"{path} belongs to another user; choose another path") from None
    except OSError as error:
        if error.errno in _NO_PLACE:
            return None
        raise HubError(f"{path}: {error.strerror or error}") from error
    try:
        state = os.fstat(descriptor)
        text = os.read(descriptor, _LARGEST + 1) if stat.S_ISREG(state.st_mode) else b""
    finally:
        os.close(descriptor)
    found = _TEXT.fullmatch(text)
    if found is None or not 0 < int(found[1]) < 1 << 16:
        return None
    try:
        check_private(path, state)
    except PermissionError as error:
        raise HubError(f"{error}; choose another path") from None
    return Place(int(found[1]), bytes.fromhex(found[2].decode()))


def remove_place(path: str, place: Place) -> None:
    """Remove the file of a hub, unless another hub has replaced it since."""
    with contextlib.suppress(HubError, FileNotFoundError):
        if read_place(path) == place:
            os.unlink(path)


@contextlib.contextmanager
def changing_places() -> Iterator[None]:
    """Lock out this user's other hubs while a hub checks whether a place is free, and takes it.

    File locks differ between systems; SQLite supports all of them, and its locks end with the process.
    """
    path = os.path.join(runtime_directory(), "canwire.lock")
    lock = sqlite3.connect(path, timeout=_LOCK_PATIENCE_S, isolation_level=None)
    try:
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.Error as error:
        lock.close()
        raise HubError(
            f"{path}: {error}; another hub of this user is starting, and has been for {_LOCK_PATIENCE_S:.0f} seconds"
        ) from None
    try:
        yield
    finally:
        lock.close()  # which ends the transaction
