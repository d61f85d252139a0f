# cython: nonecheck=False
"""Stretches of bits without any observable event, which bit_level.py processes in one step.

All clocks must be at the same bit boundary and run at the same rate, so that every edge comes where all of them
begin a bit anyway. Then either all nodes read the levels that one sender laid out, and one reader reads for all those
that have read the same bits; or the wire keeps its level until a flag, delimiter, field or count ends. bit_level.py
processes the bit where one ends, and all other bits that do not fit.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.bus.can import reader_state
from canwire.bus.can.bit_layout import KeptLayout
from canwire.bus.can.bits import NON_ISO
from canwire.bus.can.clock import Clock
from canwire.bus.can.frame_reader import ACK_DELIMITER, CRC_DELIMITER, EOF, FrameReader
from canwire.bus.can.station import (
    ACTIVE_FLAG,
    DELIMITER,
    FLAG_WAIT,
    FRAME,
    IDLE,
    INTERMISSION,
    OVERLOAD_FLAG,
    PASSIVE_FLAG,
    SUSPEND,
    WAITING,
    Station,
)

_IDLE, _FRAME, _ACTIVE_FLAG, _PASSIVE_FLAG, _FLAG_WAIT = IDLE, FRAME, ACTIVE_FLAG, PASSIVE_FLAG, FLAG_WAIT
_DELIMITER, _OVERLOAD_FLAG, _INTERMISSION, _SUSPEND, _WAITING = (
    DELIMITER, OVERLOAD_FLAG, INTERMISSION, SUSPEND, WAITING,
)  # fmt: skip
_CRC_DELIMITER, _ACK_DELIMITER, _EOF = CRC_DELIMITER, ACK_DELIMITER, EOF
_EOF_BITS, _TAIL_BITS = 7, 10  # the latter from the CRC delimiter on
_ACK_BIT = 1  # counted from there
_FEW = 6  # no more equal bits are read in one step
_LONG, _NON_ISO = 1 << 20, NON_ISO
_RECOVERED = 11  # recessive bits in a row
_FEW_BITS = 5  # as many equal ones as a frame has


class Stretch:
    """The next stretch of bits of one bus: `levels` from index `first` on, or `level` for all if it is not -1.

    `sender` is the clock of the node whose frame is read, None between frames; `tail` is the index of its CRC
    delimiter.
    """

    def __init__(self) -> None:
        self.levels = b""
        self.first = self.tail = 0
        self.level = -1
        self.sender: Clock | None = None
        self._scratch = FrameReader(0)
        self._unlike = False
        self._asked: FrameReader | None = None
        self._answer = 0

    def look(self, clocks: list[Clock], most: int, recessive: bool, at_ns: int) -> int:
        """The number of bits of the stretch, up to `most`; 0 if no stretch begins here, at `at_ns`.

        `recessive` means that idle nodes may begin to send: the wire has been recessive up to now.
        """
        if recessive and most > 0 and _all_idle(clocks):
            self._let_begin(clocks, at_ns)
        self.sender = self.first_sender(clocks)
        if self.sender is not None:
            sender = self.sender.station
            if sender.index <= sender.layout.tail_bit + 1:
                bits = self._look_along(clocks, most)
                if bits > 0 or sender.index < sender.layout.tail_bit:
                    return bits
        return self._look_ahead(clocks, most)

    def _let_begin(self, clocks: list[Clock], at_ns: int) -> None:
        """Let the idle nodes begin a frame that are ready to send."""
        for clock in clocks:
            if clock.station.state == _IDLE and not clock.station.sof_seen:
                clock.station.now_ns = at_ns
                clock.station.offer()

    def first_sender(self, clocks: list[Clock]) -> Clock | None:
        """The clock of the node that will win among those that still contend; None if no node sends."""
        found = None
        for clock in clocks:
            if not clock.station.transmitting or clock.station.state != _FRAME:
                continue  # a local name for `clock.station` would cost a reference count in C
            if found is None or clock.station.sent.key < found.station.sent.key:
                found = clock
        return found

    # a frame as it is laid out

    def _look_along(self, clocks: list[Clock], most: int) -> int:
        """Up to the acknowledge if all nodes read alike, and to the end of the frame if none has to count it."""
        assert self.sender is not None
        lead = self.sender.station
        self._take(lead, lead.layout.heard)
        answered = False
        quiet = _TAIL_BITS
        for clock in clocks:
            station = clock.station
            if station.state == _FRAME and station.transmitting:
                most = self._agreed(station, most)
                if station is lead:
                    continue
                if station.sent.key == lead.sent.key:
                    quiet = _ACK_BIT  # neither of them acknowledges
            elif station.state == _WAITING:
                if not _can_wait(station):
                    return 0
                continue
            elif station.state != _FRAME and not self._receives_from_here(station):
                return 0
            if most <= 0:
                return 0
            answered = answered or _acknowledges(station)
            bits = _quiet_tail(station)
            if bits < quiet:
                quiet = bits
        bits = self._end(lead, quiet if answered else _ACK_BIT) - self.first
        return self._read_along(clocks, most if most < bits else bits)

    def _take(self, lead: Station, levels: bytes) -> None:
        self.level, self.levels = -1, levels
        self.first, self.tail = lead.index, lead.layout.tail_bit

    def _agreed(self, station: Station, most: int) -> int:
        """For how many bits a contender drives the same levels as the sender, or takes part without a report."""
        if station.index != self.first:
            return 0
        lost = self._loses_at(station, most)
        lead = self.sender.station  # type: ignore[union-attr]
        if lost < 0 or (station.sent.key > lead.sent.key and not _reports_loss(station)):
            return most
        return lost

    def _loses_at(self, station: Station, most: int) -> int:
        """The first of these bits at which a contender drives another level than the sender; -1 if none is."""
        if station is self.sender.station:  # type: ignore[union-attr]
            return -1
        bits = self.tail - self.first
        for k in range(bits if bits < most else most):
            if station.levels[self.first + k] != self.levels[self.first + k]:
                return k
        return -1

    def _receives_from_here(self, station: Station) -> bool:
        """Whether an idle node will receive this frame, and read it as its sender does."""
        lead = self.sender.station  # type: ignore[union-attr]
        if station.state != _IDLE or self.first != 0:
            return False
        node, reader = station.node, lead.reader
        if lead.layout.classic:
            return (node.fd == _NON_ISO) == (reader.fd_mode == _NON_ISO)
        return node.fd == reader.fd_mode and node.protocol_exception == reader.protocol_exception

    def _end(self, station: Station, quiet: int) -> int:
        """Where the rate changes, or the bits end of which `quiet` from the CRC delimiter on have no effect."""
        if station.layout.fast_bit >= self.first:
            return station.layout.fast_bit
        return station.layout.tail_bit + (0 if station.fast else quiet)

    def _read_along(self, clocks: list[Clock], most: int) -> int:
        """How many of the bits have no effect in any reader; readers in the sender's own state need no check."""
        assert self.sender is not None
        if most <= 0:
            return 0
        lead = self.sender.station
        scratch = self._scratch
        self._unlike = False
        for clock in clocks:
            station = clock.station
            reads = station is not lead and station.state == _FRAME
            if reads and not reader_state.alike(station.reader, lead.reader, lead.layout.classic):
                self._unlike = True
                reader_state.double(scratch, station.reader)
                most = scratch.take_run(self.levels, self.first, most)
        if self._unlike or (lead.reader.fd_mode == 0 and not lead.layout.classic):
            reader_state.double(scratch, lead.reader)
            most = scratch.take_run(self.levels, self.first, most)
        return most

    # one level

    def _look_ahead(self, clocks: list[Clock], most: int) -> int:
        level = 1
        for clock in clocks:
            if clock.station.state == _ACTIVE_FLAG or clock.station.state == _OVERLOAD_FLAG:
                level = 0
        self.level = level
        self._asked = None
        busy = False
        for clock in clocks:
            station = clock.station
            if station.finished or station.rejoined or most <= 0:
                return 0
            busy = busy or not station.resting()
            bits = self._in_frame(station, level) if station.state == _FRAME else _between(station, level)
            if bits < most:
                most = bits
        return most if busy and most > 0 else 0  # the bus may come to rest at the next bit

    def _in_frame(self, station: Station, level: int) -> int:
        """How many bits of this level a station in a frame can skip; after the CRC only an ACK slot has an effect."""
        reader = station.reader
        field = reader.field
        if field < _CRC_DELIMITER or reader.stuffing:
            return 0 if station.transmitting else self._bits_before_error(reader, level)
        if level == 0:
            return 0
        if field == _CRC_DELIMITER:
            return 0 if station.fast else 1
        if field == _ACK_DELIMITER:
            good = station.acknowledged if station.transmitting else reader.crc_ok
            return station.bits_till_valid(1 + _EOF_BITS) if good else 0
        return station.bits_till_valid(reader.left) if field == _EOF else 0

    def _bits_before_error(self, reader: FrameReader, level: int) -> int:
        """How many bits of this level a reader can skip before an error; readers in the same state share one answer."""
        if self._asked is None or not reader_state.alike(reader, self._asked, False):
            self._asked = reader
            reader_state.double(self._scratch, reader)
            self._answer = self._scratch.take_steady(level, _FEW)
        return self._answer

    # continuing

    def last_ps(self, began_ps: int, bits: int, clock: Clock) -> int:
        return began_ps + (bits - 1) * clock.bit_ps() + clock.sample_ps()

    def go(self, clocks: list[Clock], bits: int, at_ps: int, sampled_ns: int) -> None:
        """Advance all clocks by `bits` bits, the first of which began at `at_ps`; all take the last sample now."""
        if self.level < 0:
            self._read_on(clocks, bits)
        for clock in clocks:
            station = clock.station
            station.last_sample = self.level_of(bits - 1)
            station.rate_change = 0
            station.just_free = False
            station.now_ns = sampled_ns
            if self.level >= 0:
                clock.drive_steady(at_ps)
                _keep(station, self.level, bits)
            else:
                self._go_along(clock, bits, at_ps)
            clock.pass_bits(bits, at_ps)

    def _go_along(self, clock: Clock, bits: int, at_ps: int) -> None:
        station = clock.station
        if station.transmitting:
            lost = self._loses_at(station, bits)
            clock.drive_run(station.levels, self.first, bits if lost < 0 else lost + 1, at_ps)
            if lost >= 0:
                station.lose_silently()
        else:
            clock.drive_steady(at_ps)
        if station.state == _WAITING:
            self._count_recessive(station, bits)
        else:
            station.index += bits
            if self.first + bits > self.tail:
                self._go_to_the_end(clock, bits, at_ps)

    def _go_to_the_end(self, clock: Clock, bits: int, at_ps: int) -> None:
        """Put a station behind the CRC delimiter or a later bit of an acknowledged frame."""
        station = clock.station
        passed = self.first + bits - self.tail
        if self.first <= self.tail:
            station.acknowledging = not station.transmitting and not station.node.listen_only
        if passed > _ACK_BIT:
            at_ps += (self.tail + _ACK_BIT - self.first) * clock.bit_ps()
            if station.transmitting:
                station.acknowledged = True
            elif station.acknowledging:
                clock.answer(at_ps, passed > _ACK_BIT + 1)
        if passed == _TAIL_BITS:
            station.end_frame()

    def level_of(self, bit: int) -> int:
        """The level of the wire in this bit of the stretch."""
        return self.level if self.level >= 0 else self.levels[self.first + bit]

    def last_fall(self, wire: int, bits: int) -> int:
        """The last of these bits that begins with a falling edge of the wire, which was `wire`; -1 if none does."""
        at = bits - 1 if self.level < 0 else 0  # of equal levels only the first can be one
        while at > 0 and not (self.levels[self.first + at - 1] and self.levels[self.first + at] == 0):
            at -= 1
        return at if at > 0 or (wire and self.level_of(0) == 0) else -1

    def show(
        self,
        bits: int,
        at_ps: int,
        bit_ps: int,
        shown: int,
        capture: Callable[[int, int], None],
        capture_many: Callable[[list[int], int], None] | None,
    ) -> None:
        """Tell one of both of all changes in these bits, from `at_ps` on, of a wire that was `shown` before."""
        if capture_many is not None:
            times_ns = self._changes(bits, at_ps, bit_ps, shown, 1000)
            if times_ns:
                capture_many(times_ns, shown ^ 1)
            return
        for time_ps in self._changes(bits, at_ps, bit_ps, shown, 1):
            shown ^= 1
            capture(time_ps, shown)

    def _changes(self, bits: int, at_ps: int, bit_ps: int, shown: int, unit_ps: int) -> list[int]:
        """The times of all changes, in units of so many ps."""
        times = []
        for k in range(bits):
            if self.level_of(k) != shown:
                shown ^= 1
                times.append((at_ps + k * bit_ps) // unit_ps)
        return times

    def _read_on(self, clocks: list[Clock], bits: int) -> None:
        """Advance the readers: one of them reads for all that have read the same bits."""
        assert self.sender is not None
        lead = self.sender.station
        scratch = self._scratch
        reader_state.double(scratch, lead.reader)
        self._read_at_once(scratch, lead.layout, bits)
        for clock in clocks:
            station = clock.station
            if station.state == _IDLE:
                station.begin_receiving()
            if station is not lead and station.state == _FRAME:
                if not self._unlike or reader_state.alike(station.reader, lead.reader, lead.layout.classic):
                    reader_state.copy(station.reader, scratch)
                else:
                    station.reader.take_run(self.levels, self.first, bits)
        reader_state.copy(lead.reader, scratch)

    def _read_at_once(self, reader: FrameReader, layout: KeptLayout, bits: int) -> None:
        """Advance a reader, up to bits after the ACK slot; who knows its format reads its own layout."""
        passed = self.first + bits - self.tail
        if passed < 0:
            taken = reader.take_run(self.levels, self.first, bits)
            assert taken == bits
        elif self.first < self.tail:
            reader_state.finish(reader, layout)
        if passed > 0:
            reader_state.pass_tail(reader, passed)

    def _count_recessive(self, station: Station, bits: int) -> None:
        for k in range(self.first, self.first + bits):
            station.run = station.run + 1 if self.levels[k] else 0


def _all_idle(clocks: list[Clock]) -> bool:
    """Whether each node may begin a frame, or waits for as long as a frame takes."""
    for clock in clocks:
        if clock.station.state != _IDLE and not _can_wait(clock.station):
            return False
    return True


def _reports_loss(station: Station) -> bool:
    """Whether a lost arbitration is an observable event."""
    return station.node.attentive or station.sent.single_shot


def _acknowledges(station: Station) -> bool:
    """Whether a receiver acknowledges a good frame."""
    if station.state == _FRAME and station.reader.field > _CRC_DELIMITER:
        return station.acknowledging
    return not station.node.listen_only


def _quiet_tail(station: Station) -> int:
    """How many bits from the CRC delimiter on have no observable effect in a receiver of a good frame."""
    if station.counted or (station.node.tainted and not station.node.listen_only):
        return _ACK_BIT
    return _TAIL_BITS - _EOF_BITS + station.bits_till_valid(_EOF_BITS)


def _can_wait(station: Station) -> bool:
    """Whether the station waits for 11 recessive bits that cannot come in a frame."""
    waits = station.state == _WAITING and not station.rejoined and not station.node.edge_filter
    return waits and station.run + _FEW_BITS < _RECOVERED


def _between(station: Station, level: int) -> int:
    """For how many bits of this level a station outside a frame has nothing to report or to decide."""
    state = station.state
    if state == _ACTIVE_FLAG or state == _OVERLOAD_FLAG:
        return station.left
    if state == _PASSIVE_FLAG:
        return 0 if station.tec_due and level == 0 else _FEW - 1 - _counted(station, level)
    if state == _FLAG_WAIT:
        if level or (station.dominant_run == 0 and not station.transmitting and not station.overload):
            return 0
        return 7 - station.dominant_run % 8
    if state == _WAITING:
        if station.node.edge_filter:
            return 0
        return _RECOVERED - 1 - station.run if level else _LONG
    if level == 0:
        return 0
    if state == _DELIMITER or state == _INTERMISSION:
        return station.left
    if station.sof_seen:
        return 0
    if state == _SUSPEND:
        return station.left
    return _LONG if station.contending is None and station.node.offer is None else 0


def _counted(station: Station, level: int) -> int:
    """How many bits of this level in a row its passive error flag has seen."""
    return station.run if station.run and level == station.flag_level else 0


def _keep(station: Station, level: int, bits: int) -> None:
    """Advance the station by `bits` bits of this level."""
    state = station.state
    if state == _FRAME:
        if bits > 1 and station.reader.field > _CRC_DELIMITER:
            bits = _pass_tail(station, bits)
        for _ in range(bits):
            station.sample(level)
    elif state == _DELIMITER or state == _INTERMISSION:
        station.left -= bits - 1
        station.sample(level)
    elif state == _PASSIVE_FLAG:
        station.run = _counted(station, level) + bits
        station.flag_level = level
    elif state == _FLAG_WAIT:
        station.dominant_run += bits
    elif state == _WAITING:
        station.run = station.run + bits if level else 0
    elif state != _IDLE:
        station.left -= bits
        if station.left == 0 and (state == _ACTIVE_FLAG or state == _OVERLOAD_FLAG):
            station.state = _FLAG_WAIT


def _pass_tail(station: Station, bits: int) -> int:
    """Process all but the last of these recessive bits after the ACK slot; returns how many are left."""
    reader = station.reader
    if reader.field == _ACK_DELIMITER:
        station.sample(1)
        bits -= 1
    reader.value = reader.value << (bits - 1) | ((1 << (bits - 1)) - 1)
    reader.left -= bits - 1
    reader.last = 1
    station.index += bits - 1
    return 1
