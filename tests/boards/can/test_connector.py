"""A CAN connector as its clients see it: states, what it says of itself, stopping, resetting, finding a bit rate."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from canwire import (
    BadTiming,
    BadValue,
    BitTiming,
    BusEvent,
    CanwireError,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    LineError,
    NothingHeard,
    NotInitialised,
    Unplugged,
    Unsupported,
    WrongState,
)
from canwire.boards import figures
from canwire.boards.board import CAN, BoardLine
from canwire.boards.can.channel import Channel
from canwire.boards.can.connector import CanLine
from canwire.boards.can.line import Line
from canwire.boards.can.modes import FilterMode, FilterSetup, LineMode
from canwire.boards.catalogue import ideal_line, plug, unplug
from canwire.boards.description import Capabilities, Feature, LineInfo
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.drivers.driver import LineSettings
from canwire.timeline import NEVER, Timeline
from canwire.values.event import InfoCode
from canwire.values.frame import frame_of_record
from canwire.values.timing.limits import BTR_OF_BIT_RATE
from tests.cases import each

NOMINAL = BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
DATA = BitTiming.for_bit_rate(5_000_000, clock_hz=80_000_000)
CLASSIC = LineMode(NOMINAL)
FD = LineMode(NOMINAL, DATA, long_data=True)
SECOND_NS = 1_000_000_000
EVERYTHING = frozenset({EventKind.INFO, EventKind.ERROR, EventKind.STATE, EventKind.TIME_OVERRUN})
RATES = sorted(BTR_OF_BIT_RATE, reverse=True)
TABLE = [(BitTiming.from_btr(*BTR_OF_BIT_RATE[rate]), None) for rate in RATES]


class Bench:
    """A line of a board, not yet initialised, and other nodes on its bus that are at work already."""

    def __init__(
        self, capabilities: Capabilities = figures.USB_TO_CAN_FD, timing: BitTiming = NOMINAL
    ) -> None:
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.faults = Faults(self.bus, seed=0)
        self.timing = timing
        line = ideal_line("HW000001:0", self.timeline)
        plug(line, self.bus)
        self.can = CanLine(BoardLine(LineInfo("CAN-1", "can0", CAN, capabilities), line, self.bus))
        self.other = self.node("other")
        self.listener = self.other.open(Channel(1 << 14, 1 << 10, events=EVERYTHING))
        self.outcomes: list[int | CanwireError] = []

    def node(self, name: str) -> Line:
        line = ideal_line(name, self.timeline)
        plug(line, self.bus)
        assert line.driver is not None
        line.driver.configure(LineSettings(self.timing, DATA))
        line.driver.start(0, integrated=True)
        return line

    def channel(self, **options: Any) -> Channel:
        return self.can.line.open(Channel(64, 64, **{"events": EVERYTHING, **options}))

    def done(self, outcome: int | CanwireError) -> None:
        self.outcomes.append(outcome)

    def initialise(self, mode: LineMode = CLASSIC) -> None:
        self.can.initialise(mode, self.done)
        assert self.outcomes == [0]
        self.outcomes.clear()

    def start(self, mode: LineMode = CLASSIC) -> None:
        """Initialised and started, and on the bus by now."""
        self.initialise(mode)
        self.can.start()
        self.run(0.001)

    def run(self, seconds: float = 1.0) -> None:
        self.timeline.run_until(self.timeline.now_ns + round(seconds * SECOND_NS))

    def stop(self) -> None:
        self.can.stop(self.done)
        self.run(0.01)
        assert self.outcomes == [0]
        self.outcomes.clear()

    def heard(self) -> list[int]:
        """Identifiers of the frames that the other node has received."""
        return [frame.id for frame in frames(self.listener)]


def records(channel: Channel) -> list[bytes]:
    found = []
    while (block := channel.receive.take_bytes()) is not None:
        found.append(block)
    return found


def frames(channel: Channel) -> list[Frame]:
    return [frame_of_record(block) for block in records(channel) if block[12] == 0]


def events(channel: Channel) -> list[BusEvent]:
    return [BusEvent.from_record(block) for block in records(channel) if block[12]]


def kinds(channel: Channel) -> list[tuple[EventKind, int]]:
    """Kind and code (of infos) or state (of states)."""
    return [
        (event.kind, event.state if event.kind is EventKind.STATE else event.code)
        for event in events(channel)
    ]


# states


@pytest.mark.conforms("X3-09")
def test_undefined_then_stopped_then_running_then_stopped_then_undefined() -> None:
    bench = Bench()
    can = bench.can
    assert (can.mode, can.running) == (None, False)
    bench.initialise()
    assert (can.mode, can.running) == (CLASSIC, False)
    can.start()
    assert (can.mode, can.running) == (CLASSIC, True)
    bench.stop()
    assert (can.mode, can.running) == (CLASSIC, False)
    can.start()
    assert can.running
    can.reset()
    assert (can.mode, can.running) == (None, False)


@pytest.mark.conforms("X3-09")
def test_what_needs_an_initialised_line() -> None:
    bench = Bench()
    for _ in range(2):
        with pytest.raises(NotInitialised, match="HW000001:0: initialise the line before it is started"):
            bench.can.start()
        with pytest.raises(NotInitialised, match="HW000001:0: a line has filters once it is initialised"):
            bench.can.format_filter(False)
        assert not bench.can.running
        bench.initialise()
        bench.can.reset()


def test_what_changes_nothing() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.can.stop(bench.done)
    assert bench.outcomes == [0]
    bench.outcomes.clear()
    bench.start()
    records(channel)
    bench.can.start()
    assert records(channel) == []
    bench.stop()
    records(channel)
    bench.stop()
    assert records(channel) == []


def test_initialised_anew_in_the_middle_of_everything() -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel()
    bench.can.line.send(channel, Frame(1, bytes(8)))
    bench.can.line.send(channel, Frame(2))
    bench.run(30e-6)
    bench.initialise(FD)
    assert (bench.can.mode, bench.can.running) == (FD, False)
    assert channel.aborted == 1
    bench.can.start()
    bench.run()
    assert bench.heard() == [2]


@pytest.mark.parametrize(
    "mode",
    [
        LineMode(NOMINAL, standard=False, extended=False),
        LineMode(None, DATA),
        LineMode(NOMINAL, low_speed=True),
        LineMode(NOMINAL, timeout_ms=-1),
        LineMode(NOMINAL, timeout_ms=1 << 62),
        LineMode(NOMINAL, standard_filter=FilterSetup(FilterMode.VOID)),
        LineMode(NOMINAL, extended_filter=FilterSetup(FilterMode.PASS, -1)),
        LineMode(NOMINAL, extended_filter=FilterSetup(FilterMode.PASS, 1 << 40)),
        LineMode(BitTiming(65536, 65536, 65536, 1, clock_hz=1)),
        LineMode(BitTiming(1, 1, 1, 1, clock_hz=10**10)),
        LineMode(NOMINAL, BitTiming(1, 1, 1, 1, clock_hz=10**10)),
    ],
)
def test_a_mode_that_is_refused_changes_nothing(mode: LineMode) -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel()
    with pytest.raises(CanwireError):
        bench.can.initialise(mode, bench.done)
    assert (bench.can.mode, bench.can.running, bench.outcomes) == (CLASSIC, True, [])
    bench.other.send(bench.listener, Frame(1))
    bench.run()
    assert [frame.id for frame in frames(channel)] == [1]


# what a board cannot do


@pytest.mark.conforms("X4-15")
@each(
    ("feature", "mode"),
    [
        (Feature.LISTEN_ONLY, replace(CLASSIC, listen_only=True)),
        (Feature.ERROR_FRAMES, replace(CLASSIC, error_frames=True)),
        (Feature.STANDARD_AND_EXTENDED, CLASSIC),
        (Feature.AUTO_BAUD, replace(CLASSIC, timing=None)),
        (Feature.EXTENDED_DATA, replace(CLASSIC, long_data=True)),
        (Feature.FAST_DATA, replace(CLASSIC, data_timing=DATA)),
        (Feature.NON_ISO_FRAME, replace(CLASSIC, iso_fd=False)),
    ],
)
def test_a_missing_feature_is_refused_by_name(feature: Feature, mode: LineMode) -> None:
    able = figures.USB_TO_CAN_FD
    unable = replace(able, features=able.features & ~feature)
    assert feature.name is not None
    with pytest.raises(Unsupported, match=rf"HW000001:0 \(CAN-1\) has no {feature.name}"):
        Bench(unable).can.initialise(mode, lambda _: None)
    Bench(able).can.initialise(mode, lambda _: None)


@pytest.mark.conforms("X4-15")
def test_one_format_is_enough_for_a_board_that_cannot_do_both() -> None:
    unable = replace(
        figures.USB_TO_CAN, features=figures.USB_TO_CAN.features & ~Feature.STANDARD_AND_EXTENDED
    )
    for extended in (False, True):
        bench = Bench(unable)
        bench.start(replace(CLASSIC, standard=not extended, extended=extended))
        assert bench.can.running


@pytest.mark.conforms("X4-15")
def test_a_search_needs_its_features_too() -> None:
    bench = Bench(figures.USB_TO_CAN)
    for candidates, iso_fd, missing in (
        ([(NOMINAL, DATA)], True, "FAST_DATA"),
        ([(NOMINAL, None)], False, "NON_ISO_FRAME"),
    ):
        with pytest.raises(Unsupported, match=f"has no {missing}"):
            bench.can.detect(candidates, 100, iso_fd, bench.done)
    with pytest.raises(Unsupported, match="no low-speed coupling"):
        Bench(figures.USB_TO_CAN_FD).can.detect(TABLE, 100, True, bench.done, low_speed=True)
    assert bench.outcomes == []


def test_neither_format_is_no_mode() -> None:
    with pytest.raises(LineError, match="11-bit frames, 29-bit frames, or both"):
        Bench().can.initialise(replace(CLASSIC, standard=False, extended=False), lambda _: None)


@pytest.mark.conforms("X4-17")
@each(
    ("mode", "fd", "long_data", "fast_data"),
    [
        (CLASSIC, 0, False, False),
        (replace(CLASSIC, long_data=True), 1, True, False),
        (replace(CLASSIC, data_timing=DATA), 1, False, True),
        (FD, 1, True, True),
        (replace(FD, iso_fd=False), 2, True, True),
    ],
)
def test_the_modes_of_fd_are_apart(mode: LineMode, fd: int, long_data: bool, fast_data: bool) -> None:
    bench = Bench()
    bench.initialise(mode)
    line = bench.can.line
    assert (line.controller.fd, line.long_data, line.fast_data) == (fd, long_data, fast_data)


# low speed


@pytest.mark.conforms("X4-43")
def test_low_speed_needs_the_coupling_and_a_low_rate() -> None:
    slow = BitTiming.from_btr(*BTR_OF_BIT_RATE[125_000])
    with pytest.raises(Unsupported, match="no low-speed coupling"):
        Bench(figures.USB_TO_CAN_FD).can.initialise(LineMode(slow, low_speed=True), lambda _: None)
    bench = Bench(figures.USB_TO_CAN, slow)
    with pytest.raises(BadTiming, match="1000000 bit/s: low-speed coupling goes from 10 to 125000"):
        bench.can.initialise(LineMode(NOMINAL, low_speed=True), lambda _: None)
    bench.initialise(LineMode(slow, low_speed=True))


@pytest.mark.conforms("X4-43")
def test_a_fault_tolerant_transceiver_reports_a_fault_of_its_wires() -> None:
    slow = BitTiming.from_btr(*BTR_OF_BIT_RATE[125_000])
    bench = Bench(figures.USB_TO_CAN, slow)
    bench.start(LineMode(slow, low_speed=True))
    assert not bench.can.coupling_fault
    bench.bus.short(True)
    assert bench.can.coupling_fault
    bench.bus.short(False)
    assert not bench.can.coupling_fault
    bench.initialise(LineMode(slow))
    bench.bus.short(True)
    assert not bench.can.coupling_fault  # a high-speed one cannot tell


# what a line says of itself


@pytest.mark.conforms("X4-30", "X4-31")
def test_starting_and_stopping_is_told_to_every_channel() -> None:
    bench = Bench()
    one, other = bench.channel(), bench.channel(frames=False)
    bench.run(0.5)
    bench.initialise()
    assert records(one) == []
    bench.can.start()
    started_ns = bench.timeline.now_ns
    bench.run(0.25)
    bench.stop()
    stopped_ns = started_ns + SECOND_NS // 4
    expected = [
        (EventKind.INFO, InfoCode.STARTED, started_ns),
        (EventKind.STATE, ErrorState.ERROR_ACTIVE, started_ns),
        (EventKind.INFO, InfoCode.STOPPED, 0),
        (EventKind.STATE, ErrorState.STOPPED, stopped_ns),
    ]
    for channel in (one, other):
        told = [
            (event.kind, event.code if event.kind is EventKind.INFO else event.state, event.timestamp_ns)
            for event in events(channel)
        ]
        assert told == expected


@pytest.mark.conforms("X4-30")
def test_a_start_is_stamped_with_the_time_since_the_first_one() -> None:
    """STOP and RESET have the time 0; a reset begins the counting anew."""
    bench = Bench()
    channel = bench.channel()
    channel.tick_ns = 1_000
    times = []
    for action in (bench.initialise, bench.can.start, bench.stop, bench.can.start, bench.can.reset,
                   bench.initialise, bench.can.start):  # fmt: skip
        bench.run(0.5)
        action()
        times += [
            (event.code, event.timestamp_ns) for event in events(channel) if event.kind is EventKind.INFO
        ]
    assert times == [
        (InfoCode.STARTED, 0),
        (InfoCode.STOPPED, 0),
        (InfoCode.STARTED, 1_010_000),
        (InfoCode.RESET, 0),
        (InfoCode.STARTED, 0),
    ]


@pytest.mark.conforms("X4-30", "X4-31", "X4-29")
def test_their_bytes() -> None:
    """VCI V4 manual 7.3.14: type in the info word, what happened in abData[0], the status byte beside an error."""
    bench = Bench()
    channel = bench.channel(frames=False)
    bench.start(replace(CLASSIC, error_frames=True))
    bench.faults.flip(frame_id=5, bit="ack", times=1, seen_by="sender")
    bench.other.send(bench.listener, Frame(5))
    bench.run(0.01)
    bench.stop()
    bench.can.reset()
    shown = [(block[8:12], block[12], block[15], block[16:18]) for block in records(channel)]
    no_id, info, error, status = b"\xff" * 4, 1, 2, 3
    assert shown == [
        (no_id, info, 0xFF, b"\x01\x10"),  # started; at that moment it was not yet running
        (no_id, status, 0xFF, b"\x00\x00"),
        (no_id, error, 0xFF, bytes([ErrorKind.FORM, 0])),
        (no_id, info, 0xFF, b"\x02\x10"),
        (no_id, status, 0xFF, b"\x10\x10"),  # ININIT
        (no_id, info, 0xFF, b"\x03\x10"),
    ]


@pytest.mark.conforms("X4-29")
@pytest.mark.parametrize("wanted", [False, True])
def test_errors_are_told_where_the_mode_asks_for_them(wanted: bool) -> None:
    bench = Bench()
    channel = bench.channel()
    bench.start(replace(CLASSIC, error_frames=wanted))
    bench.faults.flip(frame_id=5, bit="crc delimiter", times=1)
    bench.other.send(bench.listener, Frame(5))
    bench.run(0.01)
    errors = [event for event in events(channel) if event.kind is EventKind.ERROR]
    assert [event.error for event in errors] == [ErrorKind.FORM] * wanted
    assert bench.can.line.controller.errors == 1  # counted either way


@pytest.mark.conforms("X4-31")
def test_every_change_of_state_is_told() -> None:
    """Alone on its bus a sender comes to the limit and turns passive; shorted, it goes off the bus."""
    bench = Bench()
    channel = bench.channel(frames=False, events=frozenset({EventKind.STATE}))
    unplug(bench.other)
    bench.start()
    bench.can.line.send(channel, Frame(1))
    bench.run(0.1)
    bench.bus.short(True)
    bench.run(0.1)
    bench.can.reset()
    seen = [(event.state, event.to_record()[16]) for event in events(channel)]
    assert seen == [
        (ErrorState.ERROR_ACTIVE, 0),
        (ErrorState.ERROR_WARNING, 5),  # TXPEND: the frame waits for its acknowledge
        (ErrorState.ERROR_PASSIVE, 5),
        (ErrorState.BUS_OFF, 13),
        (ErrorState.STOPPED, 17),
    ]


def test_what_does_not_change_is_not_told() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.initialise()
    bench.initialise()
    bench.can.reset()
    bench.can.reset()
    assert kinds(channel) == [(EventKind.INFO, InfoCode.RESET)] * 3  # the second initialise resets, too


# the counter behind the stamps


@pytest.mark.conforms("X3-34", "X4-31")
def test_each_overrun_of_the_stamps_is_told_with_their_number() -> None:
    bench = Bench()
    channel = bench.channel(frames=False, events=frozenset({EventKind.TIME_OVERRUN}))
    channel.tick_ns = bench.can.info.capabilities.stamps.tick_ns
    assert channel.tick_ns == 1_000
    bench.run(5)
    bench.initialise()
    bench.can.start()
    begun_ns = bench.timeline.now_ns
    overrun_ns = (1 << 32) * 1_000
    bench.timeline.run_until(begun_ns + overrun_ns - 1)
    assert events(channel) == []
    bench.timeline.run_until(begun_ns + overrun_ns)
    told = records(channel)
    assert [(block[12], block[:8], block[8:12]) for block in told] == [
        (5, bytes(8), (1).to_bytes(4, "little"))  # dwMsgId: how many overruns
    ]
    bench.stop()  # it goes on counting
    bench.timeline.run_until(begun_ns + 2 * overrun_ns)
    assert len(records(channel)) == 1
    bench.can.reset()
    bench.timeline.run_until(begun_ns + 4 * overrun_ns)
    assert records(channel) == []


def test_the_counter_keeps_no_timeline_busy() -> None:
    bench = Bench()
    bench.start()
    assert bench.timeline.idle()
    bench.can.reset()
    assert bench.timeline.next_ns() == NEVER


# stopping


@pytest.mark.conforms("X3-13")
@each("after_us", [5, 30, 100, 140])
def test_stopping_waits_for_the_frame_on_the_wire(after_us: int) -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel()
    for id in (1, 2, 3):
        bench.can.line.send(channel, Frame(id, bytes(8)))
    bench.run(after_us * 1e-6)
    bench.can.stop(bench.done)
    begun = after_us <= 130
    assert bench.outcomes == ([] if begun else [0]) or not begun
    bench.run()
    assert bench.outcomes == [0]
    assert not bench.can.running
    sent = bench.heard()
    assert sent in ([1], [1, 2])
    assert bench.other.controller.errors == 0
    assert channel.pending() == 3 - len(sent)


@pytest.mark.conforms("X3-15", "X3-13")
def test_what_waits_is_kept_and_goes_out_after_the_next_start() -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel(events=frozenset())
    bench.other.send(bench.listener, Frame(0x10))
    bench.run(0.001)
    for id in (1, 2, 3):
        bench.can.line.send(channel, Frame(id))
    bench.run(20e-6)
    bench.stop()
    bench.run()
    assert bench.heard() == [1]
    assert channel.receive.fill() == 1
    assert (channel.aborted, channel.pending()) == (0, 2)
    bench.can.start()
    bench.run()
    assert bench.heard() == [2, 3]
    assert [frame.id for frame in frames(channel)] == [0x10]


def test_stopping_while_others_send() -> None:
    bench = Bench()
    bench.node("third")
    bench.start()
    channel = bench.channel(events=frozenset())
    for id in range(3):
        bench.other.send(bench.listener, Frame(id, bytes(8)))
    bench.can.line.send(channel, Frame(0x100))
    bench.run(30e-6)
    bench.can.stop(bench.done)
    bench.run(5e-6)
    assert bench.outcomes == [0]
    bench.run()
    assert bench.other.controller.errors == 0
    assert channel.pending() == 1


@each("trouble", ["alone", "shorted", "noise"])
def test_stopping_ends_on_a_bus_where_nothing_gets_through(trouble: str) -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel()
    if trouble == "alone":
        unplug(bench.other)
    elif trouble == "shorted":
        bench.bus.short(True)
    else:
        bench.faults.flip(frame_id=1, bit=20, times=None)
    for _ in range(5):
        bench.can.line.send(channel, Frame(1))
    bench.run(0.0501)
    bench.can.stop(bench.done)
    bench.run(0.01)
    assert bench.outcomes == [0]
    assert not bench.can.running


@pytest.mark.conforms("X3-19")
def test_a_stopped_line_hears_nothing_and_nothing_is_delivered_later() -> None:
    bench = Bench()
    bench.node("third")
    channel = bench.channel(events=frozenset())
    bench.other.send(bench.listener, Frame(1))
    bench.run(0.001)
    bench.start()
    bench.other.send(bench.listener, Frame(2))
    bench.run(0.001)
    bench.stop()
    bench.other.send(bench.listener, Frame(3))
    bench.run(0.001)
    bench.can.start()
    bench.run(0.001)
    assert [frame.id for frame in frames(channel)] == [2]


# resetting


@pytest.mark.conforms("X3-14", "X3-15")
def test_a_reset_breaks_the_frame_on_the_wire_and_keeps_the_queues() -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel(events=frozenset())
    bench.other.send(bench.listener, Frame(0x10))
    bench.run(0.001)
    for id in (1, 2, 3):
        bench.can.line.send(channel, Frame(id, bytes(8)))
    bench.run(50e-6)
    bench.can.reset()
    assert (bench.can.mode, bench.can.running) == (None, False)
    bench.run()
    assert bench.heard() == []
    assert bench.other.controller.errors == 1
    assert channel.receive.fill() == 1
    assert (channel.aborted, channel.delivered, channel.pending()) == (1, 0, 2)
    bench.start()
    bench.run()
    assert bench.heard() == [2, 3]


@pytest.mark.conforms("X3-14", "X3-28")
def test_a_reset_empties_lists_and_puts_modes_back() -> None:
    bench = Bench()
    mode = replace(
        CLASSIC,
        standard_filter=FilterSetup(FilterMode.INCLUSIVE),
        extended_filter=FilterSetup(FilterMode.EXCLUSIVE),
    )
    bench.initialise(mode)
    standard = bench.can.format_filter(False)
    standard.set_pattern(0x80000000, 0xFFFFFFFF)
    standard.add(0x200, 0xFFF)
    standard.mode = FilterMode.LOCK
    bench.can.reset()
    with pytest.raises(NotInitialised):
        bench.can.format_filter(False)
    bench.start(mode)
    assert bench.can.format_filter(False).mode == FilterMode.INCLUSIVE
    assert bench.can.format_filter(True).mode == FilterMode.EXCLUSIVE
    assert bench.can.format_filter(False).listed == set()
    channel = bench.channel(events=frozenset())
    for id, extended in ((0x100, False), (0x101, False), (5, True)):
        bench.other.send(bench.listener, Frame(id, extended=extended))
    bench.run()
    assert [frame.id for frame in frames(channel)] == [0x100, 0x101, 5]


def both_modes(bench: Bench, kin: str = "") -> tuple[int, int] | None:
    """The filter modes that a program of this kin reads, of 11-bit and 29-bit frames; None if it reads none."""
    try:
        return bench.can.filter_mode(False, kin), bench.can.filter_mode(True, kin)
    except NotInitialised:
        return None


def with_filters(kin: str, standard: FilterMode, extended: FilterMode) -> LineMode:
    return replace(
        CLASSIC, kin=kin, standard_filter=FilterSetup(standard), extended_filter=FilterSetup(extended)
    )


def test_after_a_reset_a_program_reads_the_filter_modes_of_its_own_initialisation() -> None:
    bench = Bench()
    bench.initialise(with_filters("one", FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE))
    bench.can.format_filter(False, "one").mode = FilterMode.LOCK
    assert both_modes(bench, "one") == (FilterMode.LOCK, FilterMode.EXCLUSIVE)
    bench.can.reset("one")
    for _ in range(2):
        assert both_modes(bench, "one") == (FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE)
        bench.can.reset("one")  # once more changes nothing
    assert both_modes(bench, "other") is None
    bench.initialise(with_filters("one", FilterMode.PASS, FilterMode.LOCK))
    assert both_modes(bench, "one") == (FilterMode.PASS, FilterMode.LOCK)
    bench.can.reset("one")
    assert both_modes(bench, "one") == (FilterMode.PASS, FilterMode.LOCK)


def test_a_program_that_never_set_the_line_up_reads_no_filter_modes_after_its_reset() -> None:
    bench = Bench()
    bench.initialise(with_filters("one", FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE))
    bench.can.annotate(b"a note, and no filter", "other")
    bench.can.reset("other")
    assert both_modes(bench, "other") is both_modes(bench, "one") is both_modes(bench) is None


def test_filter_modes_from_before_a_program_set_the_line_up_anew_are_never_read_again() -> None:
    bench = Bench()
    bench.initialise(with_filters("one", FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE))
    bench.can.reset("one")
    bench.initialise(with_filters("one", FilterMode.PASS, FilterMode.LOCK))
    bench.can.reset("other")
    assert both_modes(bench, "one") is None


@each("leave", ["release", "abandon"])
def test_whoever_leaves_a_line_leaves_no_filter_modes_to_read(leave: str) -> None:
    bench = Bench()
    bench.initialise(with_filters("one", FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE))
    if leave == "release":
        bench.can.release({"one"})
        assert both_modes(bench, "one") == (FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE)
        bench.can.release(set())
        assert both_modes(bench, "one") == both_modes(bench, "other")  # as if it had set nothing
        bench.can.reset()
    else:
        bench.can.reset("one")
        bench.can.abandon()
    assert both_modes(bench, "one") is None


@pytest.mark.conforms("X3-13")
def test_a_stop_keeps_the_filters() -> None:
    bench = Bench()
    bench.start()
    bench.stop()
    bench.can.format_filter(False).set_pattern(0x200, 0xFFF)
    bench.can.start()
    bench.stop()
    bench.can.start()
    bench.run(0.001)
    channel = bench.channel(events=frozenset())
    for id in (0xFF, 0x100, 0x101):
        bench.other.send(bench.listener, Frame(id))
    bench.run()
    assert [frame.id for frame in frames(channel)] == [0x100]


@pytest.mark.parametrize("extended", [False, True])
def test_a_format_that_is_not_wanted_does_not_come_in(extended: bool) -> None:
    bench = Bench()
    bench.start(replace(CLASSIC, standard=extended, extended=not extended))
    channel = bench.channel(events=frozenset())
    for other in (False, True):
        bench.other.send(bench.listener, Frame(1, extended=other))
    bench.run()
    assert [frame.extended for frame in frames(channel)] == [not extended]


def test_no_list_means_no_filter_whatever_its_mode() -> None:
    """VCI V4 manual 7.3.7, dwSFIds and dwEFIds."""
    bench = Bench()
    setup = FilterSetup(FilterMode.LOCK, 0)
    bench.initialise(replace(CLASSIC, standard_filter=setup, extended_filter=setup))
    assert bench.can.format_filter(False).mode == bench.can.format_filter(True).mode == FilterMode.PASS


def test_a_reset_ends_a_stop_that_waits() -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel()
    bench.can.line.send(channel, Frame(1, bytes(8)))
    bench.run(30e-6)
    bench.can.stop(bench.done)
    assert bench.outcomes == []
    bench.can.reset()
    assert bench.outcomes == [0]
    bench.outcomes.clear()
    bench.start()
    bench.run()
    assert (bench.outcomes, bench.can.running) == ([], True)
    bench.can.line.send(channel, Frame(2))
    bench.run()
    assert bench.heard() == [2]  # it holds back nothing any more


@pytest.mark.conforms("X3-35")
def test_a_board_that_goes_keeps_nobody_waiting() -> None:
    bench = Bench()
    bench.can.detect(TABLE, 1000, True, bench.done)
    gone = Unplugged("it was pulled out")
    bench.can.close(gone)
    assert bench.outcomes == [gone]
    assert len(bench.bus.nodes) == 2


# finding a bit rate


class Traffic:
    """Two nodes that talk at a rate: `gap_bits` between their frames, or as quickly as the bus goes."""

    def __init__(self, rate: int, gap_bits: int, *, fd: bool = False) -> None:
        self.timing = BitTiming.from_btr(*BTR_OF_BIT_RATE[rate])
        self.bench = Bench(figures.USB_TO_CAN_FD if fd else figures.USB_TO_CAN, self.timing)
        self.peer = self.bench.node("peer")
        self.peers = self.peer.open(Channel(1 << 14, 64, events=EVERYTHING))
        self.gap_ns = gap_bits * SECOND_NS // rate
        self.number = 0
        self.turn()

    def turn(self) -> None:
        """The two in turn; with no gap there is always one more frame waiting."""
        self.number += 1
        line, channel = (
            (self.bench.other, self.bench.listener) if self.number % 2 else (self.peer, self.peers)
        )
        if channel.transmit.fill() < 2:
            line.send(channel, Frame(self.number & 0x7FF, self.number.to_bytes(4, "little")))
        at_ns = self.bench.timeline.now_ns + max(self.gap_ns, 60 * SECOND_NS // self.timing.bit_rate)
        self.bench.timeline.at(at_ns, self.turn, background=True)

    def state(self) -> list[tuple[int, ...]]:
        return [line.controller.counters()[:4] for line in (self.bench.other, self.peer)]

    def received(self) -> list[bytes]:
        return records(self.bench.listener) + records(self.peers)


@pytest.mark.conforms("X3-12", "X4-22", "X3-11")
@each("gap_bits", [0, 400])
@each("rate", RATES)
def test_the_rate_of_a_running_bus_is_found_and_nobody_notices(rate: int, gap_bits: int) -> None:
    searched, left_alone = Traffic(rate, gap_bits), Traffic(rate, gap_bits)
    searched.bench.can.detect(TABLE, 1000, True, searched.bench.done)
    while not searched.bench.outcomes:
        searched.bench.run(0.01)
    assert [RATES[index] for index in searched.bench.outcomes] == [rate]  # type: ignore[index]
    left_alone.bench.timeline.run_until(searched.bench.timeline.now_ns)
    assert searched.state() == left_alone.state() == [(0, 0, ErrorState.ERROR_ACTIVE, 0)] * 2
    assert searched.received() == left_alone.received()
    assert len(searched.bench.bus.nodes) == 3
    assert (searched.bench.can.mode, searched.bench.can.running) == (None, False)


@pytest.mark.conforms("X3-12", "X4-22")
def test_the_first_place_of_a_rate_that_stands_there_twice() -> None:
    traffic = Traffic(250_000, 100)
    table = [TABLE[RATES.index(rate)] for rate in (1_000_000, 250_000, 10_000, 250_000)]
    traffic.bench.can.detect(table, 100, True, traffic.bench.done)
    traffic.bench.run(1)
    assert traffic.bench.outcomes == [1]


@pytest.mark.conforms("X3-12", "X4-22")
def test_a_silent_bus_is_listened_to_for_the_time_given_to_each_rate() -> None:
    bench = Bench(figures.USB_TO_CAN)
    bench.can.detect(TABLE[:4], 100, True, bench.done)
    bench.run(0.399_999)
    assert bench.outcomes == []
    bench.run(0.000_002)
    (outcome,) = bench.outcomes
    assert isinstance(outcome, NothingHeard)
    assert str(outcome) == "HW000001:0: no frame at any of these bit rates: 1000000, 800000, 500000, 250000"
    assert len(bench.bus.nodes) == 2


@pytest.mark.conforms("X3-12", "X4-22")
def test_a_rate_that_is_not_in_the_table_is_not_found() -> None:
    traffic = Traffic(500_000, 50)
    table = [pair for rate, pair in zip(RATES, TABLE, strict=True) if rate != 500_000]
    traffic.bench.can.detect(table, 50, True, traffic.bench.done)
    traffic.bench.run(5)
    assert [type(outcome) for outcome in traffic.bench.outcomes] == [NothingHeard]
    assert traffic.state() == [(0, 0, ErrorState.ERROR_ACTIVE, 0)] * 2


@pytest.mark.conforms("X4-22")
def test_a_pair_of_rates_is_found_as_a_whole() -> None:
    """CANBTPTABLE: nominal and data rate together."""
    bench = Bench()
    bench.node("third")
    other = BitTiming.for_bit_rate(2_000_000, clock_hz=80_000_000)
    for k in range(200):
        frame = Frame(k, bytes(16), fd=True, bit_rate_switch=True)
        bench.timeline.at(k * 1_000_000, lambda frame=frame: bench.other.send(bench.listener, frame))  # type: ignore[misc]
    bench.can.detect([(NOMINAL, other), (NOMINAL, DATA)], 50, True, bench.done)
    bench.run(0.2)
    assert bench.outcomes == [1]
    assert bench.other.controller.errors == 0


def test_one_search_at_a_time_and_none_while_running() -> None:
    bench = Bench()
    bench.can.detect(TABLE, 100, True, bench.done)
    with pytest.raises(WrongState, match="stop the line"):
        bench.can.detect(TABLE, 100, True, bench.done)
    bench.can.reset()
    (outcome,) = bench.outcomes
    assert isinstance(outcome, NothingHeard)
    assert "ended" in str(outcome)
    bench.outcomes.clear()
    bench.start()
    with pytest.raises(WrongState, match="stop the line"):
        bench.can.detect(TABLE, 100, True, bench.done)
    assert len(bench.bus.nodes) == 2


@pytest.mark.parametrize(
    ("candidates", "timeout_ms", "error"),
    [
        ([], 100, BadValue),
        (TABLE, -1, BadValue),
        (TABLE, 1 << 62, BadValue),
        ([(BitTiming(65536, 65536, 65536, 1, clock_hz=1), None)], 100, BadTiming),
    ],
)
def test_a_search_that_makes_no_sense(
    candidates: list[tuple[BitTiming, BitTiming | None]], timeout_ms: int, error: type[Exception]
) -> None:
    bench = Bench()
    with pytest.raises(error):
        bench.can.detect(candidates, timeout_ms, True, bench.done)
    assert (bench.outcomes, len(bench.bus.nodes)) == ([], 2)
    bench.can.detect(TABLE[:1], 10, True, bench.done)  # it can still search
    bench.run(0.1)
    assert len(bench.outcomes) == 1


# a line that finds its rate itself


@pytest.mark.conforms("X4-23")
@each("rate", [1_000_000, 125_000, 10_000])
def test_auto_baud_initialises_at_the_rate_of_the_bus(rate: int) -> None:
    traffic = Traffic(rate, 100)
    bench = traffic.bench
    bench.can.initialise(LineMode(None), bench.done)
    assert (bench.outcomes, bench.can.mode) == ([], None)
    with pytest.raises(NotInitialised):
        bench.can.start()
    while not bench.outcomes:
        bench.run(0.01)
    assert bench.outcomes == [0]
    assert bench.can.mode is not None
    assert bench.can.mode.timing == traffic.timing  # which is what its status shows
    channel = bench.channel(events=frozenset())
    bench.can.start()
    bench.run(1)
    assert len(frames(channel)) > 5
    assert traffic.state() == [(0, 0, ErrorState.ERROR_ACTIVE, 0)] * 2
    assert bench.can.line.controller.errors == 0


@pytest.mark.conforms("X4-23")
def test_auto_baud_on_a_silent_bus_ends_uninitialised() -> None:
    bench = Bench()
    bench.can.initialise(LineMode(None, timeout_ms=10), bench.done)
    bench.run(0.2)
    assert [type(outcome) for outcome in bench.outcomes] == [NothingHeard]
    assert bench.can.mode is None
    bench.outcomes.clear()
    bench.start()


def test_auto_baud_at_low_speed_tries_no_higher_rates() -> None:
    bench = Bench(figures.USB_TO_CAN)
    bench.can.initialise(LineMode(None, timeout_ms=10, low_speed=True), bench.done)
    bench.run(1)
    (outcome,) = bench.outcomes
    assert str(outcome).endswith("bit rates: 125000, 100000, 50000, 20000, 10000, 5000")


def test_initialising_anew_ends_a_search() -> None:
    bench = Bench()
    bench.can.initialise(LineMode(None), bench.done)
    again: list[object] = []
    bench.can.initialise(CLASSIC, again.append)
    assert again == [0]
    assert [type(outcome) for outcome in bench.outcomes] == [NothingHeard]
    assert bench.can.mode == CLASSIC
    bench.run(20)
    assert bench.can.mode == CLASSIC


def test_a_reset_line_forgets_that_it_only_listened() -> None:
    """What asks about the line before it is set up anew, a cyclic list perhaps, sees a line without a mode."""
    bench = Bench()
    bench.initialise(replace(FD, listen_only=True))
    bench.can.reset()
    assert (bench.can.line.controller.listen_only, bench.can.line.controller.fd) == (False, 0)


# what programs of different interfaces hear


def kin_channel(bench: Bench, kin: str) -> Channel:
    """A channel of a program that speaks this interface."""
    channel = Channel(64, 64, events=frozenset({EventKind.ERROR}))
    channel.kin = kin
    return bench.can.line.open(channel)


@pytest.mark.finding("dialects 1")
def test_a_mode_says_for_its_own_kin_what_is_heard() -> None:
    bench = Bench()
    one, other = kin_channel(bench, "one"), kin_channel(bench, "other")
    narrow = replace(CLASSIC, kin="one", extended=False)
    bench.initialise(narrow)
    bench.can.format_filter(False, "one").set_pattern(0x200 << 1, 0x700 << 1)
    bench.can.start()
    for anew in (None, replace(CLASSIC, kin="other", error_frames=True)):
        if anew is not None:
            bench.start(anew)
        for frame in (Frame(0x150), Frame(0x250), Frame(1, extended=True)):
            bench.other.send(bench.listener, frame)
        bench.faults.flip(frame_id=0x250, bit=20, times=1)
        bench.run(0.1)
        assert [block[12] or frame_of_record(block).id for block in records(one)] == [0x250]
        heard = [block[12] or frame_of_record(block).id for block in records(other)]
        assert heard == [0x150, EventKind.ERROR, 0x250, 1]
        seen = bench.can.seen_by("one")
        assert seen is not None
        assert (seen.extended, seen.error_frames) == (False, False)


@pytest.mark.finding("dialects 1")
def test_a_kin_that_has_left_is_forgotten_unless_its_mode_keeps() -> None:
    bench = Bench()
    for kin, keeps in (("kept", True), ("left", False), ("there", False)):
        bench.initialise(replace(CLASSIC, kin=kin, keeps=keeps, error_frames=False))
    bench.can.release({"there"})
    modes = [bench.can.seen_by(kin) for kin in ("kept", "there", "left")]
    assert [mode.error_frames for mode in modes if mode is not None] == [False, False, True]


@pytest.mark.finding("dialects 7")
def test_a_stop_and_a_reset_are_changes_that_say_so() -> None:
    bench = Bench()
    bench.start()
    channel = bench.channel(events=frozenset({EventKind.CHANGED}))
    bench.stop()
    bench.can.start()
    bench.can.start()
    bench.can.reset()
    codes = [code for _, code in kinds(channel)]
    assert codes == [InfoCode.STOPPED, InfoCode.STARTED, InfoCode.RESET]
