"""Linux: eventfd, sealed memory files, epoll, and descriptors that are sent over Unix sockets and can be reopened.

On a Linux without one of them (a container without /proc) pipes, unlinked files and duplicates replace it.
"""

from __future__ import annotations

import contextlib
import mmap
import os
import select
import socket
import struct
import sys
import threading
from collections.abc import Callable

from canwire.platform.polling import Poller as Poller
from canwire.platform.waiting import Waiting, hears_signals, wait_readable

if sys.platform != "win32":
    import fcntl


class EventDescriptor(Waiting):
    """A wake-up that threads and processes share: `signal` it, `wait` for it, select on `fileno()`.

    An eventfd is one open file for all processes that have it: each of them can fill it and make it block the others.
    An event that is `shared` with an untrusted process is therefore a pipe, which `copies` reopens for that process.
    """

    def __init__(self, *, shared: bool = False) -> None:
        if shared or not hasattr(os, "eventfd"):
            self._read, self._write = _open_pipe()
        else:
            self._read = self._write = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._closed = self._blocks = False

    @classmethod
    def adopt(cls, *descriptors: int) -> EventDescriptor:
        """Take over the descriptor of an event from another process, or two: one to read, and one to write."""
        event = cls.__new__(cls)
        event._read, event._write = descriptors[0], descriptors[-1]
        event._closed = event._blocks = False
        return event

    def __repr__(self) -> str:
        return f"<event descriptor {'closed' if self._closed else self._read}>"

    @classmethod
    def adopt_each(cls, descriptors: tuple[int, ...], count: int) -> list[EventDescriptor]:
        """`count` events, from the `copies` of each in turn."""
        each = len(descriptors) // count
        return [cls.adopt(*descriptors[k * each : (k + 1) * each]) for k in range(count)]

    def fileno(self) -> int:
        return self._read

    def copies(self) -> tuple[int, ...]:
        """Descriptors of this shared event for `adopt` in another process; the caller owns them.

        Linux reopens the pipe: whatever that process does to its open file (fill it, make it blocking), this process
        never blocks. Without /proc they are duplicates, and a hostile process of the same user can block this one.
        """
        if _OPENS_ANEW:
            return (_opened_anew(self._read),)
        return duplicate((self._read, self._write))

    def signal(self) -> None:
        """Wake a waiting thread; signals that were not consumed yet count as one."""
        try:
            os.write(self._write, b"\x01\0\0\0\0\0\0\0")
        except (BlockingIOError, BrokenPipeError):
            pass  # full: the reader has a wake-up pending anyway; or nobody reads any more
        except OSError:
            if not self._closed:
                raise

    def wait(self, timeout: float | None = None) -> bool:
        """Consume a signal, waiting at most `timeout` seconds for it (None: forever); False if none came."""
        if not self._closed and wait_readable([self._read], timeout):
            return self.take()  # unless another waiter was quicker
        return False

    def rest(self) -> None:
        """As in Waiting. The read itself blocks if only this process has the descriptor."""
        if hears_signals() or not _OPENS_ANEW or self._closed:
            self.wait()
            return
        if not self._blocks:
            os.set_blocking(self._read, True)
            self._blocks = True
        os.read(self._read, _ALL)

    def take(self) -> bool:
        """Consume a pending signal without waiting; returns whether one was pending."""
        try:
            return bool(os.read(self._read, _ALL))
        except BlockingIOError:
            return False
        except OSError:
            if not self._closed:
                raise
            return False

    def clear(self) -> None:
        """Consume a pending signal without waiting."""
        self.take()

    def close(self) -> None:
        """Close it; a second call does nothing. Later calls signal nothing and touch no descriptor."""
        descriptors = {self._read, self._write}
        if self.leave():
            close_descriptors(*descriptors)

    def __del__(self, ending: Callable[[], bool] = sys.is_finalizing) -> None:
        if not getattr(self, "_closed", True) and not ending():  # at its end the system closes what is open
            self.close()

    def leave(self) -> bool:
        """Close it, but leave the descriptors to their owner; False if it was already closed.

        Their numbers are forgotten, because they may soon belong to other files.
        """
        if self._closed:
            return False
        self._closed = True
        self._read = self._write = -1
        return True


def _open_pipe() -> tuple[int, int]:
    """Both ends of a pipe that never blocks; the same descriptor for both if the system supports that."""
    ends = os.pipe()
    try:
        if _OPENS_ANEW:
            both = _opened_anew(ends[0])
            close_descriptors(*ends)
            return both, both
        for end in ends:
            os.set_blocking(end, False)
    except OSError:
        close_descriptors(*ends)
        raise
    return ends


def _opened_anew(pipe: int) -> int:
    """The same pipe as a separate open file for reading and writing, which holds at most what one read returns."""
    descriptor = os.open(f"/proc/self/fd/{pipe}", os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    with contextlib.suppress(OSError):  # a process that already has it may have filled it
        fcntl.fcntl(descriptor, fcntl.F_SETPIPE_SZ, _ALL)
    return descriptor


def shared_event(*, both_ways: bool = False) -> EventDescriptor:
    """An event of the hub; clients get `copies` of it. It signals them; `both_ways`: they also signal each other."""
    return EventDescriptor(shared=True)


class AnyOf:
    """One descriptor that is readable while any of these events is signalled."""

    def __init__(self, events: list[EventDescriptor]) -> None:
        self._poll = select.epoll()
        for event in events:
            self.add(event)

    def fileno(self) -> int:
        return self._poll.fileno()

    def add(self, event: EventDescriptor) -> None:
        self._poll.register(event.fileno(), select.EPOLLIN)

    def remove(self, event: EventDescriptor) -> None:
        """Remove an event; must be called before it is closed."""
        with contextlib.suppress(OSError, ValueError):  # closed before, and so gone from the poll
            self._poll.unregister(event.fileno())

    def close(self) -> None:
        self._poll.close()


def sharpen_sleep() -> None:
    """Make this thread's sleeps end on time: by default Linux lets them take some 50 microseconds longer."""
    with contextlib.suppress(OSError):  # not Linux, or no /proc: then they run over
        descriptor = os.open(f"/proc/{threading.get_native_id()}/timerslack_ns", os.O_WRONLY)
        try:
            os.write(descriptor, b"1000")
        finally:
            os.close(descriptor)


def peer_of(connection: socket.socket) -> tuple[int, int] | None:
    """Process and user at the other end of a Unix socket; None if the system does not report them."""
    if not hasattr(socket, "SO_PEERCRED"):
        return None
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, uid, _ = _CREDENTIALS.unpack(credentials)
    return pid, uid


def create_memory(size: int) -> int:
    """Descriptor of new, zeroed shared memory. It ends with the last process that has it, and cannot be shrunk."""
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
    """The whole memory of a descriptor, which may be closed afterwards."""
    size = os.fstat(descriptor).st_size
    if sys.version_info >= (3, 13):
        return memoryview(mmap.mmap(descriptor, size, trackfd=False))  # else it keeps a duplicate
    return memoryview(mmap.mmap(descriptor, size))


def close_descriptors(*descriptors: int) -> None:
    """Close them all."""
    for descriptor in descriptors:
        os.close(descriptor)


def duplicate(descriptors: tuple[int, ...]) -> tuple[int, ...]:
    """New descriptors for the same objects: for all of them, or OSError and none."""
    copies: list[int] = []
    try:
        for descriptor in descriptors:
            copies.append(os.dup(descriptor))
    except OSError:
        close_descriptors(*copies)
        raise
    return tuple(copies)


_OPENS_ANEW = sys.platform == "linux" and os.path.exists("/proc/self/fd")
_ALL = mmap.PAGESIZE if _OPENS_ANEW else 1 << 16  # bytes that an event holds at most
_CREDENTIALS = struct.Struct("iII")
