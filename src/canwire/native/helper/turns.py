"""The threads of a program in their hub's time, if CANWIRE_TIMED is 1: for each, a thread here takes part in turns.

While a thread of the program runs, the thread that answers it keeps its turn, so that no time passes; the program
waits by a wait here. ../core/timed.c is the other end: it checks its condition again at each turn.
"""

from __future__ import annotations

import itertools
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import canwire
from canwire import CanwireError
from canwire.native.helper.answers import Reply

if TYPE_CHECKING:
    from canwire import Hub

_ASKED = struct.Struct(
    "<qI4x"
)  # until when, or of what number; whether the thread changed what others may wait for
_NS = struct.Struct("<q")
_NEVER = (1 << 63) - 1
_NO_PART = Reply(1)


class Turns:
    """Answers the methods "time." (answers.Answers). Times are those of the hub, in nanoseconds."""

    def __init__(self) -> None:
        self._hub: Hub | None = None
        self._connecting = threading.Lock()
        self._own = threading.local()
        self._expected: dict[int, Any] = {}  # members that began before their threads
        self._numbers = itertools.count(1)
        self._changes = 0

    @contextmanager
    def thread(self) -> Iterator[None]:
        """A context in which the calling thread answers one thread of the program, until that ends."""
        try:
            yield
        finally:
            member = getattr(self._own, "member", None)
            if member is not None:
                self._changes += 1  # threads that wait for its end check again
                member.company.end(member)

    def take_part(self, number: int = 0) -> None:
        """Take part from the next turn on; `number` is from `expect`. No effect if it takes part already, or cannot."""
        if hasattr(self._own, "member"):
            return
        company = self._company()
        if company is None or hasattr(self._own, "member"):
            return
        member = self._expected.pop(number, None) or company.enrolled(threading.current_thread())
        self._own.member = member
        company.begin(member)

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        """Answer a call; raises KeyError for an unknown method."""
        call = _METHODS[method]
        try:
            self.take_part(number if method == "begin" else 0)
            if self._hub is None or not hasattr(self._own, "member"):
                return _NO_PART
            about, changed = _ASKED.unpack(data)
            self._changes += changed
            return call(self, self._hub, about)
        except CanwireError:  # the hub is gone: the program waits by the clock
            return _NO_PART

    def now(self, hub: Hub, _: int) -> Reply:
        return Reply(data=_NS.pack(hub.now_ns()))

    def wait(self, hub: Hub, until_ns: int) -> Reply:
        """Wait until this time, until a signal for this program, or until another thread has changed something."""
        before, looks = self._changes, itertools.count()

        def ready() -> bool:
            return self._changes != before or next(looks) > 1  # it looks twice before time passes

        hub.advance(ready, _span_s(hub, until_ns))
        return self.now(hub, 0)

    def sleep(self, hub: Hub, until_ns: int) -> Reply:
        """Wait until this time; signals do not end the wait."""
        hub.advance(_never, _span_s(hub, until_ns))
        return self.now(hub, 0)

    def expect(self, hub: Hub, _: int) -> Reply:
        """Let a thread that is about to begin take part from now on. Replies with a number for it."""
        number = next(self._numbers)
        self._expected[number] = self._own.member.company.enrolled(threading.current_thread())
        return Reply(value=number, data=_NS.pack(hub.now_ns()))

    def forget(self, hub: Hub, number: int) -> Reply:
        """Remove the thread with this number, which did not begin."""
        member = self._expected.pop(number, None)
        if member is not None:
            member.company.withdraw(member)
        return self.now(hub, 0)

    def _company(self) -> Any:
        """Return the company of all threads here, from the first connection; None if the hub's time is not followed."""
        with self._connecting:
            if self._hub is None:
                try:
                    self._hub = canwire.connect()
                except CanwireError:
                    return None  # the interface that is asked says what is wrong
                if self._hub.company is not None:
                    self._own.member = self._hub.company.founder
            return self._hub.company


def _span_s(hub: Hub, until_ns: int) -> float | None:
    return None if until_ns >= _NEVER else max(0, until_ns - hub.now_ns()) / 1e9


def _never() -> bool:
    return False


_METHODS: dict[str, Callable[[Turns, Hub, int], Reply]] = {
    "now": Turns.now,
    "begin": Turns.now,
    "wait": Turns.wait,
    "sleep": Turns.sleep,
    "expect": Turns.expect,
    "forget": Turns.forget,
}
