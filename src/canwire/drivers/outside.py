"""What drivers of real adapters share: who wakes the hub's thread for them, and whose clock is whose.

Only these drivers' own files may read clocks and have threads; everything they find out goes by `post` to the thread
that owns the world.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Protocol

from canwire.drivers.driver import Counters
from canwire.drivers.reporting import ReportingDriver
from canwire.timeline import Timeline
from canwire.values.event import ErrorKind, ErrorState, EventKind
from canwire.values.frame import Frame, frame_of_record
from canwire.values.record import (
    DLC_MASK,
    ERROR_STATE_INDICATOR,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    FAST_DATA_RATE,
    REMOTE,
)

if TYPE_CHECKING:
    from canwire.chips.host import Host

DRIFT_PPM = 200  # between two crystals
_HEAD = struct.Struct("<QII")  # of a record: time, identifier, info
_OF_FRAMES = EXTENDED | REMOTE | EXTENDED_DATA_LENGTH | FAST_DATA_RATE | ERROR_STATE_INDICATOR | DLC_MASK
_JUMP_NS = 1_000_000_000


class HasFileno(Protocol):
    def fileno(self) -> int: ...


class Reactor(Protocol):
    """Whoever owns the thread that everything happens in; `post` may be called from any thread, the rest from that one.

    `watch` calls back whenever a descriptor is readable (or broken), or writable; `unwatch` it before it is closed.
    """

    def watch(
        self, source: HasFileno, readable: Callable[[], object], writable: Callable[[], object] | None = None
    ) -> None: ...
    def unwatch(self, source: HasFileno) -> None: ...
    def post(self, work: Callable[[], object]) -> None: ...
    def when_closed(self, callback: Callable[[], object]) -> None: ...
    def forget(self, callback: Callable[[], object]) -> None: ...


class Trouble(IntEnum):
    """Code of an ERROR event (ErrorKind.OTHER) about the adapter itself rather than its bus."""

    NO_ANSWER = 1  # to a command, in time
    WRONG_ANSWER = 2  # one that does not belong to the command
    REFUSED = 3  # it will not do what it was told
    MALFORMED = 4  # what it said was cut or mangled: a frame may be lost
    STRANGER = 5  # another adapter is where this one was


@dataclass(frozen=True, slots=True)
class Identity:
    """What an adapter says of itself: facts for people, and its versions as BoardInfo has them."""

    facts: tuple[tuple[str, str], ...] = ()
    hardware_version: tuple[int, int, int, int] = (0, 0, 0, 0)
    firmware_version: tuple[int, int] = (0, 0)


class OutsideDriver(ReportingDriver):
    """A driver whose controller is an adapter that may come and go; one mailbox, whose frame waits for it.

    While the adapter is gone the line stays as it was set up and its state is STOPPED. A STATE event tells of the
    loss, CHANGED and STATE of the return: between them is the gap. What adapters do not tell stays 0: TEC and REC.
    """

    def __init__(self, host: Host | None, timeline: Timeline, port: str) -> None:
        super().__init__(host, lambda: timeline.now_ns)
        self.on_identified: Callable[[Identity], object] | None = None
        self.on_obstacle: Callable[[str], object] | None = None
        self.text = ""  # what went wrong last
        self._told = ""  # of what keeps it from its bus
        self.timeline = timeline
        self.port = port
        self.on_bus = False
        self.state = ErrorState.ERROR_ACTIVE
        self._been = False
        self._tec = self._rec = 0

    def rejoin(self, at_ns: int) -> None:
        """Its plug is its own affair."""

    def on_wire(self) -> bool:
        """Nobody can see."""
        return False

    def counters(self) -> Counters:
        state = self.state if self.on_bus else ErrorState.STOPPED
        return self.counted(self._tec, self._rec, state)

    def obstacle(self) -> str:
        """What keeps the adapter from its bus, in words for people; "" while nothing is known to."""
        return "" if self.on_bus else self.text

    # for the drivers themselves

    def hindered(self, why: str) -> None:
        """The adapter cannot be reached for this reason; people are told once of each."""
        self.text = why
        if why != self._told:
            self._told = why
            if self.on_obstacle is not None:
                self.on_obstacle(why)

    def begin(self) -> None:
        """The line was started: what comes next is no return."""
        self.running = True
        self._been = False

    def end(self) -> None:
        """It was stopped."""
        was_running, self.running = self.running, False
        if was_running and self.on_bus:
            self.on_bus = False
            self.tell(EventKind.STATE)

    def joined(self) -> None:
        """The adapter takes part in its bus."""
        self.on_bus = self.running
        self.text = self._told = ""
        self.state = ErrorState.ERROR_ACTIVE
        if self._been:
            self.tell(EventKind.CHANGED)
        self._been = True
        self.tell(EventKind.STATE)
        self.fill()

    def left(self) -> None:
        """It does no longer, though nobody has told it to."""
        if self.on_bus:
            self.on_bus = False
            if self.running:
                self.tell(EventKind.STATE)

    def now_in(self, state: ErrorState) -> None:
        """Fault confinement has put it there."""
        if state is not self.state:
            self.state = state
            self.tell(EventKind.STATE)

    def trouble(self, what: Trouble, text: str) -> None:
        """With the adapter itself."""
        self.text = text
        self.tell(EventKind.ERROR, ErrorKind.OTHER, code=int(what))

    def finished(self, sent: bool) -> None:
        """The mailbox's frame is in the adapter's queue, or was given up; the next one may come."""
        if self.normal.occupied:
            self.over(self.normal, sent)

    def frame(self) -> Frame:
        """The mailbox's, without what its sender asked for besides."""
        block = bytearray(self.normal.block)
        _, id, info = _HEAD.unpack_from(block)
        _HEAD.pack_into(block, 0, 0, id, info & _OF_FRAMES)
        return frame_of_record(block)


class AdapterClock:
    """Times of an adapter's clock as times of ours: the quickest way that a stamp ever took counts as no delay at all.

    A clock with a `period_ns` starts anew after it; how often it has, tells the time of arrival. The result is early
    never, late by the shortest delay (and the clocks' drift, DRIFT_PPM of the time since a stamp came as quickly), and
    never decreases. Stamps must arrive within half a period. A clock without a period may be set while it runs.
    """

    def __init__(self, period_ns: int = 0) -> None:
        self._period_ns = period_ns
        self._offset_ns: int | None = None
        self._arrived_ns = 0
        self._last_ns = 0

    def host_ns(self, stamp_ns: int, arrived_ns: int) -> int:
        """When that was by our clock; `arrived_ns` is when we heard of it, and never decreases."""
        offset, period = self._offset_ns, self._period_ns
        if offset is None:
            offset = arrived_ns - stamp_ns
        else:
            if period:
                stamp_ns += (arrived_ns - offset - stamp_ns + period // 2) // period * period
            offset += (arrived_ns - self._arrived_ns) * DRIFT_PPM // 1_000_000
            quickest = arrived_ns - stamp_ns
            if quickest < offset or (not period and quickest - offset > _JUMP_NS):
                offset = quickest
        self._offset_ns, self._arrived_ns = offset, arrived_ns
        self._last_ns = max(self._last_ns, stamp_ns + offset)
        return self._last_ns
