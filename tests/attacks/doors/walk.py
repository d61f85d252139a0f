"""python -m tests.attacks.doors.walk REPORT: calls everything with everything; one line of JSON for each wrong answer.

Right is a return, an error of canwire's, or TypeError or ValueError with a sentence. The call that is about to be made
stands in memory that is the file REPORT.now, so that a signal's cause can be read there.
"""

from __future__ import annotations

import inspect
import json
import mmap
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import IO, Any

import canwire
from canwire.values.mistakes.names import WrongName

from . import subjects
from .subjects import Find
from .values import Bad, bad_values

NOW = 200  # bytes of the call that is being made
PATIENCE_S = 60  # only a call that hangs takes that long
RIGHT: tuple[type[Exception], ...] = (canwire.CanwireError, TypeError, ValueError)
FILES = (OSError,)  # where the system speaks for itself: a parameter that is a path
# between canwire's own rooms, and documented so: nobody else hands anything in there
SEAMS = {
    "adopt",
    "ask",
    "call",
    "forget",
    "end",
    "leave_to_parent",
    "advance",
    "touch",
    "turn",
    "active",
    "begin",
}
WAITS = {"timeout", "within"}
FOREVER = {"None", "2**31", "2**32"}  # as a time to wait: what was asked for


class HangError(BaseException):
    """A call that came back only because it was interrupted."""


def interrupt(_signal: int, _frame: object) -> None:
    raise HangError(f"nothing after {PATIENCE_S} s")


def methods(make: Callable[[ExitStack], Any]) -> list[str]:
    with ExitStack() as stack:
        kind = type(make(stack))
    names = (name for name in dir(kind) if not name.startswith("_") and name not in SEAMS)
    return [
        name for name in names if callable(found := getattr(kind, name)) and not isinstance(found, WrongName)
    ]


def attempts(name: str, function: Callable[..., Any]) -> Iterator[tuple[str, Bad]]:
    for parameter in subjects.parameters_of(name, function):
        for bad in bad_values():
            if not (parameter in WAITS and bad.name in FOREVER):
                yield parameter, bad


class Healthy:
    """A callable of something healthy, which lives until a call has changed it."""

    def __init__(self, find: Find) -> None:
        self._find = find
        self._stack = ExitStack()
        self._function: Callable[..., Any] | None = None

    def function(self) -> Callable[..., Any]:
        if self._function is None:
            self._function = self._find(self._stack)
        return self._function

    def end(self) -> None:
        self._function = None
        stack, self._stack = self._stack, ExitStack()
        stack.close()


class Walk:
    """One walk over all subjects; `wrong` counts what it wrote down."""

    def __init__(self, report: IO[str], now: mmap.mmap) -> None:
        self.report = report
        self.now = now
        self.calls = 0
        self.wrong = 0

    def everything(self) -> None:
        for name in subjects.VALUES:
            self.one(name, lambda _stack, name=name: getattr(canwire, name))
        for thing, make in subjects.THINGS.items():
            for method in methods(make):
                self.one(
                    f"{thing}.{method}", lambda stack, make=make, method=method: getattr(make(stack), method)
                )

    def one(self, name: str, find: Find) -> None:
        """One callable, with each of its parameters wrong in each way."""
        healthy = Healthy(find)
        tries = list(attempts(name, healthy.function()))
        for parameter, bad in tries:
            self.calls += 1
            self.call(name, healthy, parameter, bad)
        healthy.end()

    def call(self, name: str, healthy: Healthy, parameter: str, bad: Bad) -> None:
        what = f"{name}({parameter}={bad.name})"
        self.now[:] = what.encode()[:NOW].ljust(NOW)
        signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)
        wrong = ""
        right = (*RIGHT, *FILES) if parameter == "path" else RIGHT
        try:
            finished(name, healthy, parameter, bad.value)
        except right as error:
            wrong = "" if str(error).strip() else f"{type(error).__name__} without a word"
        except (Exception, HangError) as error:
            wrong = f"{type(error).__name__}: {error}"[:300]
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
        if wrong:
            self.wrong += 1
            self.report.write(json.dumps({"call": what, "wrong": wrong}) + "\n")
            self.report.flush()


def finished(name: str, healthy: Healthy, parameter: str, value: object) -> None:
    """Make the call; what took the value must end well."""
    function = healthy.function()
    result = function(**{**subjects.arguments_of(name, function), parameter: value})
    if inspect.iscoroutine(result):
        result.close()
    healthy.end()


def main() -> None:
    expected = os.environ.get("CANWIRE_EXPECT", canwire.core_mode())
    if canwire.core_mode() != expected:
        sys.exit(f"the core is {canwire.core_mode()}, not {expected}")
    signal.signal(signal.SIGALRM, interrupt)
    with open(sys.argv[1], "w") as report, open(sys.argv[1] + ".now", "wb+") as now:
        now.truncate(NOW)
        with mmap.mmap(now.fileno(), NOW) as memory:
            walk = Walk(report, memory)
            walk.everything()
            memory[:] = bytes(NOW)
    print(f"{walk.calls} calls, {walk.wrong} wrong, {canwire.core_mode()} core")


if __name__ == "__main__":
    main()
