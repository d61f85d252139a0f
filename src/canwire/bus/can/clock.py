# cython: nonecheck=False
"""The bit time of one station: its boundaries, its sample points, and how the edges that it sees move them.

Times are bit_level.py's picoseconds.
Source: ISO 11898-1:2015 chapter 11.3 (bit timing and synchronisation); reference/can-protocol.md section 8.
"""

from __future__ import annotations

from canwire.bus.can.echo import Echo
from canwire.bus.can.frame_reader import RES
from canwire.bus.can.station import (
    ACTIVE_FLAG,
    FRAME,
    IDLE,
    INTERMISSION,
    KEEP_RATE,
    OVERLOAD_FLAG,
    SUSPEND,
    TO_DATA_RATE,
    WAITING,
    Station,
)
from canwire.bus.can.stimulus import FREE
from canwire.timeline import NEVER
from canwire.values.checks import instance

_FRAME, _IDLE, _INTERMISSION, _SUSPEND, _WAITING = FRAME, IDLE, INTERMISSION, SUSPEND, WAITING
_ACTIVE_FLAG, _OVERLOAD_FLAG = ACTIVE_FLAG, OVERLOAD_FLAG
_KEEP_RATE, _TO_DATA_RATE = KEEP_RATE, TO_DATA_RATE
_NEVER, _FREE, _RES_FIELD = NEVER, FREE, RES


class Clock:
    """The bit time of one station: the start of its present bit, its next sample point, and how far it is corrected."""

    def __cinit__(self, *_: object) -> None:
        """As Echo's."""
        self.station = Station.__new__(Station)
        self.node = self.station.node
        self.echo = Echo.__new__(Echo)

    def __init__(self, station: Station, at_ps: int) -> None:
        instance("station", station, Station)
        self.station = station
        self.node = station.node
        self.echo = Echo(self.node)
        self.keep_ahead(at_ps, at_ps, False, False, 0, 0)
        self.begin(at_ps)

    def begin(self, at_ps: int) -> None:
        """Start at a bit boundary: the station has just joined the bus, or joins it again."""
        self.echo.begin()
        self.start_ps = at_ps
        self.due_ps = at_ps  # of its next bit boundary or sample point
        self.sampling = False
        self.synchronised = False
        self.joins = False  # it begins its SOF with somebody else's
        self.edged = False  # a dominant level has begun its bit: an idle one is not to be cut short
        self.edge_ps = _NEVER  # of an edge still on its way
        self.check_ps = _NEVER  # of a second sample point, or of the end of what an edge has to last
        self.forced = _FREE  # a stimulus puts this level in front of its receiver
        self.free = True  # none did so up to now
        self.seen = 1
        self.data_rate = False
        self.looks = 3  # what it has seen before its sample point, newest in bit 0

    def go_off(self, at_ps: int, at_end: bool) -> None:
        """Leave the bus; the level that the node drives ends now, or at the end of its bit if `at_end`."""
        self.station.wait_for_bus()
        self.data_rate = False
        self.check_ps = self.echo.forget_checks()
        if not at_end:
            self.station.out = 1
            self.echo.drive(1, at_ps)

    def count_from(self, at_ps: int) -> None:
        """Begin to count recessive bits now, with a new bit."""
        self.station.run = 0
        self.due_ps, self.sampling = at_ps, False

    def bit_ps(self) -> int:
        return self.node.data_bit_ps if self.data_rate else self.node.bit_ps

    def sample_ps(self) -> int:
        return self.node.data_sample_ps if self.data_rate else self.node.sample_ps

    def begin_bit(self, at_ps: int) -> None:
        """Begin a bit at a bit boundary: `out` may change."""
        self.start_ps = at_ps
        self.sampling = True
        self.joins = False
        self.edged = self.station.sof_seen
        self.due_ps = at_ps + self.sample_ps()
        self.station.begin_bit()
        self.echo.drive(self.station.out, at_ps)
        if self.node.compensates and self.station.transmitting:
            self._compensate(at_ps)

    def _compensate(self, at_ps: int) -> None:
        if self.data_rate:
            self.check_ps = self.echo.look_later(self.station.out, at_ps)
        elif self.station.state == _FRAME and self.station.reader.field == _RES_FIELD:
            self.edge_ps = min(self.edge_ps, self.echo.measure_from(at_ps))

    def next_ps(self, now_ps: int) -> int:
        """The time of this clock's next event."""
        soonest = min(self.due_ps, self.edge_ps, self.check_ps)
        gap_ps = self.node.sample_gap_ps
        if gap_ps and self.sampling:
            if self.due_ps - 2 * gap_ps > now_ps:
                return min(soonest, self.due_ps - 2 * gap_ps)
            if self.due_ps - gap_ps > now_ps:
                return min(soonest, self.due_ps - gap_ps)
        return soonest

    def looks_before(self, at_ps: int) -> bool:
        """True at one of the earlier samples of a bit that is sampled three times."""
        before_ps, gap_ps = self.due_ps - at_ps, self.node.sample_gap_ps
        return self.sampling and (before_ps == gap_ps or before_ps == 2 * gap_ps)

    def look(self, level: int) -> None:
        """Store the level of one of these earlier samples."""
        self.looks = self.looks << 1 & 2 | level

    def found(self, level: int) -> int:
        """The level that the station gets for this sample.

        Of three samples, the majority decides. A compensating sender uses its second sample points instead.
        """
        if self.node.sample_gap_ps:
            return 1 if (self.looks & 1) + (self.looks >> 1) + level > 1 else 0
        if self.data_rate and self.node.compensates and self.station.transmitting:
            return self.echo.outcome(self.station.out)
        return level

    def check(self, level: int, at_ps: int) -> None:
        """Process a second sample point, or, for a node that waits for the bus, the end of the edge filter's two
        quanta.
        """
        if self.station.state != _WAITING:
            self.check_ps = self.echo.check(level)
            return
        self.check_ps = _NEVER
        if level == 0:
            self.station.run = 0
            self.sampling = True  # nothing else waits for the bit that began with the edge
            self._restart_bit(at_ps - 2 * self.node.quantum_ps)

    def sampled(self, at_ps: int) -> None:
        """Finish a sample: the rest of the bit runs at the rate that is valid from here on."""
        self.sampling = False
        self.synchronised = False
        change = self.station.rate_change
        if change != _KEEP_RATE:
            self.data_rate = change == _TO_DATA_RATE
            self.check_ps = self.echo.forget_checks()
        self.due_ps = at_ps + self.bit_ps() - self.sample_ps()

    def drive_run(self, levels: bytes, first: int, bits: int, at_ps: int) -> None:
        """Record that the station drove `bits` of these levels, in bits that begin at `at_ps`."""
        self.echo.drive_run(levels, first, bits, at_ps, self.bit_ps())
        self.station.out = levels[first + bits - 1]

    def answer(self, at_ps: int, over: bool) -> None:
        """Drive the ACK slot, which began at `at_ps`, and the bits after it if it is `over`."""
        self.echo.drive(0, at_ps)
        self.station.out = 0
        if over:
            self.drive_steady(at_ps + self.bit_ps())

    def drive_steady(self, at_ps: int) -> None:
        """Drive one level from `at_ps` on: dominant during an active error flag or an overload flag, else recessive."""
        state = self.station.state
        level = 0 if state == _ACTIVE_FLAG or state == _OVERLOAD_FLAG else 1
        self.station.out = level
        if level != self.echo.last:
            self.echo.drive(level, at_ps)

    def pass_bits(self, bits: int, at_ps: int) -> None:
        """Skip this number of bits, the first of which began at `at_ps`; all of them have been sampled."""
        self.start_ps = at_ps + (bits - 1) * self.bit_ps()
        self.due_ps = self.start_ps + self.bit_ps()
        self.synchronised = self.joins = self.edged = False

    def keep_ahead(
        self, start_ps: int, due_ps: int, sampling: bool, synchronised: bool, taken: int, begun: int
    ) -> None:
        """Store the state after so many samples taken and bits begun, for `go_ahead`."""
        self.ahead_start_ps = start_ps
        self.ahead_due_ps = due_ps
        self.ahead_sampling = sampling
        self.ahead_synchronised = synchronised
        self.ahead_taken = taken
        self.ahead_begun = begun

    def go_ahead(self) -> None:
        """Apply the state that `keep_ahead` stored."""
        self.start_ps = self.ahead_start_ps
        self.due_ps = self.ahead_due_ps
        self.sampling = self.ahead_sampling
        self.synchronised = self.ahead_synchronised
        if self.ahead_begun:
            self.joins = self.edged = False

    def coasts_with(self, other: Clock) -> bool:
        """Whether both clocks begin a bit at the same time, and their next bits are the same."""
        return (
            self.due_ps == other.due_ps
            and not self.sampling
            and self.bit_ps() == other.bit_ps()
            and self.data_rate == other.data_rate
            and self.edge_ps == _NEVER
            and self.check_ps == _NEVER
            and self.forced == _FREE
            and self.node.loop_ps == 0
            and not self.node.compensates
        )

    def edge(self, at_ps: int) -> None:
        """Process a recessive to dominant edge: synchronise once between two samples, hard at the start of a frame."""
        station = self.station
        state = station.state
        if state == _WAITING:  # a node that waits for the bus follows every edge, and starts its count again
            if self.node.edge_filter and not station.rejoined:
                self.check_ps = at_ps + 2 * self.node.quantum_ps
                return
            station.run = 0
            station.sof_seen = station.rejoined
            self._restart_bit(at_ps)
            return
        if self.echo.takes(at_ps) or self.synchronised or station.last_sample == 0:
            return
        idle = state == _IDLE or state == _SUSPEND
        # in the intermission: an edge in any bit but the first one
        behind = state == _INTERMISSION and station.left <= (2 if self.sampling else 1)
        if idle or behind:
            # nodes that have a frame to send join an SOF that comes after the last sample of the intermission
            self.joins = station.just_free and state == _IDLE and station.ready_to_send()
            station.sof_seen = idle and not self.joins
            self._restart_bit(at_ps)
        elif state == _FRAME and station.reader.field == _RES_FIELD and not station.transmitting:
            self._restart_bit(at_ps)
        elif not (station.transmitting and self.data_rate):
            self._resynchronise(at_ps)

    def _restart_bit(self, at_ps: int) -> None:
        self.synchronised = True
        if self.sampling:
            self.start_ps = at_ps
            self.due_ps = at_ps + self.sample_ps()
            self.edged = True
        else:
            self.due_ps = at_ps  # a bit begins at this very instant, and others see what is driven in it

    def _resynchronise(self, at_ps: int) -> None:
        quantum = self.node.data_quantum_ps if self.data_rate else self.node.quantum_ps
        jump = self.node.data_jump_ps if self.data_rate else self.node.jump_ps
        if self.sampling:
            late = (at_ps - self.start_ps) // quantum * quantum
            if late > 0:
                if self.station.out == 0:
                    return  # a node that drives dominant ignores a late edge
                self.due_ps += late if late < jump else jump
        else:
            early = self.due_ps - at_ps
            self.due_ps -= early if early < jump else jump
        self.synchronised = True
