"""The MCP2515's driver over its model: three mailboxes, orders, errors, bus-off, sleep, settings."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import (
    BadTiming,
    BadValue,
    BitTiming,
    BusEvent,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    Unsupported,
    WrongState,
)
from canwire.boards.can.channel import Channel
from canwire.boards.catalogue import ideal_line, mcp2515_line, plug, unplug
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.bus.can.node import Mailbox
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.controller import Mcp2515
from canwire.chips.mcp2515.modes import timing_of
from canwire.drivers.driver import LineSettings
from canwire.drivers.mcp2515.driver import Mcp2515Driver
from canwire.drivers.mcp2515.frames import arbitration_key, frame_bytes, take_frame
from canwire.drivers.mcp2515.timing import LIMITS, cnf_of
from canwire.timeline import Timeline
from canwire.values.frame import frame_of_record, record_of_frame
from canwire.values.record import ABORT_ON_ERROR, SINGLE_SHOT
from tests.cases import each

pytestmark = pytest.mark.core

TIMING = BitTiming.for_bit_rate(500_000, clock_hz=8_000_000)
BIT_NS = 2_000
EVERYTHING = frozenset(EventKind)
A, B, C, D = Frame(0x100, b"a"), Frame(0x200, b"bb"), Frame(0x300, b"ccc"), Frame(0x400, b"dddd")


class Bench:
    """A line with an MCP2515 and three channels, and a partner who acknowledges unless `alone`."""

    def __init__(self, *, alone: bool = False, bitwise: bool = False, **settings: object) -> None:
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.bus.bitwise = bitwise
        self.faults = Faults(self.bus, 1)
        self.line = mcp2515_line("line", self.timeline)
        assert isinstance(self.line.controller, Mcp2515)
        assert isinstance(self.line.driver, Mcp2515Driver)
        self.chip, self.driver = self.line.controller, self.line.driver
        plug(self.line, self.bus)
        self.channels = [
            self.line.open(Channel(4096, 256, events=EVERYTHING if k == 0 else frozenset())) for k in range(4)
        ]
        self.partner = ideal_line("partner", self.timeline)
        self.other = self.partner.open(Channel(4096, 256))
        if not alone:
            plug(self.partner, self.bus)
            self.partner.driver.configure(LineSettings(TIMING))
            self.partner.driver.start(0)
        self.driver.configure(LineSettings(TIMING, **settings))  # type: ignore[arg-type]
        self.driver.start(0)
        self.bits(20)
        self.took()  # that it has started

    def bits(self, count: float) -> None:
        self.timeline.run_until(self.timeline.now_ns + round(count * BIT_NS))

    def send(self, frame: Frame, channel: int = 0, flags: int = 0) -> None:
        self.line.send(self.channels[channel], frame, flags)

    def send_back(self, frame: Frame) -> None:
        self.partner.send(self.other, frame)

    def sent(self) -> list[Frame]:
        """What the partner heard."""
        return list(self.other.receive.take_frames(4096))

    def took(self) -> tuple[list[Frame], list[BusEvent]]:
        """What the first channel got: frames and events."""
        frames: list[Frame] = []
        events: list[BusEvent] = []
        while (record := self.channels[0].receive.take_bytes()) is not None:
            if record[12]:
                events.append(BusEvent.from_record(record))
            else:
                frames.append(frame_of_record(record))
        return frames, events

    def kinds(self) -> list[EventKind]:
        return [event.kind for event in self.took()[1]]


@pytest.fixture(params=[False, True], ids=["skipping", "bitwise"])
def bench(request: pytest.FixtureRequest) -> Bench:
    return Bench(bitwise=request.param)


# frames

FRAMES = [A, Frame(0x1ABCDEF5, bytes(range(8)), extended=True), Frame(0x7FF, remote=True, dlc=3), Frame(0, b""),
          Frame(0x1FFFFFFF, extended=True, remote=True, dlc=8)]  # fmt: skip


@pytest.mark.parametrize("frame", FRAMES)
def test_frames_there_and_back(bench: Bench, frame: Frame) -> None:
    bench.send(frame)
    bench.bits(200)
    bench.send_back(frame)
    bench.bits(200)
    assert bench.sent() == [frame]
    assert bench.took()[0] == [frame]
    counters = bench.driver.counters()
    assert (counters.frames_sent, counters.frames_received, counters.state) == (1, 1, ErrorState.ERROR_ACTIVE)


IDS = st.one_of(
    st.tuples(st.integers(0, 0x7FF), st.just(False)), st.tuples(st.integers(0, 0x1FFFFFFF), st.just(True))
)


@given(IDS, st.binary(max_size=8), st.booleans())
def test_bytes_of_a_frame(id: tuple[int, bool], data: bytes, remote: bool) -> None:
    if remote:
        frame = Frame(id[0], extended=id[1], remote=True, dlc=len(data))
    else:
        frame = Frame(id[0], data, extended=id[1])
    box, taken = Mailbox(), Mailbox()
    memoryview(box.block)[:] = record_of_frame(frame)
    chip = Mcp2515()
    chip.load_buffer(2, frame_bytes(box))
    chip.write(m.CANCTRL, m.LOOP_BACK << m.REQOP_SHIFT)
    chip.write(m.RXBCTRL[0], 0x60)
    timeline = Timeline()
    CanBus(timeline).attach(chip)
    chip.request_to_send(0b100)
    timeline.run_until(1_000_000_000)
    take_frame(chip.read_buffer(0), taken)
    assert taken.record() == box.record()


@given(st.lists(IDS, min_size=2, max_size=2, unique=True))
def test_the_arbitration_key_is_the_one_of_the_bus(ids: list[tuple[int, bool]]) -> None:
    timeline = Timeline()
    bus = CanBus(timeline)
    channels = []
    for id, extended in ids:
        line = ideal_line("", timeline)
        plug(line, bus)
        line.driver.configure(LineSettings(TIMING))
        line.driver.start(0, integrated=True)
        channels.append(line.open(Channel(8, 8)))
        line.send(channels[-1], Frame(id, b"", extended=extended))
    listener = ideal_line("", timeline)
    plug(listener, bus)
    listener.driver.configure(LineSettings(TIMING))
    listener.driver.start(0, integrated=True)
    heard = listener.open(Channel(8, 8))
    timeline.run_until(10_000_000)
    boxes = [Mailbox(), Mailbox()]
    for box, (id, extended) in zip(boxes, ids, strict=True):
        memoryview(box.block)[:] = record_of_frame(Frame(id, b"", extended=extended))
    lower = ids[0] if arbitration_key(boxes[0]) < arbitration_key(boxes[1]) else ids[1]
    first = heard.receive.take_frames(8)[0]
    assert (first.id, first.extended) == lower


# three mailboxes


def test_of_what_is_loaded_the_lowest_identifier_goes_first(bench: Bench) -> None:
    for channel, frame in enumerate((D, C, A)):
        bench.send(frame, channel)
    bench.bits(10)
    bench.send(B, 3)
    bench.bits(100)
    bench.send(Frame(0, b""), 3)
    bench.bits(500)
    assert bench.sent() == [A, B, Frame(0, b""), C, D]


def test_one_channel_keeps_its_order(bench: Bench) -> None:
    for frame in (D, C, B, A):
        bench.send(frame)
    bench.bits(600)
    assert bench.sent() == [D, C, B, A]


def test_equal_identifiers_go_in_the_order_they_were_loaded(bench: Bench) -> None:
    for channel in range(3):
        bench.send(Frame(0x123, bytes([channel])), channel)
    bench.send(Frame(0x123, bytes([3])), 3)
    bench.bits(600)
    assert [frame.data[0] for frame in bench.sent()] == [0, 1, 2, 3]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 0x7FF), st.integers(0, 120)), max_size=40),
    st.booleans(),
)
def test_nothing_is_lost_doubled_or_out_of_its_channels_order(
    sends: list[tuple[int, int, int]], bitwise: bool
) -> None:
    bench = Bench(bitwise=bitwise)
    for number, (channel, id, pause) in enumerate(sends):
        bench.send(Frame(id, bytes([channel, number])), channel)
        bench.bits(pause + 0.15)
    bench.bits(100 * len(sends))
    heard = [(frame.data[0], frame.data[1]) for frame in bench.sent()]
    assert sorted(number for _, number in heard) == list(range(len(sends)))
    for channel in range(4):
        assert [n for c, n in heard if c == channel] == [
            n for n, send in enumerate(sends) if send[0] == channel
        ]
    for sender in bench.channels:
        assert (sender.in_flight, sender.delivered + sender.aborted) == (0, sender.sent)


def test_a_saturated_bus_leaves_no_gap(bench: Bench) -> None:
    for number in range(60):
        for channel in range(3):
            bench.send(Frame(0x100 + channel, bytes([number])), channel)
    bench.bits(60 * 3 * 70)
    stamps = [frame.timestamp_ns for frame in bench.sent()]
    assert len(stamps) == 180
    assert max(later - earlier for earlier, later in pairwise(stamps)) <= 70 * BIT_NS


# giving up


def test_cancelled_frames_are_counted(bench: Bench) -> None:
    for channel, frame in enumerate((C, B, A)):
        bench.send(frame, channel)
    bench.bits(10)  # A is on the wire
    assert [bench.line.cancel(channel) for channel in bench.channels] == [1, 1, 0, 0]
    bench.bits(300)
    assert bench.sent() == [A]
    assert [channel.in_flight for channel in bench.channels] == [0, 0, 0, 0]


def test_what_is_cancelled_on_the_wire_is_not_repeated(bench: Bench) -> None:
    bench.faults.flip(bit="crc delimiter", seen_by="sender")
    bench.send(A)
    bench.bits(10)
    bench.line.cancel(bench.channels[0])
    bench.bits(300)
    assert (bench.sent(), bench.channels[0].aborted) == ([], 1)
    bench.send(B)
    bench.bits(100)
    assert bench.sent() == [B]


@pytest.mark.parametrize("flags", [SINGLE_SHOT, ABORT_ON_ERROR])
def test_given_up_at_the_first_error(flags: int) -> None:
    bench = Bench(alone=True)
    bench.send(A, 0, flags)
    bench.bits(3000)
    assert (bench.channels[0].aborted, bench.driver.counters().tec) == (1, 8)
    assert bench.kinds() == [EventKind.ERROR, EventKind.ABORTED]


def test_a_single_shot_that_loses_arbitration(bench: Bench) -> None:
    bench.send_back(A)
    bench.send(B, 0, SINGLE_SHOT)
    bench.bits(300)
    assert (bench.sent(), bench.channels[0].aborted) == ([], 1)
    assert bench.kinds() == [EventKind.ARBITRATION_LOST, EventKind.ABORTED]
    assert not bench.chip.read(m.CANCTRL) & m.CTRL_OSM
    bench.send(C)
    bench.bits(100)
    assert bench.sent() == [C]


def test_a_single_shot_takes_no_other_frame_with_it(bench: Bench) -> None:
    bench.faults.flip(frame_id=A.id, bit="dlc", seen_by="sender", times=2)
    bench.send(A, 0)
    bench.send(B, 1, SINGLE_SHOT)
    bench.bits(500)
    assert bench.sent() == [A, B]
    assert [channel.aborted for channel in bench.channels] == [0, 0, 0, 0]


def test_a_lost_arbitration_is_told_and_no_error(bench: Bench) -> None:
    bench.send_back(A)
    bench.send(B, 0, ABORT_ON_ERROR)
    bench.bits(300)
    assert bench.sent() == [B]
    assert bench.driver.counters().arbitration_losses == 1
    assert bench.kinds() == [EventKind.ARBITRATION_LOST]


# errors


def test_errors_have_no_kind(bench: Bench) -> None:
    bench.faults.flip(bit="dlc", seen_by="sender")
    bench.send(A)
    bench.bits(300)
    (event,) = [event for event in bench.took()[1] if event.kind is EventKind.ERROR]
    assert (event.error, event.code, event.transmitting, event.tec) == (ErrorKind.OTHER, 0, True, 8)
    bench.faults.flip(bit="dlc", seen_by=bench.chip)
    bench.send_back(A)
    bench.bits(300)
    (event,) = [event for event in bench.took()[1] if event.kind is EventKind.ERROR]
    assert (event.error, event.transmitting) == (ErrorKind.OTHER, False)
    counters = bench.driver.counters()
    assert (counters.errors, counters.last_error) == (2, ErrorKind.OTHER)


def test_every_state_is_told(bench: Bench) -> None:
    bench.took()
    bench.faults.flip(bit="dlc", seen_by="sender", times=32)
    bench.send(A)
    bench.bits(5000)
    states = [event.state for event in bench.took()[1] if event.kind is EventKind.STATE]
    assert states == [ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE, ErrorState.BUS_OFF]
    bench.driver.restart(bench.timeline.now_ns)
    bench.bits(200)
    assert (bench.sent(), bench.driver.counters().tec) == ([A], 0)
    assert [(event.kind, event.state) for event in bench.took()[1]] == [
        (EventKind.STATE, ErrorState.ERROR_ACTIVE)
    ]


RECOVERY_BITS = 128 * 11


def driven_off(bench: Bench, flags: int = 0) -> None:
    """In bus-off for a few bits, with A in a mailbox unless `flags` give it up."""
    bench.faults.flip(bit="dlc", seen_by="sender", times=32)
    bench.send(A, 0, flags)
    while bench.driver.counters().state is not ErrorState.BUS_OFF:
        bench.bits(5)
    bench.faults.clear()


@pytest.mark.conforms("G-11")
def test_bus_off_stays_until_somebody_brings_it_back(bench: Bench) -> None:
    """Though the chip recovers by itself: neither during the 128 times 11 bits nor after them does it take part."""
    driven_off(bench)
    bench.took()
    bench.send(B, 1)
    for _ in range(3):
        bench.partner.send(bench.other, C, SINGLE_SHOT)
        bench.bits(RECOVERY_BITS)
        counters = bench.driver.counters()
        assert (counters.tec, counters.state) == (256, ErrorState.BUS_OFF)
    assert (bench.sent(), bench.took()) == ([], ([], []))
    assert bench.driver.read_register(m.CNF1, True) == bench.chip.peek(m.CNF1)
    with pytest.raises(WrongState):
        bench.driver.sleep(bench.timeline.now_ns)
    bench.driver.rejoin(bench.timeline.now_ns)
    bench.bits(500)
    assert bench.driver.counters().state is ErrorState.BUS_OFF
    assert bench.other.aborted == 3
    bench.driver.restart(bench.timeline.now_ns)
    bench.bits(500)
    assert bench.sent() == [A, B]
    counters = bench.driver.counters()
    assert (counters.tec, counters.rec, counters.state) == (0, 0, ErrorState.ERROR_ACTIVE)


@pytest.mark.conforms("G-11")
def test_a_restart_at_once_waits_for_128_times_11_recessive_bits(bench: Bench) -> None:
    driven_off(bench)
    begun_ns = bench.timeline.now_ns
    bench.driver.restart(begun_ns)
    bench.took()
    bench.bits(RECOVERY_BITS - 50)
    assert bench.driver.counters().state is ErrorState.BUS_OFF
    bench.bits(200)
    (event,) = bench.took()[1]
    assert (event.kind, event.state) == (EventKind.STATE, ErrorState.ERROR_ACTIVE)
    assert bench.sent() == [A]


def test_a_single_shot_that_leads_to_bus_off_is_given_up(bench: Bench) -> None:
    bench.faults.flip(bit="dlc", seen_by="sender", times=32)
    for _ in range(32):
        bench.send(A, 0, SINGLE_SHOT)
    bench.send(B)
    bench.bits(32 * 100)
    assert bench.driver.counters().state is ErrorState.BUS_OFF
    assert (bench.channels[0].aborted, bench.channels[0].in_flight) == (32, 1)
    bench.driver.restart(bench.timeline.now_ns)
    bench.bits(RECOVERY_BITS + 100)
    assert bench.sent() == [B]


def test_who_goes_off_before_it_sleeps_stays_off(bench: Bench) -> None:
    bench.faults.flip(bit="dlc", seen_by="sender", times=32)
    bench.send(A)
    bench.bits(200)
    bench.driver.sleep(bench.timeline.now_ns)
    bench.bits(32 * 100 + 2 * RECOVERY_BITS)
    bench.send_back(C)
    bench.bits(200)
    assert bench.driver.counters().state is ErrorState.BUS_OFF
    assert EventKind.SLEEPING not in bench.kinds()
    bench.driver.restart(bench.timeline.now_ns)
    bench.bits(200)
    assert A in bench.sent()


def test_counters_in_bus_off(bench: Bench) -> None:
    driven_off(bench)
    counters = bench.driver.counters()
    assert (counters.tec, counters.state) == (256, ErrorState.BUS_OFF)
    bench.driver.start(bench.timeline.now_ns)
    bench.bits(200)
    assert bench.sent() == [A]
    bench.driver.stop(bench.timeline.now_ns)
    assert bench.driver.counters().state is ErrorState.STOPPED


def test_what_nobody_serves_is_overrun(bench: Bench) -> None:
    bench.driver.hold(True)
    for number in range(5):
        bench.send_back(Frame(number, b""))
    bench.bits(500)
    assert bench.took() == ([], [])
    bench.driver.hold(False)
    frames, events = bench.took()
    assert ([frame.id for frame in frames], [event.kind for event in events]) == ([0, 1], [EventKind.OVERRUN])
    assert bench.chip.overflows == 3  # one event for all of them: the flag is sticky
    bench.send_back(A)
    bench.bits(100)
    assert bench.took()[0] == [A]


# taking part


def test_stop_and_start_keep_what_is_loaded(bench: Bench) -> None:
    for channel, frame in enumerate((C, B, A)):
        bench.send(frame, channel)
    bench.bits(10)
    bench.driver.stop(bench.timeline.now_ns)
    bench.bits(500)
    assert bench.sent() == []
    bench.driver.start(bench.timeline.now_ns)
    bench.bits(500)
    assert sorted(frame.id for frame in bench.sent()) == [A.id, B.id, C.id]


def test_settings_take_effect_in_mid_frame(bench: Bench) -> None:
    bench.send(A)
    bench.bits(10)
    bench.driver.configure(LineSettings(TIMING, listen_only=True))
    bench.bits(300)
    assert bench.sent() == []
    assert bench.chip.read(m.CANSTAT) >> 5 == m.LISTEN_ONLY
    bench.driver.configure(LineSettings(TIMING))
    bench.bits(300)
    assert bench.sent() == [A]


def test_listen_only_does_not_acknowledge() -> None:
    bench = Bench(listen_only=True)
    bench.send_back(A)
    bench.bits(1000)
    assert bench.partner.driver.counters().tec > 0
    assert bench.driver.counters().tec == 0


def test_loop_back() -> None:
    bench = Bench(loop_back=True)
    for channel, frame in enumerate((B, A)):
        bench.send(frame, channel)
    bench.send_back(C)
    bench.bits(1000)
    assert (bench.took()[0], bench.sent()) == ([B, A], [])
    assert [channel.delivered for channel in bench.channels] == [1, 1, 0, 0]


def test_pulled_out_and_plugged_in(bench: Bench) -> None:
    bench.send(A)
    bench.bits(10)
    unplug(bench.line)
    bench.bits(100)
    plug(bench.line, bench.bus)
    bench.driver.rejoin(bench.timeline.now_ns)
    bench.bits(300)
    assert bench.sent() == [A]


def test_asleep_until_something_happens_on_the_bus(bench: Bench) -> None:
    third = ideal_line("third", bench.timeline)
    plug(third, bench.bus)
    third.driver.configure(LineSettings(TIMING))
    third.driver.start(bench.timeline.now_ns)
    bench.bits(20)
    bench.took()
    bench.driver.sleep(bench.timeline.now_ns)
    bench.driver.sleep(bench.timeline.now_ns)
    assert (bench.chip.asleep, bench.kinds()) == (True, [EventKind.SLEEPING])
    bench.send_back(A)
    bench.bits(150)
    assert (bench.chip.asleep, bench.took()[0]) == (False, [])
    bench.send_back(B)
    bench.bits(150)
    assert bench.took()[0] == [B]


def test_asleep_until_something_is_to_be_sent(bench: Bench) -> None:
    bench.took()
    bench.driver.sleep(bench.timeline.now_ns)
    bench.send(A)
    assert bench.kinds() == [EventKind.SLEEPING, EventKind.WOKEN]
    bench.bits(200)
    assert bench.sent() == [A]
    bench.driver.wake(bench.timeline.now_ns)
    assert bench.kinds() == []


def test_sleep_waits_for_what_is_on_the_wire(bench: Bench) -> None:
    bench.send(A)
    bench.bits(10)
    bench.driver.sleep(bench.timeline.now_ns)
    assert not bench.chip.asleep
    bench.bits(200)
    assert (bench.chip.asleep, bench.sent()) == (True, [A])
    assert EventKind.SLEEPING in bench.kinds()
    bench.driver.wake(bench.timeline.now_ns)
    assert bench.kinds() == [EventKind.WOKEN]
    bench.bits(50)
    assert bench.chip.on_bus


def test_nobody_who_is_stopped_sleeps(bench: Bench) -> None:
    bench.driver.stop(bench.timeline.now_ns)
    with pytest.raises(WrongState):
        bench.driver.sleep(bench.timeline.now_ns)


# settings and registers


@each("rate", [10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000])
def test_bit_rates(rate: int) -> None:
    for timing in (
        BitTiming.for_bit_rate(rate, clock_hz=8_000_000, limits=LIMITS),
        BitTiming.for_bit_rate(rate, clock_hz=80_000_000),
    ):
        cnf = cnf_of(timing, 16_000_000)
        found = timing_of(*cnf, 16_000_000)
        assert found.bit_rate == rate
        assert abs(found.sample_point - timing.sample_point) < 0.07
        assert found.sjw < found.tseg2 <= found.tseg1


@given(st.integers(1, 64), st.integers(2, 16), st.integers(2, 8), st.integers(1, 4))
def test_timing_registers_say_what_was_asked_for(prescaler: int, tseg1: int, tseg2: int, sjw: int) -> None:
    timing = BitTiming(prescaler, tseg1, tseg2, sjw, clock_hz=8_000_000)
    if tseg2 > tseg1 or not LIMITS.quanta_min <= timing.quanta <= LIMITS.quanta_max:
        with pytest.raises(BadTiming):
            cnf_of(timing, 16_000_000)
        return
    found = timing_of(*cnf_of(timing, 16_000_000), 16_000_000)
    assert (found.prescaler, found.tseg1, found.tseg2) == (prescaler, tseg1, tseg2)
    assert found.sjw == min(sjw, tseg2 - 1)


@pytest.mark.parametrize(
    ("settings", "error"),
    [
        (LineSettings(TIMING, data_timing=TIMING), Unsupported),
        (LineSettings(TIMING, oscillator_ppm=1.0), BadTiming),
        (LineSettings(TIMING, listen_only=True, loop_back=True), BadValue),
        (LineSettings(TIMING, registers=(("CNF1", 0),)), BadValue),
        (LineSettings(TIMING, registers=(("RXF0SIDH", 256),)), BadValue),
        (LineSettings(BitTiming(65, 5, 2, 1, clock_hz=8_000_000)), BadTiming),
    ],
)
def test_bad_settings_change_nothing(bench: Bench, settings: LineSettings, error: type[Exception]) -> None:
    before = bytes(bench.chip.cells)
    with pytest.raises(error):
        bench.driver.configure(settings)
    assert bytes(bench.chip.cells) == before


def test_filters_by_settings() -> None:
    registers = {"RXB0CTRL": 0, "RXB1CTRL": 0, "RXM0SIDH": 0xFF, "RXM1SIDH": 0xFF}
    registers |= {f"RXF{number}SIDH": 0xFF for number in range(6)}
    registers |= {"RXF1SIDH": B.id >> 3, "RXF5SIDH": C.id >> 3}
    bench = Bench(registers=tuple(registers.items()))
    for frame in (A, B, C, D):
        bench.send_back(frame)
    bench.bits(500)
    assert bench.took()[0] == [B, C]


def test_registers_for_display(bench: Bench) -> None:
    shown = {register.name: register for register in bench.driver.registers()}
    assert (shown["CANSTAT"].value, shown["CNF2"].value) == (0x00, bench.chip.read(m.CNF2))
    assert "RXF0SIDH" not in shown  # they read as 0 now
    bench.driver.stop(bench.timeline.now_ns)
    assert len(bench.driver.registers()) == len(m.MAP.registers)


def test_registers_one_by_one(bench: Bench) -> None:
    driver = bench.driver
    driver.write_register(m.MAP.named("RXF3SIDH").address, 0x55, False)
    assert driver.read_register(m.MAP.named("RXF3SIDH").address, True) == 0
    driver.write_register(m.MAP.named("RXF3SIDH").address, 0x55, True)
    assert driver.read_register(m.MAP.named("RXF3SIDH").address, True) == 0x55
    assert driver.read_register(m.MAP.named("RXF3SIDH").address, False) == 0
    driver.write_register(m.CANINTE, 0x03, False)
    assert driver.read_register(m.CANINTE, False) == 0x03
    for address, value in ((128, 0), (-1, 0), (0, 256)):
        with pytest.raises(BadValue):
            driver.write_register(address, value, False)
    bench.bits(30)
    bench.send_back(A)
    bench.bits(100)
    assert bench.took()[0] == [A]


def test_a_crystal_that_is_off() -> None:
    bench = Bench()
    bench.chip.oscillator_ppm = 2000.0
    bench.driver.configure(LineSettings(TIMING))
    bench.bits(20)
    for number in range(20):
        bench.send(Frame(number, bytes(8)))
        bench.send_back(Frame(0x400 + number, bytes(8)))
    bench.bits(6000)
    assert (len(bench.sent()), len(bench.took()[0])) == (20, 20)
    assert bench.chip.bit_ps == round(2_000_000 / 1.002)
