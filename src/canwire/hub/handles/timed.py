"""A program's threads in lockstep: each waits for its turn, and knows the time during its turn.

The hub identifies a thread by the word of its process and its number, on whichever connection it calls; so all
connections of a process to one hub share this state.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import sys
import threading
import uuid
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from canwire.errors import CanwireError
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.turn_wait import TurnWait
from canwire.platform import EventDescriptor
from canwire.values.checks import nanoseconds

if TYPE_CHECKING:
    from canwire.threads.company import Company

_NEVER = (1 << 63) - 1


class Connection(Protocol):
    """The part of a client of the hub that lockstep uses."""

    doorbell: EventDescriptor

    company: Company | None

    @property
    def lost(self) -> bool: ...
    def ask(self, request: m.Message) -> tuple[Any, tuple[int, ...]]: ...
    def call(self, request: m.Message) -> Any: ...


class _Seat:
    """A thread's state at one hub: the time of its last turn, None: unknown; and the `page` by which it waits."""

    def __init__(self) -> None:
        self.now_ns: int | None = None
        self.page: TurnWait | None = None


class Place:
    """A thread's number in its process, and its seats by hub. Hubs do not wait for a thread that has ended."""

    def __init__(self) -> None:
        self._number = -1
        self.seats: dict[str, _Seat] = {}
        self.leaving = _Leaving()

    @property
    def number(self) -> int:
        """The thread's number, assigned on first use: threads that never take part have none."""
        if self._number < 0:
            self._number = self.leaving.number = next(_NUMBERS)
        return self._number


class _Thread(threading.local):
    """The Place of each thread."""

    def __init__(self) -> None:
        self.place = Place()


class _Leaving:
    """Goes with its thread."""

    def __init__(self) -> None:
        self.number = -1
        self.clients: dict[str, Connection] = {}

    def __del__(self) -> None:
        if sys.is_finalizing():
            return  # the connection ends with the process
        for client in self.clients.values():
            if not client.lost:
                with contextlib.suppress(CanwireError):
                    client.call(m.LeaveTime(self.number))


class Timed:
    """A connection whose program takes part. The constructor waits for the first turn of the calling thread."""

    def __init__(
        self, client: Connection, name: str, stir: Callable[[], object], place: Place | None = None
    ) -> None:
        self._client = client
        self._stir_hub = stir
        self._name = name
        self._page: TurnWait | None = None
        self._hub = ""
        self._shared = place  # of threads that take turns among themselves
        self._hub = self._joined(place or _THREAD.place)

    def share(self) -> Place:
        """Make the calling thread's place that of all threads that take turns with it."""
        self._shared = _THREAD.place
        return self._shared

    def now_ns(self) -> int:
        """The hub's time; known without a call during this thread's turn."""
        seat = self._place().seats.get(self._hub)
        if seat is None:
            return self._asked_ns()
        if seat.now_ns is None:
            seat.now_ns = self._asked_ns()
        return seat.now_ns

    def forget_now(self) -> None:
        """Forget the time: a call of this thread may have taken time."""
        seat = self._place().seats.get(self._hub)
        if seat is not None:
            seat.now_ns = None

    def sleep(self, seconds: float) -> None:
        """Let other programs run for this long; also for 0 seconds."""
        until_ns = self.now_ns() + nanoseconds("seconds", seconds)
        while self._await_turn(until_ns) < until_ns:
            pass

    def advance(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Client.advance in lockstep time."""
        if ready():
            return True
        if timeout == 0:
            return False
        now_ns = self.now_ns()
        end_ns = _NEVER if timeout is None else now_ns + nanoseconds("timeout", timeout)
        while now_ns < end_ns:
            now_ns = self._await_turn(end_ns)
            if ready():
                return True
        return False

    def await_turn(self, until_ns: int) -> int:
        """Let other programs run until then, or until a signal to this program; returns the new time."""
        return self._await_turn(until_ns)

    def wait_once(self, timeout: float | None) -> None:
        """Wait until this program gets a signal, at most that many seconds; threads that wait then check again."""
        end_ns = _NEVER if timeout is None else self.now_ns() + nanoseconds("timeout", timeout)
        self._await_turn(end_ns)

    def stir_everybody(self) -> None:
        """Make all programs check again: something has changed that the hub does not know of."""
        self._client.call(m.Stir())

    def stir(self) -> None:
        """Make this program's threads check again, without a lock and without waiting."""
        if self._page is not None:
            self._page.stir()
        self._stir_hub()

    def lost(self) -> None:
        """The connection has ended: show that to threads that wait by its page."""
        if self._page is not None:
            self._page.end()

    def leave(self) -> None:
        """Leave lockstep: time does not wait for this thread until `join`."""
        self._client.call(m.LeaveTime(self._place().number))

    def join(self) -> None:
        """Take part again: this thread continues at its turn, and time waits for it."""
        self._joined(self._place())

    def _joined(self, place: Place) -> str:
        answer = self._client.ask(m.JoinTime(_word(), place.number, self._name))
        joined: m.Joined = answer[0]
        seat = self._seat(place, joined.hub)
        seat.now_ns = joined.now_ns
        if answer[1]:
            self._page = seat.page = TurnWait(self._client.doorbell.signal, *answer[1])
        return joined.hub

    def _place(self) -> Place:
        if self._shared is not None and self._client.company is not None:
            return self._shared
        return _THREAD.place

    def _seat(self, place: Place, hub: str) -> _Seat:
        seat = place.seats.get(hub)
        if seat is None:
            seat = place.seats[hub] = _Seat()
            if threading.current_thread() is not threading.main_thread():
                place.leaving.clients[hub] = self._client
        return seat

    def _await_turn(self, until_ns: int) -> int:
        place = self._place()
        seat = place.seats.get(self._hub) or self._seat(place, self._hub)
        seat.now_ns = None  # in case the thread is interrupted meanwhile
        page = seat.page
        until_ns = min(until_ns, _NEVER)
        now_ns = None if page is None else page.wait(until_ns)
        if now_ns is None:
            now_ns = int(self._client.ask(m.AwaitTurn(place.number, until_ns))[0].value)
        seat.now_ns = now_ns
        return now_ns

    def _asked_ns(self) -> int:
        return int(self._client.call(m.Advance(0)).value)


def _word() -> str:
    """The word of this process; a fork has another one."""
    return f"{os.getpid()}-{_WORD}"


_WORD = uuid.uuid4().hex
_NUMBERS = itertools.count()
_THREAD = _Thread()


def _after_fork() -> None:
    """In a fork: discard the thread's state, including pages, since it belongs to the parent."""
    _THREAD.place.seats.clear()
    _THREAD.place.leaving.clients.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
