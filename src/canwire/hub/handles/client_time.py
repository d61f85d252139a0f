"""A hub's time, as a program sees it: what time it is, and waiting until it has passed."""

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
    """The part of a Client that waits. `company`: its threads that keep this time together (canwire.in_time)."""

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
        """How it passes: "real" with the clock, "fast" as quickly as buses work, "virtual" while somebody waits,
        "lockstep" while all programs wait that take part."""
        return self._link.time

    @property
    def virtual(self) -> bool:
        """Waiting here takes virtual time."""
        return self._timed is not None or self._link.time == "virtual"

    @property
    def timed(self) -> bool:
        """This program keeps one time with others."""
        return self._timed is not None

    def keep_time(self, name: str, company: Company | None = None) -> None:
        """Take part in a lockstep hub's time, in the place of this name; waits for this thread's first turn.

        `company`: threads of this program that take turns, the calling one among them, and have one place together.
        Raises WrongState for a hub whose time passes otherwise.
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
        """Seconds on the clock that waiting goes by: the hub's where its time is virtual, else this computer's."""
        return self.now_ns() / 1e9 if self.virtual else time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Do nothing for so many seconds of the hub's time; where that is not virtual, of the clock."""
        if self._timed is not None and self.company is None:
            self._timed.sleep(seconds)
        elif self.virtual:
            self.run_for(seconds)
        else:
            time.sleep(nanoseconds("seconds", seconds) / 1e9)

    @contextlib.contextmanager
    def away(self) -> Iterator[None]:
        """For what takes time that is not the hub's: joining a thread, a file, a user. Its time passes meanwhile.

        A program that keeps one time with others takes part in it again afterwards, at its turn.
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
        """`asyncio.run(main)` in the hub's time where that is virtual: asyncio.sleep, timeouts and loop.time() too.

        Tasks wait for events and buses by their `fileno()` (loop.add_reader, python-can's Notifier with a loop).
        """
        import asyncio

        if not self.virtual:
            return asyncio.run(main)
        from canwire.hub.handles.event_loop import run

        return run(self, main)

    def time_state(self) -> m.TimeState:
        """The time, the programs that take part in it, and why it does not pass if it stopped for long."""
        state: m.TimeState = self.call(m.GetTime())
        return state

    def set_pace(self, factor: float | None) -> None:
        """A hub in lockstep or virtual time: from now on it passes `factor` times as quickly as the wall clock.

        0.0001 to 10000; 1 is the clock's own speed; None: as quickly as it can. Time still waits for programs that
        compute, and what they take too long for is left out. `time_state().pace` says what it is. Raises BadValue,
        WrongState for a hub whose time passes otherwise.
        """
        self.call(m.SetPace(pace(factor)))

    def run_for(self, seconds: float) -> None:
        """Virtual time: let so much of it pass."""
        self.advance(lambda: False, seconds)

    def advance(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Virtual time: let it pass until `ready()` or until `timeout` seconds of it are over; was it ready?"""
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
        """One time with others: until anything is signalled to this program, at most `timeout` seconds of it."""
        if self.company is not None and self.company.waited_once(timeout):
            return
        if self._timed is not None:
            self._timed.wait_once(timeout)

    def stir(self) -> None:
        """Have this program's own threads look again at what they wait for; from anywhere, signal handlers too."""
        if self._timed is not None:
            self._timed.stir()

    def stir_everybody(self) -> None:
        """Something changed, without the hub, that other programs may wait for."""
        if self._timed is not None:
            self._timed.stir_everybody()

    def keeper(self) -> Keeper | None:
        """For canwire.in_time: what lets time pass here, None where the clock does.

        Raises WrongState where the program's threads cannot keep the time together.
        """
        if self.time == "real":
            return None
        if not self.virtual:
            raise WrongState(
                f"threads cannot keep the time of a hub in {self.time} time: virtual, or connect(timed=True)"
            )
        from canwire.hub.handles.keeper import HubKeeper, LockstepKeeper

        return HubKeeper(self) if self._timed is None else LockstepKeeper(self, self._timed)
