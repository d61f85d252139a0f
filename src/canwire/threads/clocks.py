"""Replaces the clocks and `sleep` of the module time: threads that take part use the hub's time."""

from __future__ import annotations

from canwire.threads import originals
from canwire.threads.member import current, never


def sleep(seconds: float, /) -> None:
    me = current()
    if me is None:
        originals.sleep(seconds)
        return
    if seconds < 0:
        raise ValueError("sleep length must be non-negative")
    asked = me.asked
    until_ns = me.company.end_ns(float(seconds))
    if me.company.wait(me, never, until_ns, f"time.sleep({seconds:g})") is None:
        originals.sleep(seconds)
    elif seconds == 0:  # others have had their turns, but it still polls
        me.asked = asked
        me.company.polls(me, never)


def monotonic_ns() -> int:
    me = current()
    return originals.monotonic_ns() if me is None else me.company.asks(me)


def monotonic() -> float:
    me = current()
    return originals.monotonic() if me is None else me.company.asks(me) / 1e9


def perf_counter_ns() -> int:
    me = current()
    return originals.perf_counter_ns() if me is None else me.company.asks(me)


def perf_counter() -> float:
    me = current()
    return originals.perf_counter() if me is None else me.company.asks(me) / 1e9


def time_ns() -> int:
    me = current()
    return originals.time_ns() if me is None else me.company.asks(me)


def time_s() -> float:
    me = current()
    return originals.time_s() if me is None else me.company.asks(me) / 1e9
