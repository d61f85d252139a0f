"""Shared memory as files with random names, which only their user can access, removed when the name is not needed.

The hub makes such a file. It removes the name once all its own descriptors of the file are closed, which happens
when the client has opened the file too. Windows cannot remove a file that is mapped: the file then stays until the
next one is made. Files of a killed process are removed by the next process that makes one.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import re
import secrets
import stat
import sys
import threading

from canwire.places import runtime_directory
from canwire.platform.portable.events import EventDescriptor

_NAME = re.compile(r"canwire-(\d+)-[0-9a-f]{32}\.ring")
_FLAGS = (
    os.O_RDWR
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_NOFOLLOW", 0)
    | getattr(os, "O_BINARY", 0)
    | getattr(os, "O_NOINHERIT", 0)
)


class _Name:
    """The name of a file, while this process may still pass it on."""

    def __init__(self, path: str) -> None:
        self.path = path
        self._users = 0
        self._lock = threading.Lock()

    def use(self) -> None:
        with self._lock:
            self._users += 1

    def leave(self) -> None:
        with self._lock:
            self._users -= 1
            last = not self._users
        if last:
            with contextlib.suppress(OSError):  # Windows: it is mapped; remove_stale's business
                os.unlink(self.path)


class Memory:
    """An open file of shared memory; `name` is None in processes that did not make it."""

    def __init__(self, descriptor: int, name: _Name | None) -> None:
        self.descriptor = descriptor
        self._name = name
        self._closed = False
        if name is not None:
            name.use()

    @classmethod
    def open(cls, path: str) -> Memory:
        """Open memory that a hub made; raises PermissionError unless only this user (or root) can access the file."""
        if not _NAME.fullmatch(os.path.basename(path)):
            raise PermissionError(f"{path}: not a name of shared memory")
        descriptor = os.open(path, _FLAGS)
        try:
            check_private(path, os.fstat(descriptor))
        except BaseException:
            os.close(descriptor)
            raise
        return cls(descriptor, None)

    @property
    def path(self) -> str:
        assert self._name is not None, "only its maker passes memory on"
        return self._name.path

    def copy(self) -> Memory:
        return Memory(os.dup(self.descriptor), self._name)

    def close(self) -> None:
        """Close the file; a second call has no effect."""
        closed, self._closed = self._closed, True
        if not closed:
            os.close(self.descriptor)
            if self._name is not None:
                self._name.leave()


def check_private(path: str, state: os.stat_result) -> None:
    """Raises PermissionError if it is not a plain file, belongs to another user, or is open to others.

    On Windows access depends on the rights of the directory, which Python cannot read.
    """
    if not stat.S_ISREG(state.st_mode):
        raise PermissionError(f"{path}: not a plain file")
    if hasattr(os, "geteuid") and state.st_uid not in (os.geteuid(), 0):
        raise PermissionError(f"{path}: it belongs to user {state.st_uid}")
    if sys.platform != "win32" and state.st_mode & 0o077:
        raise PermissionError(f"{path}: others may open it (mode {stat.S_IMODE(state.st_mode):o})")


def create_memory(size: int) -> Memory:
    """New, zeroed shared memory; raises OSError if no room is left for it."""
    directory = runtime_directory()
    if sys.platform == "win32" or directory not in _SWEPT:
        _SWEPT.add(directory)
        remove_stale(directory)
    path = os.path.join(directory, f"canwire-{os.getpid()}-{secrets.token_hex(16)}.ring")
    memory = Memory(os.open(path, _FLAGS | os.O_CREAT | os.O_EXCL, 0o600), _Name(path))
    try:
        os.ftruncate(memory.descriptor, size)
    except BaseException:
        memory.close()
        raise
    return memory


def map_memory(memory: Memory) -> memoryview:
    """The whole memory as a view; `memory` may be closed afterwards."""
    size = os.fstat(memory.descriptor).st_size
    if sys.version_info >= (3, 13) and sys.platform != "win32":
        return memoryview(mmap.mmap(memory.descriptor, size, trackfd=False))  # else it keeps a duplicate
    return memoryview(mmap.mmap(memory.descriptor, size))


def duplicate(memories: tuple[Memory, ...]) -> tuple[Memory, ...]:
    """The same memory opened again: all of them, or OSError and none."""
    copies: list[Memory] = []
    try:
        for memory in memories:
            copies.append(memory.copy())
    except OSError:
        close_descriptors(*copies)
        raise
    return tuple(copies)


def close_descriptors(*things: Memory | EventDescriptor) -> None:
    """Close memory and events."""
    for thing in things:
        thing.close()


def remove_stale(directory: str) -> list[str]:
    """Remove the files of processes that are gone; returns their names."""
    removed = []
    for name in os.listdir(directory):
        found = _NAME.fullmatch(name)
        if found and not _lives(int(found[1])):
            with contextlib.suppress(OSError):  # somebody else was quicker
                os.unlink(os.path.join(directory, name))
                removed.append(name)
    return removed


def _lives(process: int) -> bool:
    if sys.platform == "win32":  # an open file cannot be removed there, so removing it is the test
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # it is somebody else's; or no number of a process, and so left alone
        return True
    return True


_SWEPT: set[str] = set()
