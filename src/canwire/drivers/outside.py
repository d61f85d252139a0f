"""What drivers of real adapters have in common: work in the hub's thread, and adapter times converted to hub times.

Only the files of these drivers may read clocks and have threads. They pass everything that they find out to the hub's
thread, by `post`.
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
    """The loop of the hub's thread. `post` may be called from any thread, the other methods only from that one.

    `watch` calls back whenever a descriptor is readable (or broken), or writable; `unwatch` it before you close it.
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
    REFUSED = 3  # a command
    MALFORMED = 4  # a line was cut or mangled: a frame may be lost
    STRANGER = 5  # another adapter is where this one was


@dataclass(frozen=True, slots=True)
class Identity:
    """What an adapter reports about itself: facts for display, and its versions in the form of BoardInfo."""

    facts: tuple[tuple[str, str], ...] = ()
    hardware_version: tuple[int, int, int, int] = (0, 0, 0, 0)
    firmware_version: tuple[int, int] = (0, 0)


class OutsideDriver(ReportingDriver):
    """A driver of an adapter that may be unplugged and come back. It has one mailbox, whose frame waits meanwhile.

    While the adapter is gone, the line keeps its settings and its state is STOPPED. A STATE event reports the loss;
    CHANGED and STATE events report the return. TEC and REC are 0, since adapters do not report them.
    """

    def __init__(self, host: Host | None, timeline: Timeline, port: str) -> None:
        super().__init__(host, lambda: timeline.now_ns)
        self.on_identified: Callable[[Identity], object] | None = None
        self.on_obstacle: Callable[[str], object] | None = None
        self.text = ""  # what went wrong last
        self._told = ""  # the obstacle that was reported last
        self.timeline = timeline
        self.port = port
        self.on_bus = False
        self.state = ErrorState.ERROR_ACTIVE
        self._been = False
        self._tec = self._rec = 0

    def rejoin(self, at_ns: int) -> None:
        """Nothing: the cable of a real adapter is not simulated."""

    def on_wire(self) -> bool:
        """False: an adapter does not report it."""
        return False

    def counters(self) -> Counters:
        state = self.state if self.on_bus else ErrorState.STOPPED
        return self.counted(self._tec, self._rec, state)

    def obstacle(self) -> str:
        """Why the adapter does not take part in its bus, for display; "" if it does, or if no reason is known."""
        return "" if self.on_bus else self.text

    # for the drivers themselves

    def hindered(self, why: str) -> None:
        """The adapter cannot be reached for this reason. A reason that does not change is reported once."""
        self.text = why
        if why != self._told:
            self._told = why
            if self.on_obstacle is not None:
                self.on_obstacle(why)

    def begin(self) -> None:
        """The line was started: the next `joined` reports no return of the adapter."""
        self.running = True
        self._been = False

    def end(self) -> None:
        """The line was stopped."""
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
        """The adapter no longer takes part in its bus, though the line was not stopped."""
        if self.on_bus:
            self.on_bus = False
            if self.running:
                self.tell(EventKind.STATE)

    def now_in(self, state: ErrorState) -> None:
        """Fault confinement has put the controller into this state."""
        if state is not self.state:
            self.state = state
            self.tell(EventKind.STATE)

    def trouble(self, what: Trouble, text: str) -> None:
        """Report a fault of the adapter itself."""
        self.text = text
        self.tell(EventKind.ERROR, ErrorKind.OTHER, code=int(what))

    def finished(self, sent: bool) -> None:
        """The mailbox's frame was `sent` to the adapter's queue, or discarded; the next frame may be loaded."""
        if self.normal.occupied:
            self.over(self.normal, sent)

    def frame(self) -> Frame:
        """The frame in the mailbox, without the flags that are only about its sending."""
        block = bytearray(self.normal.block)
        _, id, info = _HEAD.unpack_from(block)
        _HEAD.pack_into(block, 0, 0, id, info & _OF_FRAMES)
        return frame_of_record(block)


class AdapterClock:
    """Converts times of an adapter's clock to times of the computer's clock. The shortest delay seen counts as none.

    A clock with a `period_ns` starts again from 0 after each period; the time of arrival shows which period a stamp is
    from, so stamps must arrive within half a period. The result is never early and never decreases; it is late by the
    shortest delay, and by the drift of the clocks (DRIFT_PPM of the time since a stamp had the shortest delay). A
    clock without a period may be set while it runs.
    """

    def __init__(self, period_ns: int = 0) -> None:
        self._period_ns = period_ns
        self._offset_ns: int | None = None
        self._arrived_ns = 0
        self._last_ns = 0

    def host_ns(self, stamp_ns: int, arrived_ns: int) -> int:
        """The stamp by the computer's clock; `arrived_ns` is when the stamp was received, and never decreases."""
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
