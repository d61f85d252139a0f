"""A thread that takes part in its program's turns."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from typing import Protocol

from canwire.threads.originals import allocate_lock


class Company(Protocol):
    """The interface of Turns (turns.py) for a thread."""

    def end_ns(self, seconds: float | None) -> int: ...
    def asks(self, me: Member) -> int: ...
    def polls(self, me: Member, ready: Callable[[], bool]) -> bool: ...
    def enrolled(self, thread: threading.Thread) -> Member: ...
    def withdraw(self, me: Member) -> None: ...
    def begin(self, me: Member) -> None: ...
    def end(self, me: Member) -> None: ...
    def wait(
        self,
        me: Member,
        ready: Callable[[], bool],
        until_ns: int,
        what: str,
        descriptors: tuple[int, ...] = (),
    ) -> bool | None: ...


class Member:
    """A thread and its wait: until `ready` returns true, or until `until_ns` in the hub's time.

    `answer` is the result of its wait, `error` the error that it raises. `outside` counts calls that wait in real
    time: while it is not 0, the thread keeps its turn during any wait. `asked` counts queries since its last wait:
    queries of the time, and polls without a result.
    """

    __slots__ = (
        "answer", "asked", "bell", "company", "descriptors", "ended", "error", "number", "outside", "ready", "thread",
        "until_ns", "what",
    )  # fmt: skip

    def __init__(self, company: Company, thread: threading.Thread, number: int) -> None:
        self.company = company
        self.thread = thread
        self.number = number
        self.bell = allocate_lock()
        self.bell.acquire()
        self.ready: Callable[[], bool] | None = None
        self.until_ns = 0
        self.what = "its first turn"
        self.descriptors: tuple[int, ...] = ()
        self.answer = False
        self.error: BaseException | None = None
        self.outside = 0
        self.asked = 0
        self.ended = False

    def __repr__(self) -> str:
        return f"<thread {self.thread.name!r}, number {self.number}, waits for {self.what}>"


def never() -> bool:
    """Return False: `ready` of a thread that only waits for time."""
    return False


MEMBERS: dict[int, Member] = {}
"""Every thread that takes part, by its ident."""


def current() -> Member | None:
    """Return the calling thread's member if the thread waits in the hub's time; else None."""
    member = MEMBERS.get(threading.get_ident())
    return None if member is None or member.outside else member


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=MEMBERS.clear)  # the other threads are the parent's
