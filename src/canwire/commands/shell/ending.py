"""How a command ends: by itself, by a signal, or because the reader of its output has gone. The status says which."""

from __future__ import annotations

import errno
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

FAILED, GONE = 2, 141  # a mistake; 128 + SIGPIPE
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_NAMES = (
    "SIGINT",
    "SIGTERM",
    "SIGHUP",
    "SIGBREAK",
)  # the last two: elsewhere than on Windows, and there alone
ENDING = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))


class Signalled(KeyboardInterrupt):
    """Raised for a signal that ends the command; resources are released as after Ctrl-C."""

    def __init__(self, number: int) -> None:
        super().__init__(number)  # pickle calls `__init__` with these arguments
        self.number = number


def ended_by(error: KeyboardInterrupt) -> int:
    """Return the exit status: 128 plus the number of the signal, as in shells."""
    return 128 + (error.number if isinstance(error, Signalled) else signal.SIGINT)


@contextmanager
def signals_raise() -> Iterator[None]:
    """A context in which SIGTERM and SIGHUP raise Signalled, so that they end a command as Ctrl-C does."""

    def end(number: int, frame: FrameType | None) -> None:
        raise Signalled(number)

    with _handled(end, ENDING[1:]):
        yield


@contextmanager
def signals_call(stop: Callable[[], object]) -> Iterator[None]:
    """A context in which signals call `stop`, for a verb whose regular end is a signal.

    `stop` runs in the middle of what the main thread does. It must not need a lock which that may hold: canwire.Event's
    `set` needs none, threading.Event's needs the one that its `wait` holds for moments.
    """

    def end(number: int, frame: FrameType | None) -> None:
        stop()

    with _handled(end, ENDING):
        yield


@contextmanager
def _handled(
    handler: Callable[[int, FrameType | None], object], numbers: tuple[signal.Signals, ...]
) -> Iterator[None]:
    before = {}
    try:
        for number in numbers:
            if signal.getsignal(number) is not signal.SIG_IGN:  # nohup: to be left alone
                before[number] = signal.signal(number, handler)
    except ValueError:  # no main thread: signals are somebody else's
        pass
    try:
        yield
    finally:
        for number, old in before.items():
            signal.signal(number, old)


def is_full(error: Exception) -> bool:
    """Whether an error says that a file without a name, that is standard output, has no room for what was written."""
    return isinstance(error, OSError) and error.errno in _FULL and error.filename is None


def have_streams() -> None:
    """Connect closed standard streams to the null device; the next opened file would get their numbers."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            with suppress(OSError):
                nowhere = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: its own
                setattr(sys, name, open(nowhere, mode, closefd=False))  # noqa: SIM115


def forget_output() -> None:
    """Connect stdout to the null device, as the interpreter flushes it on exit when the pipe is closed."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, sys.stdout.fileno())
    except (OSError, ValueError):  # stdout was replaced by something without a descriptor
        pass
    finally:
        os.close(nowhere)
