"""CANTERM on a terminal, key by key, and WCT and CANSPY where stdout is none: plain bytes and lines.

Raw, Enter sends CR and received CR, LF and CR LF all begin a line; Ctrl-C ends. Otherwise stdin goes out byte by
byte as it is, and what comes goes to stdout as it is.
"""

from __future__ import annotations

import errno
import os
import select
import sys
import termios
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from canwire.commands.acan.term import CTRL_C, Printable
from canwire.commands.console import complain

if TYPE_CHECKING:
    from canwire.commands.acan.spy import Spy
    from canwire.commands.acan.term import Terminal

_LARGEST_READ = 4096
_CHECK_S = 0.5  # between two checks that the hub is still connected


class Bell:
    """Lets another thread wake `select`: it calls `ring`, which may be repeated."""

    def __init__(self) -> None:
        self._out, self._in = os.pipe()
        os.set_blocking(self._in, False)
        os.set_blocking(self._out, False)

    def fileno(self) -> int:
        return self._out

    def ring(self) -> None:
        try:
            os.write(self._in, b"!")
        except BlockingIOError:  # full: `select` wakes already
            return

    def answer(self) -> None:
        """Silent until it rings again."""
        try:
            while len(os.read(self._out, _LARGEST_READ)) == _LARGEST_READ:
                pass
        except BlockingIOError:
            return

    def close(self) -> None:
        os.close(self._out)
        os.close(self._in)


@contextmanager
def ringing() -> Iterator[Bell]:
    """Close it after whatever rings it."""
    bell = Bell()
    try:
        yield bell
    finally:
        bell.close()


def converse(terminal: Terminal, bell: Bell, greeting: str) -> None:
    """Key by key until Ctrl-C, or until the screen is gone; raises HubLost, Unplugged."""
    shown = Printable()

    def show(data: bytes) -> None:
        _write(shown.text(data).replace("\n", "\r\n").encode())

    with _raw(sys.stdin.fileno()):
        _say(greeting)
        for keys in turns(bell, terminal.check, sys.stdin.fileno()):
            show(terminal.received())
            typed, end, _ = (keys or b"").partition(CTRL_C)
            show(terminal.typed(typed))
            for complaint in _complaints(terminal):
                _say(complaint)
            if end or keys == b"":
                return


def copy(terminal: Terminal, bell: Bell, greeting: str, silence_s: float | None) -> None:
    """Bytes as they are; stdin at its end and nothing heard for `silence_s` ends it (None: never).

    Raises HubLost, Unplugged.
    """
    complain(greeting)
    at_end, heard_s = False, time.monotonic()
    for data in turns(bell, terminal.check, sys.stdin.fileno()):
        at_end = at_end or data == b""
        news = terminal.received() + terminal.send(data or b"")
        _write(news)
        for complaint in _complaints(terminal):
            complain(complaint)
        if news or not at_end:
            heard_s = time.monotonic()
        elif silence_s is not None and time.monotonic() - heard_s >= silence_s:
            return


def follow(spy: Spy, bell: Bell, count: int | None) -> None:
    """Take in what comes until so many messages were shown (None: without end); raises HubLost, Unplugged."""
    sys.stdout.flush()
    for _ in turns(bell, spy.check):
        spy.take(None if count is None else count - spy.trace.taken)
        sys.stdout.flush()
        if spy.trace.taken == count:
            return


def turns(bell: Bell, check: Callable[[], None], stdin: int | None = None) -> Iterator[bytes | None]:
    """What was typed, b"" once at its end, None when the bell rang, and now and then for nothing after `check`."""
    while True:
        sources = [bell.fileno()] if stdin is None else [bell.fileno(), stdin]
        ready = select.select(sources, [], [], _CHECK_S)[0]
        if bell.fileno() in ready:
            bell.answer()
        if stdin is None or stdin not in ready:
            if not ready:
                check()
            yield None
            continue
        data = _read(stdin)
        if not data:
            stdin = None
        yield data


def _read(stdin: int) -> bytes:
    try:
        return os.read(stdin, _LARGEST_READ)
    except OSError as error:
        if error.errno == errno.EIO:  # the terminal was closed
            return b""
        raise


@contextmanager
def _raw(screen: int) -> Iterator[None]:
    before = termios.tcgetattr(screen)
    tty.setraw(screen, termios.TCSANOW)
    try:
        yield
    finally:
        termios.tcsetattr(screen, termios.TCSADRAIN, before)


def _complaints(terminal: Terminal) -> list[str]:
    found = list(terminal.complaints)
    terminal.complaints.clear()
    return found


def _say(what: str) -> None:
    """Print one line on stderr for a screen in raw mode."""
    print(f"\r\ncanwire: {what}", end="\r\n", file=sys.stderr, flush=True)


def _write(data: bytes) -> None:
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()
