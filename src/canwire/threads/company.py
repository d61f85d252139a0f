"""Threads of one program that share a hub's time: the interface for the handles of the hub."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from canwire.threads.keeper import NEVER, ByTheClock
from canwire.threads.member import MEMBERS, current
from canwire.threads.turns import Turns

Request = TypeVar("Request")
Answer = TypeVar("Answer")


class Company(Turns):
    """The threads of a program: one of them runs at a time, and time passes while all of them wait."""

    @property
    def gone(self) -> bool:
        """True once the hub or the lab has ended."""
        return isinstance(self.keeper, ByTheClock)

    def waited(self, ready: Callable[[], bool], timeout: float | None) -> bool | None:
        """Wait in the calling thread for something of the hub; None if the thread does not take part (any more)."""
        if timeout is not None and timeout <= 0:
            return ready() or self._polled(ready)
        return self.waited_until(ready, self.end_ns(timeout))

    def waited_until(self, ready: Callable[[], bool], until_ns: int) -> bool | None:
        """Wait like `waited`, until `until_ns` of the hub's time."""
        me = current()
        if me is None or me.company is not self:
            return None
        if ready():
            return True
        if until_ns <= self.now_ns():
            return False
        answer = self.wait(me, lambda: self.gone or ready(), min(until_ns, NEVER), "something on its bus")
        return None if self.gone else answer  # whose own way of waiting says that the hub is gone

    def waited_once(self, timeout: float | None) -> bool:
        """Wait until this program gets a signal or another thread has run; False if the thread does not take part."""
        looks = itertools.chain((False, False), itertools.repeat(True))  # it looks twice before time passes
        return self.waited(lambda: next(looks), timeout) is not None

    def told_ns(self) -> int | None:
        """Return the hub's time in ns; None if the thread does not take part."""
        me = current()
        return None if me is None or me.company is not self else self.asks(me)

    def outside(self, call: Callable[[Request], Answer], request: Request) -> Answer:
        """Make a call that waits in real time, and may let the hub's time pass."""
        me = MEMBERS.get(threading.get_ident())
        if me is None:
            return call(request)
        me.outside += 1
        try:
            return call(request)
        finally:
            me.outside -= 1
            self._now_ns = None

    @contextmanager
    def away(self) -> Iterator[None]:
        """A context in which other threads run while this one waits for something outside the hub."""
        me = current()
        if me is None or me.company is not self:
            yield
            return
        self.go_outside(me)
        try:
            yield
        finally:
            self.come_back(me)

    def last_words(self) -> None:
        """At the end of the main thread: wait for the other threads like the interpreter, but in turns."""
        me = current()
        if me is not None and me.company is self:
            self.wait(me, self._only_daemons, NEVER, "the program's other threads to end")

    def _polled(self, ready: Callable[[], bool]) -> bool:
        me = current()
        return me is not None and me.company is self and self.polls(me, ready)

    def _only_daemons(self) -> bool:
        return all(one.thread.daemon for one in self.members if one is not self.founder)
