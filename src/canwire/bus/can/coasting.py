# cython: nonecheck=False
"""Stretches of bits without any observable event, which bit_level.py processes in one step.

All clocks must be at the same bit boundary and run at the same rate, so that every edge comes where all of them
begin a bit anyway. Then either all nodes read the levels that one sender laid out, and one reader reads for all those
that have read the same bits; or the wire keeps its level until a flag, delimiter, field or count ends. bit_level.py
processes the bit where one ends, and all other bits that do not fit.
"""

from __future__ import annotations

from canwire.bus.can import reader_state
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
_EOF_BITS = 7
_FEW = 6  # no more equal bits are read in one step
_LONG = 1 << 20
_RECOVERED = 11  # recessive bits in a row
_FEW_BITS = 5  # as many equal ones as a frame has


class Stretch:
    """The next stretch of bits of one bus: `levels` from index `first` on, or `level` for all if it is not -1.

    `sender` is the clock of the node whose frame is read; None between frames.
    """

    def __init__(self) -> None:
        self.levels = b""
        self.first = 0
        self.level = -1
        self.sender: Clock | None = None
        self._scratch = FrameReader(0)
        self._unlike = False
        self._asked: FrameReader | None = None
        self._answer = 0

    def look(self, clocks: list[Clock], most: int) -> int:
        """The number of bits of the stretch, up to `most`; 0 if no stretch begins here."""
        self.sender = self.first_sender(clocks)
        if self.sender is not None:
            sender = self.sender.station
            if sender.index < sender.layout.tail_bit:
                return self._look_along(clocks, most)
        return self._look_ahead(clocks, most)

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
        assert self.sender is not None
        sender = self.sender.station
        self.level, self.levels, self.first = -1, sender.levels, sender.index
        for clock in clocks:
            station = clock.station
            if station.state == _FRAME:
                if station.transmitting:
                    most = self._agreed(station, most)
            elif not _can_wait(station):
                return 0
            if most <= 0:
                return 0
        return self._read_along(clocks, most)

    def _agreed(self, station: Station, most: int) -> int:
        """For how many bits a contender drives the same levels as the sender, at one rate."""
        layout = station.layout
        end = layout.tail_bit
        if layout.fast_bit >= self.first:
            end = layout.fast_bit
        if station.index != self.first:
            return 0
        if end - self.first < most:
            most = end - self.first
        if station is not self.sender.station:  # type: ignore[union-attr]
            for k in range(self.first, self.first + most):
                if station.levels[k] != self.levels[k]:
                    return k - self.first
        return most

    def _read_along(self, clocks: list[Clock], most: int) -> int:
        """How many of the bits have no effect in any reader; readers in the sender's own state need no check."""
        assert self.sender is not None
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
            if self.level < 0 and station.transmitting:
                clock.drive_run(self.levels, self.first, bits, at_ps)
            else:
                clock.drive_steady(at_ps)
            clock.pass_bits(bits, at_ps)
            station.last_sample = self.level_of(bits - 1)
            station.rate_change = 0
            station.just_free = False
            station.now_ns = sampled_ns
            if self.level >= 0:
                _keep(station, self.level, bits)
            elif station.state == _WAITING:
                self._count_recessive(station, bits)
            else:
                station.index += bits

    def level_of(self, bit: int) -> int:
        """The level of the wire in this bit of the stretch."""
        return self.level if self.level >= 0 else self.levels[self.first + bit]

    def last_fall(self, bits: int) -> int:
        """The index, below `bits`, of a bit after whose next one the wire has no falling edge."""
        if self.level >= 0:
            return 0
        at = bits - 1
        while at > 0 and not (self.levels[self.first + at - 1] and self.levels[self.first + at] == 0):
            at -= 1
        return at - 1 if at > 0 else 0

    def _read_on(self, clocks: list[Clock], bits: int) -> None:
        """Advance the readers: one of them reads for all that have read the same bits."""
        assert self.sender is not None
        lead = self.sender.station
        scratch = self._scratch
        reader_state.double(scratch, lead.reader)
        taken = scratch.take_run(self.levels, self.first, bits)
        assert taken == bits  # who knows its format reads its own layout
        for clock in clocks:
            station = clock.station
            if station is not lead and station.state == _FRAME:
                if not self._unlike or reader_state.alike(station.reader, lead.reader, lead.layout.classic):
                    reader_state.copy(station.reader, scratch)
                else:
                    station.reader.take_run(self.levels, self.first, bits)
        reader_state.copy(lead.reader, scratch)

    def _count_recessive(self, station: Station, bits: int) -> None:
        for k in range(self.first, self.first + bits):
            station.run = station.run + 1 if self.levels[k] else 0


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
    if state == _FRAME or state == _DELIMITER or state == _INTERMISSION:
        if bits > 1 and state == _FRAME and station.reader.field > _CRC_DELIMITER:
            bits = _pass_tail(station, bits)
        for _ in range(bits):
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
