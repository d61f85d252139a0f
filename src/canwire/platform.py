"""The only file that knows operating systems: event descriptors, shared memory, where a user's sockets live.

Linux has eventfd and sealed memory files; elsewhere pipes and unlinked temporary files stand in for them.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import select
import socket
import stat
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

if sys.platform != "win32":
    import fcntl


class EventDescriptor:
    """A wake-up that threads and processes share: `signal` it, `wait` for it, select on `fileno()`."""

    def __init__(self) -> None:
        if hasattr(os, "eventfd"):
            self._read = self._write = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        else:
            self._read, self._write = os.pipe()
            os.set_blocking(self._read, False)
            os.set_blocking(self._write, False)
        self._closed = False

    @classmethod
    def adopt(cls, descriptor: int) -> EventDescriptor:
        """Take over an event's descriptor that another process passed on; with eventfd it is both ends."""
        event = cls.__new__(cls)
        event._read = event._write = descriptor
        event._closed = False
        return event

    def __repr__(self) -> str:
        return f"<event descriptor {'closed' if self._closed else self._read}>"

    def fileno(self) -> int:
        return self._read

    def sender(self) -> int:
        """The descriptor for `adopt` elsewhere, to signal this event by; it stays this event's own."""
        return self._write

    def signal(self) -> None:
        """Wake whoever waits; signals that nobody has consumed yet count as one."""
        try:
            os.write(self._write, b"\x01\0\0\0\0\0\0\0")
        except BlockingIOError:
            pass  # full: the reader has a wake-up pending anyway
        except OSError:
            if not self._closed:
                raise

    def wait(self, timeout: float | None = None) -> bool:
        """Consume a signal, waiting `timeout` seconds for it (None: for ever); False when none came."""
        if not self._closed and wait_readable([self._read], timeout):
            with contextlib.suppress(BlockingIOError):  # another waiter was quicker
                os.read(self._read, 4096)
                return True
        return False

    def clear(self) -> None:
        """Consume whatever signal there is, without waiting."""
        try:
            os.read(self._read, 4096)
        except BlockingIOError:
            pass  # there was none
        except OSError:
            if not self._closed:
                raise

    def wait_for(
        self, settled: Callable[[], bool], timeout: float | None, recheck: float | None = None
    ) -> bool:
        """Wait for signals until `settled()`, which is asked after each, is True; False once the time is over.

        `recheck` asks it every so many seconds even without a signal.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        while not settled():
            left = None if deadline is None else deadline - time.monotonic()
            if left is not None and left <= 0:
                return False
            self.wait(left if recheck is None else min(recheck, recheck if left is None else left))
        return True

    def close(self) -> None:
        """A second time does nothing; from now on nothing is signalled here, and no descriptor is touched."""
        descriptors = {self._read, self._write}
        if self.leave():
            close_descriptors(*descriptors)

    def leave(self) -> bool:
        """Close it, but leave the descriptors to their owner; False if it was closed before.

        Their numbers are forgotten: they may soon be those of somebody else's files.
        """
        if self._closed:
            return False
        self._closed = True
        self._read = self._write = -1
        return True


def wait_readable(descriptors: list[int], timeout: float | None) -> bool:
    """Block until one of them is readable, `timeout` seconds at most (None: for ever); False when time is over."""
    if max(descriptors) < 1024:  # select knows no others, but it is the quicker one and counts microseconds
        return bool(select.select(descriptors, [], [], timeout)[0])
    poll = select.poll()
    for descriptor in descriptors:
        poll.register(descriptor, select.POLLIN)
    return bool(poll.poll(None if timeout is None else timeout * 1000))


class Poller:
    """Waits for any of many descriptors; `READABLE` and `WRITABLE` are the bits of what it finds."""

    READABLE = select.POLLIN
    WRITABLE = select.POLLOUT

    def __init__(self) -> None:
        epoll = hasattr(select, "epoll")
        poll: Any = select.epoll() if epoll else select.poll()
        self._poll = poll
        self._per_second = 1 if epoll else 1000  # what their timeouts count in
        self._known: set[int] = set()
        # both wait whole milliseconds, select waits better, but only for descriptors below 1024
        own = poll.fileno() if epoll else 1024
        self._finer = [own] if own < 1024 else []

    def watch(self, descriptor: int, events: int) -> None:
        """From now on, or in place of the events before."""
        if descriptor in self._known:
            self._poll.modify(descriptor, events)
        else:
            self._poll.register(descriptor, events)
            self._known.add(descriptor)

    def unwatch(self, descriptor: int) -> None:
        """Before it is closed; an unknown one is ignored."""
        if descriptor in self._known:
            self._known.remove(descriptor)
            self._poll.unregister(descriptor)

    def wait(self, timeout: float | None) -> list[tuple[int, int]]:
        """Descriptors and their events within `timeout` seconds (None: for ever). A broken one is readable, too."""
        if timeout is not None and timeout > 0 and self._finer:
            if not select.select(self._finer, (), (), timeout)[0]:
                return []
            timeout = 0
        found: list[tuple[int, int]] = self._poll.poll(
            None if timeout is None else timeout * self._per_second
        )
        return found

    def close(self) -> None:
        self._known.clear()
        if hasattr(self._poll, "close"):
            self._poll.close()


def sharpen_sleep() -> None:
    """Let this thread's sleeps end on time: Linux lets them run some 50 microseconds over unless told otherwise."""
    with contextlib.suppress(OSError):  # not Linux, or no /proc: then they run over
        descriptor = os.open(f"/proc/{threading.get_native_id()}/timerslack_ns", os.O_WRONLY)
        try:
            os.write(descriptor, b"1000")
        finally:
            os.close(descriptor)


def peer_of(connection: socket.socket) -> tuple[int, int] | None:
    """Process and user at the other end of a Unix socket; None where the system does not tell."""
    if not hasattr(socket, "SO_PEERCRED"):
        return None
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, uid, _ = _CREDENTIALS.unpack(credentials)
    return pid, uid


@contextlib.contextmanager
def locked_directory(path: str) -> Iterator[None]:
    """Keep every other program out that asks for the same directory; it goes with the process, if need be."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def create_memory(size: int) -> int:
    """Descriptor of new shared memory of zeros, gone with the last process that has it; nobody can shrink it."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("canwire", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        os.ftruncate(descriptor, size)
        fcntl.fcntl(
            descriptor, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
        )
        return descriptor
    import tempfile

    with tempfile.TemporaryFile() as file:
        os.ftruncate(file.fileno(), size)
        return os.dup(file.fileno())


def map_memory(descriptor: int) -> memoryview:
    """The whole memory behind a descriptor, which may be closed afterwards."""
    return memoryview(mmap.mmap(descriptor, os.fstat(descriptor).st_size))


def close_descriptors(*descriptors: int) -> None:
    """Close them all."""
    for descriptor in descriptors:
        os.close(descriptor)


def duplicate(descriptors: tuple[int, ...]) -> tuple[int, ...]:
    """Descriptors of one's own for the same things: for all of them, or OSError and none."""
    copies: list[int] = []
    try:
        for descriptor in descriptors:
            copies.append(os.dup(descriptor))
    except OSError:
        close_descriptors(*copies)
        raise
    return tuple(copies)


def runtime_directory() -> str:
    """Where this user's sockets live: XDG_RUNTIME_DIR, else a directory of the user's own in the temporary one."""
    given = os.environ.get("XDG_RUNTIME_DIR")
    if given and os.path.isdir(given):
        return given
    import tempfile  # some milliseconds that few need

    own = os.path.join(tempfile.gettempdir(), f"canwire-{os.getuid()}")
    os.makedirs(own, mode=0o700, exist_ok=True)
    state = os.lstat(own)
    if not stat.S_ISDIR(state.st_mode) or state.st_uid != os.getuid() or state.st_mode & 0o077:
        raise PermissionError(
            f"{own}: not a private directory of this user; remove it or set XDG_RUNTIME_DIR"
        )
    return own


def state_directory() -> str:
    """Where this user's programs keep what shall outlive them: XDG_STATE_HOME, ~/.local/state, or the system's own."""
    if sys.platform == "win32":
        usual = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        usual = "~/Library/Application Support"
    else:
        usual = "~/.local/state"
    given = os.environ.get("XDG_STATE_HOME", "")
    return os.path.join(given if os.path.isabs(given) else os.path.expanduser(usual), "canwire")


_CREDENTIALS = struct.Struct("iII")
