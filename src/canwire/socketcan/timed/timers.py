"""Timers that programs read as descriptors (timerfd), in the hub's time: each is an eventfd that is counted up here."""

from __future__ import annotations

import errno
import os
import select
from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire.socketcan.loop import Timer

MOST = 1024  # of one program: as many as it has descriptors for
_LAST_SIGNAL = 64


class TimerSignal(NamedTuple):
    """The signal of a timer of timer_create: number 0 is none, thread 0 is any thread that the system chooses."""

    number: int = 0
    value: int = 0
    thread: int = 0


NO_SIGNAL = TimerSignal()


class Keeps(Protocol):
    """The owner of the time: TimedWaiter of turns.py."""

    now_ns: int

    def call_at_ns(self, due_ns: int, call: Callable[[], object]) -> Timer: ...
    def stir(self) -> None: ...
    def interrupt(self, process: int, signal: TimerSignal, timer: int) -> None: ...


class _TimerDescriptor:
    """One of `process`; this end of the eventfd does not keep who writes."""

    def __init__(self, process: int, nonblocking: bool, signal: TimerSignal) -> None:
        self.process = process
        self.signal = signal
        self.descriptor = os.eventfd(0, os.EFD_CLOEXEC | (os.EFD_NONBLOCK if nonblocking else 0))
        self.timer: Timer | None = None
        self.due_ns = self.then_ns = 0


class TimerDescriptors:
    """All timers, by a number from 1 up."""

    def __init__(self, time: Keeps) -> None:
        self._time = time
        self._made: dict[int, _TimerDescriptor] = {}
        self._last = 0

    def open(self, process: int, nonblocking: bool, signal: TimerSignal = NO_SIGNAL) -> tuple[int, int]:
        """Number and descriptor of a new timer, not armed; raises OSError for an invalid signal.

        A timer with a `signal` sends it to the program and counts nothing (timer_create).
        """
        if not 0 <= signal.number <= _LAST_SIGNAL or signal.thread < 0:
            raise OSError(errno.EINVAL, "no signal, or no thread")
        own = [number for number, one in self._made.items() if one.process == process]
        if len(own) >= MOST:  # the oldest ones were closed: nobody has so many descriptors
            self._close(own[0])
        self._last += 1
        made = self._made[self._last] = _TimerDescriptor(process, nonblocking, signal)
        return self._last, made.descriptor

    def set(self, number: int, times_ns: tuple[int, ...] | None) -> tuple[int, int]:
        """Set the first time and the interval (0: never); None: change nothing. Returns the previous rest and interval.

        Raises OSError for an unknown timer.
        """
        one = self._made.get(number)
        if one is None:
            raise OSError(errno.EBADF, "no timer")
        left_ns = 0 if one.timer is None else max(1, one.due_ns - self._time.now_ns)
        before = left_ns, one.then_ns
        if times_ns is not None:
            first_ns, one.then_ns = times_ns
            if one.timer is not None:
                one.timer.cancel()
                one.timer = None
            _drain(one.descriptor)
            if first_ns > 0:
                self._arm(number, one, self._time.now_ns + first_ns)
        return before

    def forget(self, process: int) -> None:
        """Remove the timers of a process that has ended."""
        for number in [number for number, one in self._made.items() if one.process == process]:
            self._close(number)

    def close(self) -> None:
        for number in list(self._made):
            self._close(number)

    def _arm(self, number: int, one: _TimerDescriptor, due_ns: int) -> None:
        one.due_ns = due_ns
        one.timer = self._time.call_at_ns(due_ns, lambda: self._goes_off(number, one))

    def _goes_off(self, number: int, one: _TimerDescriptor) -> None:
        one.timer = None
        if one.then_ns > 0:
            self._arm(number, one, one.due_ns + one.then_ns)
        if one.signal.number:
            self._time.interrupt(one.process, one.signal, number)
        else:
            os.eventfd_write(one.descriptor, 1)
            self._time.stir()

    def _close(self, number: int) -> None:
        one = self._made.pop(number)
        if one.timer is not None:
            one.timer.cancel()
        os.close(one.descriptor)


def _drain(descriptor: int) -> None:
    """Discard the count so far."""
    ready = select.poll()
    ready.register(descriptor, select.POLLIN)
    if ready.poll(0):
        os.eventfd_read(descriptor)
