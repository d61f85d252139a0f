"""A hub's time in a program: reading it, and waiting for it."""

from __future__ import annotations

import contextlib
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

from canwire.errors import WrongState
from canwire.hub.protocol import messages as m
from canwire.values.checks import LONGEST_NS, instance, nanoseconds, pace

if TYPE_CHECKING:
    from canwire.hub.handles.timed import Timed
    from canwire.hub.protocol.link import Answer, Link
    from canwire.threads.company import Company
    from canwire.threads.keeper import Keeper

Result = TypeVar("Result")


class ClientTime(ABC):
    """The part of a Client that waits. `company`: the program's threads that share this time (canwire.in_time)."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self.doorbell = link.doorbell
        self._timed: Timed | None = None
        self.company: Company | None = None

    @property
    @abstractmethod
    def lost(self) -> bool:
        """Client.lost."""

    @abstractmethod
    def ask(self, request: m.Message) -> Answer:
        """Client.ask."""

    @abstractmethod
    def call(self, request: m.Message) -> Any:
        """Client.call."""

    @property
    def time(self) -> str:
        """How time passes: "real" with the clock, "fast" as fast as the buses are simulated, "virtual" only while a
        program waits, "lockstep" only while all programs that take part wait."""
        return self._link.time

    @property
    def virtual(self) -> bool:
        """True if waiting takes virtual time."""
        return self._timed is not None or self._link.time == "virtual"

    @property
    def timed(self) -> bool:
        """True if this program takes part in lockstep time."""
        return self._timed is not None

    def keep_time(self, name: str, company: Company | None = None) -> None:
        """Take part in a lockstep hub's time, in the place of this name; waits for this thread's first turn.

        `company`: threads of this program that take turns and share one place, including the calling one.
        Raises WrongState if the hub is not in lockstep time.
        """
        from canwire.hub.handles.keeper import LockstepKeeper
        from canwire.hub.handles.timed import Timed
        from canwire.threads.company import Company

        instance("company", company, Company, type(None))
        keeper = None if company is None else company.keeper
        if not isinstance(keeper, LockstepKeeper):
            self._timed = Timed(self, name, self._link.stir)
            return
        self._timed = Timed(self, name, self._link.stir, keeper.place)
        keeper.add(self, self._timed)
        self.company = company

    def now_ns(self) -> int:
        """The hub's time."""
        if self.company is not None and (told_ns := self.company.told_ns()) is not None:
            return told_ns
        if self._timed is not None:
            return self._timed.now_ns()
        return int(self.call(m.Advance(0)).value)

    def clock_s(self) -> float:
        """Seconds on the clock that waits use: the hub's if its time is virtual, else this computer's."""
        # not by `virtual`: python-can's plugin asks at each message
        if self._timed is None and self._link.time != "virtual":
            return time.monotonic()
        return self.now_ns() / 1e9

    def sleep(self, seconds: float) -> None:
        """Do nothing for this many seconds of the hub's time; if that is not virtual, of the computer's clock."""
        if self._timed is not None and self.company is None:
            self._timed.sleep(seconds)
        elif self.virtual:
            self.run_for(seconds)
        else:
            time.sleep(nanoseconds("seconds", seconds) / 1e9)

    @contextlib.contextmanager
    def away(self) -> Iterator[None]:
        """A context for waits outside the hub: for a thread, a file or a user. The hub's time passes meanwhile.

        A program in lockstep takes part again afterwards, at its turn.
        """
        if self.company is not None:
            with self.company.away():
                yield
            return
        if self._timed is None:
            yield
            return
        self._timed.leave()
        try:
            yield
        finally:
            self._timed.join()

    def run(self, main: Coroutine[Any, Any, Result]) -> Result:
        """Like `asyncio.run(main)`; if the hub's time is virtual, asyncio.sleep, timeouts and loop.time() use it.

        Tasks can wait for events and buses by their `fileno()` (loop.add_reader, python-can's Notifier with a loop).
        """
        import asyncio

        if not self.virtual:
            return asyncio.run(main)
        from canwire.hub.handles.event_loop import run

        return run(self, main)

    def time_state(self) -> m.TimeState:
        """The time, the programs that take part in it, and the reason if it has not passed for long."""
        state: m.TimeState = self.call(m.GetTime())
        return state

    def set_pace(self, factor: float | None) -> None:
        """Let the time of a hub in lockstep or virtual time pass `factor` times as fast as the computer's clock.

        `factor` is 0.0001 to 10000; 1 is the speed of the clock; None: as fast as possible. Time still waits for
        programs that compute; if they take too long, it does not catch up. `time_state().pace` is the factor. Raises
        BadValue, and WrongState for a hub in real or fast time.
        """
        self.call(m.SetPace(pace(factor)))

    def run_for(self, seconds: float) -> None:
        """Let this many seconds of virtual time pass."""
        self.advance(lambda: False, seconds)

    def advance(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Let virtual time pass until `ready()`, for at most `timeout` seconds of it; True if it was ready."""
        if timeout is not None:
            timeout = nanoseconds("timeout", timeout) / 1e9
        if self.company is not None and (answer := self.company.waited(ready, timeout)) is not None:
            return answer
        if self._timed is not None:
            return self._timed.advance(ready, timeout)
        now_ns = self.now_ns()
        end_ns = now_ns + (LONGEST_NS if timeout is None else nanoseconds("timeout", timeout))
        while not ready() and now_ns < end_ns:
            now_ns = int(self.call(m.Advance(end_ns - now_ns)).value)
        return ready()

    def wait_once(self, timeout: float | None) -> None:
        """In lockstep, wait for any signal to this program, for at most `timeout` seconds of that time."""
        if self.company is not None and self.company.waited_once(timeout):
            return
        if self._timed is not None:
            self._timed.wait_once(timeout)

    def stir(self) -> None:
        """Make the program's threads check again what they wait for. Call it anywhere, even in signal handlers."""
        if self._timed is not None:
            self._timed.stir()

    def stir_everybody(self) -> None:
        """Make all programs check again: something that they may wait for has changed outside the hub."""
        if self._timed is not None:
            self._timed.stir_everybody()

    def keeper(self) -> Keeper | None:
        """For canwire.in_time: the object that lets time pass, None in real time.

        Raises WrongState if the program's threads cannot share the hub's time.
        """
        if self.time == "real":
            return None
        if not self.virtual:
            raise WrongState(
                f"threads cannot keep the time of a hub in {self.time} time; use virtual time, or connect(timed=True)"
            )
        from canwire.hub.handles.keeper import HubKeeper, LockstepKeeper

        return HubKeeper(self) if self._timed is None else LockstepKeeper(self, self._timed)
