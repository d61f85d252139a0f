"""Threads that a participating thread starts take part too; joining them is a wait in the hub's time."""

from __future__ import annotations

import threading
from collections.abc import Callable

from canwire.threads import originals
from canwire.threads.member import Member, current

_OWN = (
    "canwire.hub.",
    "canwire.drivers.",
    "canwire.pacing",
)  # threads of a hub's links and engines are no part of the program
_MEMBER = "_canwire_member"


def start(thread: threading.Thread) -> None:
    """Replaces Thread.start: the first turn of the new thread comes when this one waits."""
    me = current()
    module = getattr(getattr(thread, "_target", None), "__module__", None) or ""
    if me is None:
        originals.start(thread)
        return
    company = me.company
    if module.startswith(_OWN):
        _start_outside(me, thread)
        return
    member = company.enrolled(thread)
    thread.__dict__[_MEMBER] = member
    thread.__dict__["run"] = _taking_part(thread, member, thread.run)
    try:
        _start_outside(me, thread)
    except BaseException:
        company.withdraw(member)
        raise


def _start_outside(me: Member, thread: threading.Thread) -> None:
    """Keep the turn until the new thread has begun, which runs without a turn up to then."""
    me.outside += 1
    try:
        originals.start(thread)
    finally:
        me.outside -= 1


def join(thread: threading.Thread, timeout: float | None = None) -> None:
    """Replaces Thread.join."""
    me, other = current(), _member_of(thread)
    if me is None or other is None or other is me or other.company is not me.company:
        originals.join(thread, timeout)
        return
    until_ns = me.company.end_ns(None if timeout is None else max(timeout, 0))
    what = f"thread {thread.name!r} to end"
    answer = other.ended or me.company.wait(me, lambda: other.ended, until_ns, what)
    if answer is None:
        originals.join(thread, timeout)
    elif answer:
        originals.join(thread)


def is_alive(thread: threading.Thread) -> bool:
    """Replaces Thread.is_alive: a thread that had its last turn is not alive."""
    member = _member_of(thread)
    if member is not None and member.ended and current() is not None:
        originals.join(thread)
    return originals.is_alive(thread)


def _taking_part(thread: threading.Thread, member: Member, run: Callable[[], None]) -> Callable[[], None]:
    def run_in_turns() -> None:
        del thread.__dict__["run"]
        member.company.begin(member)
        try:
            run()
        except BaseException:
            thread._invoke_excepthook(thread)  # type: ignore[attr-defined]  # while it is still its turn
        finally:
            member.company.end(member)

    return run_in_turns


def _member_of(thread: threading.Thread) -> Member | None:
    return thread.__dict__.get(_MEMBER)
