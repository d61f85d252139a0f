"""Bytes to and from an adapter: in the hub's thread by the port's descriptor, else by two threads for the port.

A separate thread opens the port, searches for it again when it is lost, and then ends. All callbacks run in the hub's
thread.
"""

from __future__ import annotations

import contextlib
import os
import queue
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from canwire.drivers.outside import Reactor
from canwire.drivers.slcan_dongle.port import Port
from canwire.drivers.slcan_dongle.ports import listed_ports, open_port, reason, usb_serial_of, watchable
from canwire.errors import CanwireError, ExtraMissing

FIRST_RETRY_S, LONGEST_RETRY_S = 0.05, 1.0
_READ = 16_384
_READS = 4  # in a row; then others have their turn
_POLL_S = 0.1
_BATCHES = 8  # that the hub's thread has not taken yet
_COMMAND = 27  # bytes of the longest frame of 8 bytes
BACKLOG = 4096  # bytes that wait to be written: more says that the adapter does not read

monotonic_ns = time.monotonic_ns


class Link:
    """One port, opened again whenever it is lost; calls `opened()`, `received(bytes)`, `lost(why)` and `drained()`.

    It calls `failed(why)` each time the port cannot be opened.
    """

    def __init__(
        self,
        port: Port,
        reactor: Reactor,
        opened: Callable[[], object],
        received: Callable[[bytes], object],
        lost: Callable[[str], object],
        drained: Callable[[], object],
        failed: Callable[[str], object],
    ) -> None:
        self.where = port.url
        self.why = ""  # why it is not open
        self._failed = failed
        self._port = port
        self._reactor = reactor
        self._opened, self._received, self._lost, self._drained = opened, received, lost, drained
        self._usb_serial = port.serial
        self._source: Any = None
        self._threads: _Threads | None = None
        self._pending = bytearray()
        self._waits = False  # for the port to be writable
        self._looked = 0
        self.found = False  # by the number that the system shows
        self._closed = threading.Event()

    def open(self, after_s: float = 0.0) -> None:
        """Try to open the port until that succeeds, or until `close`."""
        if not self._closed.is_set():
            threading.Thread(target=self._search, args=(after_s,), name="canwire-port", daemon=True).start()

    def write(self, data: bytes) -> None:
        """Write without blocking: bytes that the port does not accept now are written later."""
        if self._threads is not None:
            self._threads.outgoing.put(data)
        elif self._source is not None:
            self._pending += data
            if not self._waits:
                self._flush()

    @property
    def backlog(self) -> int:
        """About how many bytes wait to be written; `drained` is called when many have become none."""
        return len(self._pending) if self._threads is None else self._threads.backlog()

    def give_up(self, why: str, after_s: float) -> None:
        """Close the port and open it again after this many seconds."""
        self._drop(why)
        self.open(after_s)

    def close(self) -> None:
        """Close the port for good; a second call has no effect."""
        self._closed.set()
        self._drop("closed")

    # in the searching thread

    def _search(self, after_s: float) -> None:
        wait_s = FIRST_RETRY_S
        self._closed.wait(after_s)
        while not self._closed.is_set():
            try:
                where = self._find()
                source = open_port(where, self._port.baudrate)
            except ExtraMissing as error:
                self._fail(str(error))
                return
            except (OSError, ValueError) as error:  # pyserial's errors are OSErrors, its bad URLs ValueErrors
                self._fail(reason(self._port.url or f"?serial={self._port.serial}", error))
                self._closed.wait(wait_s)
                wait_s = min(2 * wait_s, LONGEST_RETRY_S)
                continue
            if self._port.url and not self._usb_serial:
                self._usb_serial = usb_serial_of(where)
            with contextlib.suppress(CanwireError):
                self._reactor.post(partial(self._begin, where, source))
            return

    def _fail(self, why: str) -> None:
        self.why = why
        with contextlib.suppress(CanwireError):  # the hub has ended
            self._reactor.post(lambda: None if self._closed.is_set() else self._failed(why))

    def _find(self) -> str:
        """The port of the adapter: the one with its serial number in the system's list, else the previous one."""
        url, wanted = self._port.url, self._usb_serial
        if not wanted or "://" in url:
            return url
        listed = listed_ports()
        self.found = False
        for device, number in listed:
            if number == wanted:
                self.found = True
                return device
        if url:
            if dict(listed).get(url):
                raise FileNotFoundError(f"{url} is not the adapter {wanted}, but another adapter")
            return url
        if not listed:
            raise FileNotFoundError(f"no port with the serial number {wanted}")
        self._looked += 1  # it may be the adapter's own number: ask one after the other
        return listed[self._looked % len(listed)][0]

    # in the hub's thread

    def _begin(self, where: str, source: Any) -> None:
        if self._closed.is_set():
            source.close()
            return
        self.where, self.why = where, ""
        self._source = source
        self._pending.clear()
        if watchable(source):
            self._reactor.watch(source, self._read)
        else:
            self._threads = _Threads(source, self._reactor, self._took, self._broke, self._drained)
        self._opened()

    def _read(self) -> None:
        source = self._source
        for number in range(_READS):
            try:
                data = os.read(source.fileno(), _READ)
            except (BlockingIOError, InterruptedError):
                return
            except OSError as error:
                self._broken(error.strerror or str(error))
                return
            if not data:
                if number == 0:  # readable, and nothing there: it has ended; else a terminal has no more
                    self._broken("it ended")
                return
            self._received(data)
            if self._source is not source or len(data) < 1024:  # little: there is no more
                return

    def _flush(self) -> None:
        """Write as much as the port accepts; write the rest when it is writable."""
        source = self._source
        try:
            sent = os.write(source.fileno(), self._pending)
        except (BlockingIOError, InterruptedError):
            sent = 0
        except OSError as error:
            sent, why = len(self._pending), error.strerror or str(error)
            self._reactor.post(lambda: self._broken(why) if self._source is source else None)
        del self._pending[:sent]
        waits = bool(self._pending)
        if waits != self._waits:
            self._waits = waits
            self._reactor.watch(source, self._read, self._flush if waits else None)
            if not waits:
                self._drained()

    def _took(self, threads: _Threads, data: bytes) -> None:
        if self._threads is threads:
            self._received(data)

    def _broke(self, threads: _Threads, why: str) -> None:
        if self._threads is threads:
            self._broken(why)

    def _broken(self, why: str) -> None:
        self._drop(why)
        self._lost(why)
        self.open(FIRST_RETRY_S)

    def _drop(self, why: str) -> None:
        source, self._source = self._source, None
        threads, self._threads = self._threads, None
        self._pending.clear()
        self._waits = False
        self.why = why
        if threads is not None:
            threads.close()
        elif source is not None:
            self._reactor.unwatch(source)
            with contextlib.suppress(OSError):
                source.close()


class _Threads:
    """A port without a descriptor: one thread reads, one writes."""

    def __init__(
        self,
        source: Any,
        reactor: Reactor,
        took: Callable[[_Threads, bytes], object],
        broke: Callable[[_Threads, str], object],
        drained: Callable[[], object],
    ) -> None:
        self.outgoing: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._source = source
        self._reactor = reactor
        self._took, self._broke, self._drained = took, broke, drained
        self._crowded = False
        self._room = threading.Semaphore(_BATCHES)
        self._closed = threading.Event()
        for work in (self._read, self._write):
            threading.Thread(target=self._guarded, args=(work,), name="canwire-port", daemon=True).start()

    def backlog(self) -> int:
        waiting = self.outgoing.qsize() * _COMMAND
        if waiting > BACKLOG:
            self._crowded = True
        return waiting

    def close(self) -> None:
        """End both threads; the reading thread closes the port soon."""
        self._closed.set()
        self.outgoing.put(None)

    def _guarded(self, work: Callable[[], object]) -> None:
        try:
            work()
        except Exception as error:  # whatever a backend raises: the port is gone
            if not self._closed.is_set():
                why = str(error)
                with contextlib.suppress(CanwireError):
                    self._reactor.post(lambda: self._broke(self, why))

    def _read(self) -> None:
        source = self._source
        try:
            while not self._closed.is_set():
                if data := source.read(max(1, min(source.in_waiting, _READ))):
                    while not self._room.acquire(timeout=_POLL_S):
                        if self._closed.is_set():
                            return
                    self._reactor.post(partial(self._take, data))
        finally:
            source.close()

    def _take(self, data: bytes) -> None:
        self._room.release()
        self._took(self, data)

    def _write(self) -> None:
        while (data := self.outgoing.get()) is not None:
            self._source.write(data)
            if self._crowded and self.outgoing.empty():
                self._crowded = False
                self._reactor.post(self._drained)
