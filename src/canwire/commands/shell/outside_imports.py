"""Signals are handled outside of imports: one that comes in the middle of an import has to wait for its end.

The same applies while an attribute of a class is made at its first use (values/frozen.py): msgspec asks for such an
attribute, takes any exception for its absence, and reports that it cannot encode the object. The signal would be lost.
It would be lost, too, where msgspec looks at the values of an enumeration, as a message to the hub is first used.
It applies to argparse, too, which changes its parser for a while and, if it is interrupted, fails to change it back.

An exception in the import system's own code can leave a module's lock taken, and the next import then waits for the
lock without end. It can also be raised where the interpreter only prints it (in the callback that removes such a
lock), so that the signal has no effect. An exception in a module that makes classes can crash an extension that does
not expect it (msgspec 0.22, which runs Python code at that point). A long import is interrupted nevertheless, but not
in the import system's own code.

The interpreter prints and drops an exception that is raised while an object is destroyed (in a finaliser or in the
callback of a weak reference); it is raised once more, at the first step after that.
"""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable
from types import FrameType
from typing import Any, TypeVar

from canwire.commands.shell.ending import ENDING

Result = TypeVar("Result")
Handler = Callable[[int, "FrameType | None"], Any]

PATIENCE_S = 1.0
_MACHINERY = "<frozen importlib"
_FINISHED_FIRST = ("canwire.values.frozen", "canwire.hub.protocol.messages", "argparse")


def signals_outside_imports(call: Callable[[], Result]) -> Result:
    """Run `call` and return its result. It handles signals in the main thread only."""
    before: dict[int, Handler] = {}
    try:
        for number in ENDING:
            handler = signal.getsignal(number)
            if callable(handler):
                signal.signal(number, _put_off(handler))
                before[number] = handler
    except ValueError:  # no main thread
        pass
    forgotten = sys.unraisablehook
    sys.unraisablehook = _raise_again(before, forgotten)
    try:
        return call()
    finally:
        sys.unraisablehook = forgotten
        for number, handler in before.items():
            signal.signal(number, handler)


def _raise_again(handlers: dict[int, Handler], otherwise: Callable[[Any], object]) -> Callable[[Any], object]:
    def hook(told: Any) -> None:
        number = getattr(told.exc_value, "number", signal.SIGINT)
        if not isinstance(told.exc_value, KeyboardInterrupt) or number not in handlers:
            otherwise(told)
            return
        sys.setprofile(_Later(handlers[number], number, sys._getframe()).step)

    return hook


def _put_off(handler: Handler) -> Handler:
    def handle(number: int, frame: FrameType | None) -> None:
        outermost = _outermost_import(frame)
        if outermost is None:
            handler(number, frame)
        else:
            sys.setprofile(_Later(handler, number, outermost).step)

    return handle


class _Later:
    """A deferred signal: `step` is the main thread's profile function until the signal can be handled."""

    def __init__(self, handler: Handler, number: int, outermost: FrameType) -> None:
        self._handler, self._number = handler, number
        self._import: FrameType | None = outermost
        self._patience_ends = time.monotonic() + PATIENCE_S
        self._before = sys.getprofile()

    def step(self, frame: FrameType, event: str, argument: object) -> None:
        if frame is self._import and event == "return":
            self._import = None  # the next step is the first that may be outside
            return
        if frame.f_code.co_filename == _HERE:  # the end of this handling, inside what was interrupted
            return
        if self._import is None:
            self._import = _outermost_import(frame)
        late = self._import is not None and time.monotonic() >= self._patience_ends
        if self._import is None or (late and not _is_machinery(frame)):
            sys.setprofile(self._before)
            self._handler(self._number, frame)


def _outermost_import(frame: FrameType | None) -> FrameType | None:
    """Return the frame of the outermost import around this one, within the call of `signals_outside_imports`."""
    found = None
    while frame is not None and frame.f_code is not signals_outside_imports.__code__:
        if _is_machinery(frame) or frame.f_globals.get("__name__") in _FINISHED_FIRST:
            found = frame
        frame = frame.f_back
    return found


def _is_machinery(frame: FrameType) -> bool:
    return frame.f_code.co_filename.startswith(_MACHINERY)


_HERE = _is_machinery.__code__.co_filename
