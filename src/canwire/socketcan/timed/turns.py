"""The programs of a `canwire run` in the time of a lockstep hub: the server takes part in it for all of them.

While one of their threads runs, time does not pass, and the server only answers its requests. Once all of them wait,
the server delivers received frames and collects sent ones. Then each thread whose time has come, or that may have
data, checks again, one after the other; when none is left, the server waits for its next turn.
"""

from __future__ import annotations

import os
import select
import signal
import threading
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire.socketcan.loop import READABLE, URGENT, Polled
from canwire.socketcan.timed.children import children_of
from canwire.socketcan.timed.seat import NEVER, Seat
from canwire.socketcan.timed.signals import send_timer_signal, send_timer_signal_to_thread
from canwire.socketcan.timed.timers import TimerDescriptors, TimerSignal

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub
    from canwire.socketcan.loop import Loop, Timer
    from canwire.socketcan.requests.control import Asked, Request
    from canwire.socketcan.table import Table

_AGAIN, _SLEEPS = 1, 2  # of a wait: shim/shim.h


class TimedWaiter:
    """A Waiter in the hub's time; `hub` already takes part in lockstep. The creator of the loop sets `loop`."""

    loop: Loop

    def __init__(self, hub: Hub, table: Table) -> None:
        self._calm = Polled()  # what is served while all of them wait
        self._hub = hub
        self._table = table
        self._urgent = select.epoll()  # what is served while a program runs
        self._urgent_ones: set[int] = set()
        self._seats: dict[tuple[int, int], Seat] = {}
        self._ends: dict[int, int] = {}  # by process: a descriptor that tells its end
        self._timers: dict[int, tuple[Timer, int]] = {}  # by process, with the interval
        self._signalled: dict[int, int] = {}  # the last signal that a process got and has not seen
        self.timers = TimerDescriptors(self)
        self._last: Seat | None = None
        self._round = 0
        self.now_ns = 0
        self._see_time()
        self.ended = False  # the programs have; what they sent is still on its way
        self._either = select.epoll()
        self._either.register(self._urgent, READABLE)
        self._either.register(self._calm, READABLE)
        self._bell = select.epoll()
        self._bell.register(self._urgent, 0)
        self._over = os.eventfd(0)
        self._bell.register(self._over, READABLE)
        self._watcher = threading.Thread(target=self._wake_for_requests, daemon=True)
        self._watcher.start()

    def clock_s(self) -> float:
        return self.now_ns / 1e9

    # descriptors

    def watch(self, descriptor: int, events: int) -> None:
        if events & URGENT:
            self._urgent_ones.add(descriptor)
            self._urgent.register(descriptor, events)
        else:
            self._calm.watch(descriptor, events)

    def change(self, descriptor: int, events: int) -> None:
        self.forget(descriptor)
        self.watch(descriptor, events)

    def forget(self, descriptor: int) -> None:
        if descriptor in self._urgent_ones:
            self._urgent_ones.remove(descriptor)
            self._urgent.unregister(descriptor)
        else:
            self._calm.forget(descriptor)

    def close(self) -> None:
        os.eventfd_write(self._over, 1)
        self._watcher.join()
        os.close(self._over)
        self._urgent.close()
        self.timers.close()
        for descriptor in self._ends.values():
            os.close(descriptor)
        self._calm.close()

    # threads of programs

    def requested(self, request: Request, asked: Asked, *, takes_part: bool) -> None:
        """A thread has sent a request, so it runs. If it has a seat, a later answer is its turn."""
        key = request.process, request.thread
        seat = self._seats.get(key)
        if seat is None and takes_part:
            seat = self._seats[key] = Seat(request.process)
            self._watch_process(request.process)
        if seat is not None:
            seat.give, seat.sleeps, seat.children = None, False, []
            asked.hold = lambda give: self._hold(seat, give)

    def has_seat(self, thread: int) -> bool:
        """True if this thread takes part."""
        return any(number == thread for _, number in self._seats)

    def still_asks(self, request: Request, asked: Asked) -> None:
        """If the request is not answered yet, its thread waits."""
        seat = self._seats.get((request.process, request.thread))
        if seat is not None and not asked.answered:
            seat.give, seat.until_ns, seat.looks = _nothing, NEVER, False

    def waits(self, request: Request, asked: Asked, until_ns: int) -> None:
        """Let this thread wait for its turn."""
        seat = self._seats[request.process, request.thread]
        asked.hold = None
        if not request.a & _AGAIN:
            self.stir()
        seat.until_ns, seat.looks, seat.sleeps = until_ns, False, bool(request.a & _SLEEPS)
        if request.slot:
            self._awaits_children(seat, [request.slot] if request.slot > 0 else children_of(request.process))

        def interrupted() -> None:
            seat.give = None

        seat.give = lambda: asked.answer(self._signalled.pop(request.process, 0))
        asked.when_gone(interrupted)

    def leaves(self, request: Request) -> None:
        """Remove this thread from the turns."""
        self._seats.pop((request.process, request.thread), None)
        self.stir()

    def set_timer(self, process: int, first_ns: int, then_ns: int) -> tuple[int, int]:
        """Send SIGALRM to a process after `first_ns` (0: never), then every `then_ns`; returns the previous setting."""
        before = self._timers.pop(process, None)
        left_ns, interval_ns = 0, 0
        if before is not None:
            before[0].cancel()
            left_ns, interval_ns = max(1, round(before[0].due_s * 1e9) - self.now_ns), before[1]
        if first_ns > 0:
            timer = self.call_at_ns(self.now_ns + first_ns, lambda: self._goes_off(process, then_ns))
            self._timers[process] = timer, then_ns
        return left_ns, interval_ns

    def call_at_ns(self, due_ns: int, call: Callable[[], object]) -> Timer:
        """Call this at a time of the hub."""
        return self.loop.call_at(due_ns / 1e9, call)

    def _goes_off(self, process: int, then_ns: int) -> None:
        del self._timers[process]
        if process not in self._ends:
            return
        if then_ns > 0:
            self.set_timer(process, then_ns, then_ns)
        with suppress(ProcessLookupError):  # it ends
            signal.pidfd_send_signal(self._ends[process], signal.SIGALRM)
        self._interrupted(process, signal.SIGALRM)

    def interrupt(self, process: int, signal: TimerSignal, timer: int) -> None:
        """Send this signal like a timer of the kernel."""
        if process not in self._ends:
            return
        with suppress(ProcessLookupError):
            if signal.thread:
                send_timer_signal_to_thread(process, signal.thread, signal.number, signal.value, timer)
            else:
                send_timer_signal(self._ends[process], signal.number, signal.value, timer)
        self._interrupted(process, signal.number, signal.thread)

    def _interrupted(self, process: int, number: int, thread: int = 0) -> None:
        """Note a signal and give a thread its turn: its handler has run, or it finds the signal that it waits for."""
        self._signalled[process] = number
        seats = [seat for key, seat in self._seats.items() if key[0] == process and thread in (0, key[1])]
        seat = seats[0] if seats else None
        if seat is not None and seat.give not in (None, _nothing):
            self._give(seat)  # it is interrupted already

    def stir(self) -> None:
        """Make all threads check again, except those that sleep, and those whose turn is the answer to a request."""
        for seat in self._seats.values():
            if seat.give is not _nothing and not seat.sleeps:
                seat.looks = True

    def _hold(self, seat: Seat, give: Callable[[], object]) -> None:
        """An answer: immediately while the asker runs, else at its turn."""
        if seat.give is None:
            give()
        else:
            seat.give, seat.looks = give, True

    def _watch_process(self, process: int) -> None:
        if process in self._ends:
            return

        def ended(_: int) -> None:
            self.loop.forget(descriptor)
            os.close(self._ends.pop(process))
            self.timers.forget(process)
            for key in [key for key in self._seats if key[0] == process]:
                del self._seats[key]
            self.stir()

        with suppress(ProcessLookupError):  # it has ended already: nobody has this descriptor
            descriptor = self._ends[process] = os.pidfd_open(process)
            self.loop.watch(descriptor, READABLE | URGENT, ended)

    # waiting

    def wait(self, seconds: float | None) -> list[tuple[int, int]]:
        found = self._urgent.poll(0)
        processes = [key[0] for key in self._seats]
        if any(seat.runs(processes) for seat in self._seats.values()):  # time does not pass
            return found if found or seconds == 0 else self._urgent.poll(None)
        found += self._calm.wait(0)
        if not found and seconds != 0:
            self._go_on(seconds)
        return found

    def _go_on(self, seconds: float | None) -> None:
        """A thread has a turn, the server's is over, or time does not pass because no thread takes part yet."""
        seat = self._next()
        if seat is not None:
            self._give(seat)
        elif self._seats or self.ended:
            self._wait_for_turn(seconds)
        else:
            self._either.poll(None)

    def _awaits_children(self, seat: Seat, children: list[int]) -> None:
        """Let the thread check again when one of these children has ended, which may have happened already."""
        seat.children = children
        for child in children:
            self._watch_process(child)
        seat.looks = not children or not all(child in self._ends for child in children)

    def _next(self) -> Seat | None:
        """The next thread to run, in turns; one that waits for 0 seconds first lets programs elsewhere run."""
        seats = list(self._seats.values())
        begin = seats.index(self._last) + 1 if self._last in seats else 0
        for seat in seats[begin:] + seats[:begin]:
            if seat.looks or (seat.until_ns <= self.now_ns and seat.round != self._round):
                return seat
        return None

    def _give(self, seat: Seat) -> None:
        give, seat.give = seat.give, None
        seat.looks, seat.round = False, self._round
        self._last = seat
        if give is not None:
            give()

    def _wait_for_turn(self, seconds: float | None) -> None:
        until_ns = min((seat.until_ns for seat in self._seats.values()), default=NEVER)
        if seconds is not None:
            until_ns = min(until_ns, self.now_ns + max(1, round(seconds * 1e9)))
        self._bell.modify(self._urgent, READABLE | select.EPOLLONESHOT)
        self._hub.wait_once(None if until_ns >= NEVER else max(0, until_ns - self.now_ns) / 1e9)
        self._round += 1
        self._see_time()

    def _see_time(self) -> None:
        self.now_ns = self._hub.now_ns()
        self._table.set_time(self.now_ns)

    def _wake_for_requests(self) -> None:
        """A program that begins while the server waits for its turn."""
        while all(descriptor != self._over for descriptor, _ in self._bell.poll()):
            self._hub.stir()


def _nothing() -> None:
    """The turn of a thread that waits for an answer."""
