"""Signals that come in the middle of an import are handled once it is over.

An exception in the middle of one can leave a module's lock taken, on which the next import of it waits for ever, or be
raised where the interpreter only prints it (the callback that forgets such a lock) and the signal has done nothing.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any, TypeVar

Result = TypeVar("Result")
Handler = Callable[[int, "FrameType | None"], Any]

_MACHINERY = "<frozen importlib"
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
_NUMBERS = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))


def with_whole_imports(call: Callable[[], Result]) -> Result:
    """What `call` returns or raises. In other threads than the main one signals are somebody else's."""
    before: dict[int, Handler] = {}
    try:
        for number in _NUMBERS:
            handler = signal.getsignal(number)
            if callable(handler):
                signal.signal(number, _deferred(handler))
                before[number] = handler
    except ValueError:  # no main thread
        pass
    try:
        return call()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _deferred(handler: Handler) -> Handler:
    def handle(number: int, frame: FrameType | None) -> None:
        importing = _outermost_import(frame)
        if importing is None:
            handler(number, frame)
        else:
            sys.setprofile(_After(importing, handler, number))

    return handle


class _After:
    """A profile function of the main thread that calls `handler` at its first step outside of imports."""

    def __init__(self, importing: FrameType, handler: Handler, number: int) -> None:
        self._importing: FrameType | None = importing
        self._handler, self._number = handler, number
        self._before = sys.getprofile()

    def __call__(self, frame: FrameType, event: str, argument: object) -> None:
        if self._importing is None:
            self._importing = _outermost_import(frame)
            if self._importing is None:
                sys.setprofile(self._before)
                self._handler(self._number, frame)
        elif event == "return" and frame is self._importing:
            self._importing = None  # the next step is the first that may be outside


def _outermost_import(frame: FrameType | None) -> FrameType | None:
    """The import that this frame is part of, as far as it was begun by what `with_whole_imports` called."""
    found = None
    while frame is not None and frame.f_code is not with_whole_imports.__code__:
        if frame.f_code.co_filename.startswith(_MACHINERY):
            found = frame
        frame = frame.f_back
    return found
