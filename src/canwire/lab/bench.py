"""The bench itself: time, and the buses on it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from types import TracebackType
from typing import TYPE_CHECKING

from canwire.errors import BadValue, Closed, NotIdle
from canwire.lab.bus import LabBus
from canwire.lab.lin import LabLinBus
from canwire.lab.spans import nanoseconds
from canwire.pacing import Pacer
from canwire.timeline import NEVER, Timeline, Timer
from canwire.values.timing.bit_timing import BitTiming

if TYPE_CHECKING:
    import asyncio  # 35 ms that only asyncio's users pay

_SECOND_NS = 1_000_000_000
_STALL_NS = _SECOND_NS
_CHUNK_NS = 100_000_000


class Lab:
    """Any number of buses on one timeline.

    `time` is "virtual" (jumps from one happening to the next, as fast as it can) or "real" (follows the
    wall clock, in a thread of its own). Everything random comes from `seed`: the same script gives the
    same bytes.

    >>> with Lab() as lab:
    ...     bus = lab.can_bus("can0", bit_rate=500_000)
    ...     a, b = bus.node("engine"), bus.node("tester")
    ...     a.send(Frame(0x123, b"\\x11\\x22"))
    ...     lab.run_until_idle()
    ...     b.receive()
    Frame(0x123, bytes.fromhex("1122"), timestamp_ns=124000)
    """

    def __init__(self, *, time: str = "virtual", seed: int = 0) -> None:
        if time not in ("virtual", "real"):
            raise BadValue(f"time {time!r}: 'virtual' or 'real'")
        self.seed = seed
        self.timeline = Timeline()
        self.buses: dict[str, LabBus] = {}
        self.lin_buses: dict[str, LabLinBus] = {}
        self.pacer = Pacer(self.timeline) if time == "real" else None
        self._closed = False
        self._activity: dict[asyncio.Future[None], int] = {}

    def can_bus(
        self,
        name: str = "can0",
        *,
        bit_rate: int = 500_000,
        data_bit_rate: int | None = None,
        timing: BitTiming | None = None,
        data_timing: BitTiming | None = None,
        iso_fd: bool = True,
        length_m: float = 0.0,
        node_delay_ns: float = 0.0,
    ) -> LabBus:
        """A new bus. Rates in bit/s; `data_bit_rate` (or `data_timing`) makes it a CAN FD bus.

        Exact timings win over rates. `length_m` is the cable's length, `node_delay_ns` what an isolated node
        adds in each direction (75 for one 6N137 opto-coupler). Raises BadTiming for rates that the 80 MHz
        clock of the lab's controllers cannot make, BadValue for a name that is taken.
        """
        self._check_new(name)
        nominal = timing or BitTiming.for_bit_rate(bit_rate, clock_hz=CLOCK_HZ)
        data = data_timing
        if data is None and data_bit_rate is not None:
            data = BitTiming.for_bit_rate(data_bit_rate, clock_hz=CLOCK_HZ)
        with self.touch():
            bus = LabBus(self, name, nominal, data, iso_fd, length_m, node_delay_ns)
        self.buses[name] = bus
        return bus

    def lin_bus(
        self, name: str = "lin0", *, bit_rate: int = 19_200, sleep_after: float | None = 4.0
    ) -> LabLinBus:
        """A new LIN bus at 1,000 to 20,000 bit/s; `master` and `slave` put nodes on it.

        Its nodes go to sleep after `sleep_after` seconds without an edge (None: never). Raises BadValue.
        """
        self._check_new(name)
        with self.touch():
            bus = LabLinBus(self, name, bit_rate, sleep_after)
        self.lin_buses[name] = bus
        return bus

    @property
    def now_ns(self) -> int:
        """Nanoseconds since the lab began."""
        return self.timeline.now_ns if self.pacer is None else self.pacer.now_ns()

    def run_for(self, seconds: float) -> None:
        """Let this much time pass."""
        self.run_until(self.now_ns + nanoseconds("seconds", seconds))

    def run_until(self, time_ns: int) -> None:
        """Let time pass until `time_ns`; everything due at that very moment happens too."""
        self.check_open()
        if self.pacer is None:
            while not self.timeline.run_until(time_ns):
                pass  # somebody's halt was not meant for us
        else:
            self.pacer.wait_until(time_ns)

    def run_until_idle(self) -> None:
        """Let time pass until no bus has anything to do and no timer waits (but for periodic ones).

        Raises NotIdle when a bus has been busy for a second without getting a single frame through.
        """
        self.check_open()
        if self.pacer is not None:
            self.pacer.wait(lambda: self.timeline.idle() or self._stalled() is not None, None)
        else:
            while not self.timeline.run_until_idle(self.timeline.now_ns + _CHUNK_NS):
                if self.timeline.next_ns() > self.timeline.now_ns + _CHUNK_NS:
                    self.timeline.run_until(self.timeline.next_ns())
                if self._stalled() is not None:
                    break
        stalled = self._stalled()
        if stalled is not None:
            raise NotIdle(stalled)

    def at(self, time_ns: int, callback: Callable[[], None], *, background: bool = False) -> Timer:
        """Call back at this time; a background timer does not keep the lab from being idle."""
        self.check_open()
        with self.touch():
            return self.timeline.at(time_ns, callback, background=background)

    def lateness_ns(self) -> list[int]:
        """Real time only: how late each happening was handled."""
        return [] if self.pacer is None else self.pacer.lateness_ns()

    def close(self) -> None:
        """End the lab; a second time does nothing."""
        if not self._closed:
            self._closed = True
            for bus in self.buses.values():
                bus.close()
            for lin_bus in self.lin_buses.values():
                lin_bus.close()
            if self.pacer is not None:
                self.pacer.close()

    def __enter__(self) -> Lab:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # for buses and nodes

    def touch(self) -> AbstractContextManager[None]:
        """Hold the timeline still while it is changed, and let everybody know afterwards."""
        return _UNSHARED if self.pacer is None else self._locked(self.pacer)

    def advance(self, deadline_ns: int, ready: Callable[[], bool]) -> bool:
        """Let time pass until `ready` or the deadline; nodes halt the timeline when something arrives."""
        if self.pacer is not None:
            return self.pacer.wait(ready, max(0.0, (deadline_ns - self.now_ns) / 1e9))
        while not ready():
            if self.timeline.run_until(deadline_ns):
                return ready()
        return True

    async def turn(self, deadline_ns: int) -> None:
        """Let other tasks have their turn; when none of them did anything, let the next thing happen."""
        import asyncio

        waiter = asyncio.get_running_loop().create_future()
        self._activity[waiter] = deadline_ns
        try:
            for _ in range(3):
                await asyncio.sleep(0)
                if waiter.done():
                    return
            await self._pass_time(waiter, min(self._activity.values()))
        finally:
            self._activity.pop(waiter, None)

    def active(self) -> None:
        """Something happened that a waiting task may be waiting for."""
        if self._activity:
            for waiter in list(self._activity):
                waiter.get_loop().call_soon_threadsafe(_resolve, waiter)

    async def _pass_time(self, waiter: asyncio.Future[None], deadline_ns: int) -> None:
        import asyncio

        if self.pacer is not None:
            timeout = None if deadline_ns >= NEVER else max(0.0, (deadline_ns - self.now_ns) / 1e9)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(waiter, timeout)
            self.pacer.check()
            return
        due_ns = self.timeline.next_ns()
        if due_ns > deadline_ns:
            self.timeline.run_until(deadline_ns)
        elif due_ns >= NEVER:
            await waiter  # nothing will ever happen unless another task makes it
        else:
            self.timeline.run_until(due_ns)

    def _stalled(self) -> str | None:
        for bus in self.buses.values():
            trouble = bus.stalled(_STALL_NS)
            if trouble is not None:
                return trouble
        return None

    @contextlib.contextmanager
    def _locked(self, pacer: Pacer) -> Iterator[None]:
        with pacer.lock:
            pacer.check()
            pacer.catch_up()
            yield
            pacer.wake()

    def _check_new(self, name: str) -> None:
        self.check_open()
        if name in self.buses or name in self.lin_buses:
            raise BadValue(f"there is a bus {name!r} already")

    def check_open(self) -> None:
        """Raise Closed after `close`."""
        if self._closed:
            raise Closed("this lab")


def _resolve(waiter: asyncio.Future[None]) -> None:
    if not waiter.done():
        waiter.set_result(None)


CLOCK_HZ = 80_000_000
_UNSHARED: AbstractContextManager[None] = contextlib.nullcontext()
