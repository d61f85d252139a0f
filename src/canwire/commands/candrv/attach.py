"""`canwire candrv attach`: a device as a pseudo terminal, so that echo sends and cat shows events.

This program does not read or write the terminal itself, because only then can it see whether another program has it
open. While no program has the terminal open, events are dropped, as with a handle that is not open. When a program
closes the terminal, its unread events and its unfinished command are dropped. While a program has it open but does not
read, events wait in the device's event queue, which counts what it loses.
"""

from __future__ import annotations

import argparse
import os
import re
import select
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from canwire import BadValue, CanwireError, Unsupported
from canwire.commands.can_line import point_out_rates
from canwire.commands.candrv.work import work
from canwire.commands.console import complain
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire.candrv import Handle

_LARGEST_READ = 4096
_LONGEST_LINE = 1000  # characters; more without an end is no message
_LOOK_S = 0.01  # between two looks whether somebody opened it
_CHECK_MS = 200
_END = re.compile(rb"[\r\n\0]")


def attach(arguments: argparse.Namespace) -> int:
    """Serve the terminal until Ctrl-C, SIGTERM or the end of the device; raises BadValue for a path that is taken."""
    from canwire import candrv

    if sys.platform == "win32":
        raise Unsupported("attach: there are no pseudo terminals on Windows")
    with ExitStack() as closing:
        hub = connected(arguments, "candrv attach", closing)
        handle = closing.enter_context(candrv.open(arguments.device, read=True, write=True, hub=hub))
        point_out_rates(hub, handle.device.line.bus)
        settings = handle.device.settings
        if not settings.acceptance_code and not settings.acceptance_mask:
            handle.accept_all()
        terminal = closing.enter_context(Terminal())
        closing.enter_context(Link(arguments.path, terminal.name))
        reader = Reader(handle, terminal)
        reader.start()

        def stop() -> None:
            terminal.leave()
            handle.close()

        closing.callback(reader.join)
        closing.callback(stop)
        start = f"{arguments.device} is {arguments.path} ({terminal.name})"
        try:
            work(lambda: _serve(handle, terminal, reader, start), stop)
        except KeyboardInterrupt:
            return 0
    return 0


def _serve(handle: Handle, terminal: Terminal, reader: Reader, start: str) -> None:
    from canwire.candrv import CandrvError, Win32Error

    print(start, flush=True)

    for line in terminal.lines():
        if reader.error is not None:
            raise reader.error
        if line:
            try:
                handle.write_text(line)
            except CandrvError as error:
                if error.code != Win32Error.ERROR_INVALID_PARAMETER:  # the device, not the line
                    raise
                complain(f"{_ascii(line)}: {error}")


def _ascii(line: bytes) -> str:
    return ascii(line.decode("latin-1"))[:80]


class Link:
    """A symbolic link, for the length of a with block; one that leads nowhere is replaced."""

    def __init__(self, path: Path, target: str) -> None:
        self._path, self._target = path, target

    def __enter__(self) -> Link:
        if self._path.is_symlink() and not self._path.exists():
            self._path.unlink()
        try:
            self._path.symlink_to(self._target)
        except FileExistsError:
            raise BadValue(f"{self._path}: something is there already") from None
        except OSError as error:
            raise BadValue(f"{self._path}: {error.strerror}") from None
        return self

    def __exit__(self, *_: object) -> None:
        with suppress(OSError):
            if os.readlink(self._path) == self._target:
                self._path.unlink()


class Terminal:
    """Our end of a pseudo terminal in raw mode; `name` is the other end's."""

    def __init__(self) -> None:
        import pty
        import tty

        self._ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self.name = os.ttyname(theirs)
        os.close(theirs)
        os.set_blocking(self._ours, False)
        self._open = threading.Event()
        self._left = threading.Event()
        self._writing = threading.Lock()  # nothing is written between an opener's end and the flush after it

    @property
    def is_open(self) -> bool:
        """Whether a program has the terminal open."""
        return self._open.is_set()

    def lines(self) -> Iterator[bytes]:
        """What openers write, line by line, and b"" now and then."""
        poll = select.poll()
        poll.register(self._ours, select.POLLIN)
        pending = b""
        while not self._left.is_set():
            ready = dict(poll.poll(_CHECK_MS)).get(self._ours, 0)
            if ready & select.POLLHUP:
                data = self._read()
                if not data:
                    pending = b""
                    self._forget()
                    time.sleep(_LOOK_S)
                    yield b""
                    continue
            else:
                self._open.set()
                data = self._read() if ready else b""
            *whole, pending = _split(pending + data)
            yield from whole or [b""]
            if len(pending) > _LONGEST_LINE:
                complain(f"{_ascii(pending)}: {len(pending)} characters and no end of a line")
                pending = b""

    def write(self, text: bytes) -> None:
        """Write an event for the reader; waits for room while a program has the terminal open."""
        poll = select.poll()
        poll.register(self._ours, select.POLLOUT)
        while text and not self._left.is_set():
            try:
                with self._writing:
                    if not self.is_open:
                        return
                    text = text[os.write(self._ours, text) :]
            except BlockingIOError:
                poll.poll(_CHECK_MS)
            except OSError:  # nobody there any more
                return

    def leave(self) -> None:
        """End every wait for this terminal."""
        self._left.set()

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._ours)

    def _read(self) -> bytes:
        try:
            return os.read(self._ours, _LARGEST_READ)
        except OSError:  # nothing there, or nobody
            return b""

    def _forget(self) -> None:
        """The last opener has gone: what it did not read is not for the next one."""
        import termios

        if not self._open.is_set():
            return
        with self._writing, suppress(OSError):
            self._open.clear()
            theirs = os.open(self.name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                termios.tcflush(theirs, termios.TCIFLUSH)
            finally:
                os.close(theirs)


class Reader(threading.Thread):
    """Events of the device to the terminal; `error` is why it ended."""

    def __init__(self, handle: Handle, terminal: Terminal) -> None:
        super().__init__(daemon=True)
        self._handle, self._terminal = handle, terminal
        self.error: CanwireError | None = None

    def run(self) -> None:
        """Forward events until the handle is closed."""
        try:
            while True:
                text = self._handle.read_text()
                if self._terminal.is_open:
                    self._terminal.write(text)
        except CanwireError as error:
            self.error = error


def _split(text: bytes) -> list[bytes]:
    """Lines with their ends, and last what has no end yet."""
    parts, start = [], 0
    for end in _END.finditer(text):
        parts.append(text[start : end.end()])
        start = end.end()
    return [*parts, text[start:]]
