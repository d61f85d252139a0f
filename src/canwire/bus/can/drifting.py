# cython: nonecheck=False
"""Stretches of bits of clocks that disagree: each clock is computed from one edge of the sender to the next.

As in coasting.py such a stretch has no observable event. Either one sender is received by readers that have read
the same bits: every sample of a reader must lie in the matching bit of the sender, however edges move its clock.
Or the wire stays recessive, and no clock reaches a sample that ends something. The stretch contains everything before
`end_ps`; bit_level.py processes what happens at `end_ps` and later.
Source: ISO 11898-1:2015 chapter 11.3 (bit timing and synchronisation).
"""

from __future__ import annotations

from canwire.bus.can import coasting, reader_state
from canwire.bus.can.clock import Clock
from canwire.bus.can.coasting import Stretch
from canwire.bus.can.frame_reader import CRC_DELIMITER, RES
from canwire.bus.can.station import ACTIVE_FLAG, FRAME, OVERLOAD_FLAG
from canwire.bus.can.stimulus import FREE
from canwire.timeline import NEVER

_FRAME, _ACTIVE_FLAG, _OVERLOAD_FLAG = FRAME, ACTIVE_FLAG, OVERLOAD_FLAG
_CRC_DELIMITER, _RES_FIELD = CRC_DELIMITER, RES
_NEVER, _FREE = NEVER, FREE
_LONG = 1 << 20


class Apart(Stretch):
    """The next stretch of a bus whose clocks disagree.

    `lead` is the clock whose bits are counted, from its `due_ps` on; the stretch ends at `latest_ps` at the latest.
    """

    def __init__(self) -> None:
        super().__init__()
        self.lead: Clock | None = None
        self.end_ps = 0
        self.latest_ps = 0

    def look_apart(self, clocks: list[Clock], wire: int, limit_ps: int, calm: bool) -> int:
        """How many bits of `lead` begin in the stretch, all before `limit_ps`; 0 if there is no stretch.

        `calm` means that `disturb` is called for no bit of a sender. The wire now has the level `wire`.
        """
        self.sender = None
        for clock in clocks:
            if not _runs_freely(clock):
                return 0
            if clock.station.transmitting and clock.station.state == _FRAME:
                if self.sender is not None:
                    return 0
                self.sender = clock
        if self.sender is not None:
            sender = self.sender.station
            if self.sender.sampling:
                return 0
            if sender.index < sender.layout.tail_bit:
                return self._look_along_one(clocks, wire, limit_ps)
            if not calm:
                return 0
        return self._look_at_rest(clocks, limit_ps) if wire else 0

    def is_inside_bit(self) -> bool:
        """Whether the sender found last still sends, and has not yet sampled its bit: no stretch begins there."""
        sender = self.sender
        return (
            sender is not None
            and sender.sampling
            and sender.station.transmitting
            and sender.station.state == _FRAME
        )

    # a frame as it is laid out

    def _look_along_one(self, clocks: list[Clock], wire: int, limit_ps: int) -> int:
        """The length in bits of a stretch with one sender, whose frame all other nodes read."""
        assert self.sender is not None
        lead = self.sender
        sender, began_ps = lead.station, lead.due_ps
        most = (limit_ps - began_ps) // lead.bit_ps() if limit_ps > began_ps else 0
        if most < 1:
            return 0
        self._take(sender, sender.levels)
        bits = self._end(sender, 0) - self.first
        most = most if most < bits else bits
        for clock in clocks:
            station = clock.station
            if station.state != _FRAME or station.index != sender.index or clock.due_ps < began_ps:
                return 0
            if clock.data_rate != lead.data_rate or (station.out == 0 and clock is not lead):
                return 0
            if clock is not lead and not reader_state.alike(station.reader, sender.reader, False):
                return 0
        reader_state.double(self._scratch, sender.reader)
        self.lead, self._wire = lead, wire
        return self.cut(clocks, self._mere_bits(most))

    def _mere_bits(self, most: int) -> int:
        """How many of the next bits have no effect by themselves; the edge to the res bit synchronises clocks hard."""
        scratch = self._scratch
        taken = 0
        while taken < most and scratch.field <= _RES_FIELD:
            if scratch.field == _RES_FIELD or scratch.take_run(self.levels, self.first + taken, 1) == 0:
                return taken
            taken += 1
        return taken + scratch.take_run(self.levels, self.first + taken, most - taken)

    def cut(self, clocks: list[Clock], bits: int) -> int:
        """Follow all clocks for this number of bits of the frame; 0 if a sample of one of them is in the wrong bit."""
        assert self.lead is not None
        if bits < 1 or self.level >= 0:
            return bits
        lead = self.lead
        self.end_ps = lead.due_ps + bits * lead.bit_ps()
        self.latest_ps = self.end_ps - lead.bit_ps() + lead.sample_ps()
        for clock in clocks:
            if clock is not lead and not self._follow(clock, bits):
                return 0
        return bits

    def _follow(self, clock: Clock, bits: int) -> bool:
        """Compute a reader's clock at the end; False if one of its samples does not lie in the matching bit of the
        sender.
        """
        assert self.lead is not None
        bit_ps, sample_ps = clock.bit_ps(), clock.sample_ps()
        sender_bit_ps, edge_ps = self.lead.bit_ps(), self.lead.due_ps
        start_ps, due_ps, sampling = clock.start_ps, clock.due_ps, clock.sampling
        synchronised, last, wire = clock.synchronised, clock.station.last_sample, self._wire
        taken = begun = 0
        for k in range(bits + 1):
            while due_ps < edge_ps or (due_ps == edge_ps and not sampling and k < bits):
                if due_ps > self.latest_ps:
                    self.latest_ps = due_ps
                if sampling:
                    if taken == k:
                        return False
                    last = self.levels[self.first + taken]
                    taken += 1
                    sampling = synchronised = False
                    due_ps += bit_ps - sample_ps
                else:
                    begun += 1
                    sampling = True
                    start_ps = due_ps
                    due_ps += sample_ps
            if taken != k:
                return False
            if k < bits:
                level = self.levels[self.first + k]
                if level == 0 and wire == 1 and last == 1 and not synchronised:
                    due_ps += _correction(clock, edge_ps, start_ps, due_ps, sampling)
                    synchronised = True
                wire = level
                edge_ps += sender_bit_ps
        clock.keep_ahead(start_ps, due_ps, sampling, synchronised, taken, begun)
        return True

    # a recessive wire

    def _look_at_rest(self, clocks: list[Clock], limit_ps: int) -> int:
        """The length of a recessive stretch, up to the first sample of any node that has an effect."""
        self.level = 1
        self.end_ps = limit_ps
        busy = False
        for clock in clocks:
            station = clock.station
            if station.finished or station.rejoined or station.state in (_ACTIVE_FLAG, _OVERLOAD_FLAG):
                return 0
            bits = self._in_frame(station, 1) if station.state == _FRAME else coasting._between(station, 1)
            if bits < 1 or (station.state == _FRAME and station.reader.field <= _CRC_DELIMITER):
                return 0
            busy = busy or not station.resting()
            if bits < _LONG:
                sampled_ps = clock.due_ps + (bits - 1) * clock.bit_ps()
                if not clock.sampling:
                    sampled_ps += clock.sample_ps()
                if sampled_ps < self.end_ps:
                    self.end_ps = sampled_ps
        return self._run_down(clocks) if busy else 0

    def _run_down(self, clocks: list[Clock]) -> int:
        """Advance all clocks to `end_ps` without any correction."""
        self.latest_ps = -1
        for clock in clocks:
            bit_ps, sample_ps = clock.bit_ps(), clock.sample_ps()
            start_ps, due_ps, sampling, synchronised = (
                clock.start_ps,
                clock.due_ps,
                clock.sampling,
                clock.synchronised,
            )
            taken = begun = 0
            while due_ps < self.end_ps:
                if due_ps > self.latest_ps:
                    self.latest_ps = due_ps
                if sampling:
                    taken += 1
                    sampling = synchronised = False
                    due_ps += bit_ps - sample_ps
                else:
                    begun += 1
                    sampling = True
                    start_ps = due_ps
                    due_ps += sample_ps
            clock.keep_ahead(start_ps, due_ps, sampling, synchronised, taken, begun)
        if self.latest_ps < 0:
            return 0
        self.lead = clocks[0]
        if self.sender is not None:
            self.lead = self.sender
            if self.sender.ahead_begun > 0:
                return self.sender.ahead_begun
            self.sender = None
        return 1

    # continuing

    def last_ps(self, began_ps: int, bits: int, clock: Clock) -> int:
        """The time of the last event in the stretch."""
        return self.latest_ps

    def go(self, clocks: list[Clock], bits: int, at_ps: int, sampled_ns: int) -> None:
        """Put all clocks and stations into the state that was computed for the end of the stretch."""
        for clock in clocks:
            station = clock.station
            station.now_ns = sampled_ns
            if self.level >= 0:
                self._go_at_rest(clock)
            elif clock is self.lead:
                clock.drive_run(self.levels, self.first, bits, at_ps)
                clock.pass_bits(bits, at_ps)
            else:
                clock.go_ahead()
            if self.level < 0:
                station.last_sample = self.levels[self.first + bits - 1]
                station.rate_change = 0
                station.just_free = False
                station.index += bits
        if self.level < 0:
            self._read_on(clocks, bits)

    def _go_at_rest(self, clock: Clock) -> None:
        station = clock.station
        clock.go_ahead()
        if clock.ahead_begun:
            station.just_free = False
        if clock.ahead_taken:
            station.last_sample = 1
            station.rate_change = 0
            coasting._keep(station, 1, clock.ahead_taken)


def _runs_freely(clock: Clock) -> bool:
    """Whether no edge is on its way to this clock, and the node reads its own bits while it drives them."""
    return (
        clock.edge_ps == _NEVER
        and clock.check_ps == _NEVER
        and clock.forced == _FREE
        and clock.node.loop_ps == 0
        and clock.node.sample_gap_ps == 0
        and not clock.node.compensates
    )


def _correction(clock: Clock, edge_ps: int, start_ps: int, due_ps: int, sampling: bool) -> int:
    """By how many ps an edge moves the next event of a reader's clock."""
    node = clock.node
    jump_ps = node.data_jump_ps if clock.data_rate else node.jump_ps
    if not sampling:
        early_ps = due_ps - edge_ps
        return -early_ps if early_ps < jump_ps else -jump_ps
    quantum_ps = node.data_quantum_ps if clock.data_rate else node.quantum_ps
    late_ps = (edge_ps - start_ps) // quantum_ps * quantum_ps
    if late_ps <= 0:
        return 0
    return late_ps if late_ps < jump_ps else jump_ps
