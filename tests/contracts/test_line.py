"""What a line promises whatever its controller: ideal, an SJA1000 behind a VCI board or at ISA ports, an MCP2515.

Every test runs on each kind, in a world in virtual time, and expects the same frames, events and counters of all.
Where the SJA1000 rightly differs (one transmit buffer, codes in the chip's own words), the test says so; and where
the MCP2515 does: a transmit buffer for each channel at a time, in the order of identifiers; no word of which error
it was, nor of where arbitration was lost.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import (
    BitTiming,
    BusEvent,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    NothingHeard,
    NotInitialised,
    Unplugged,
    Unsupported,
)
from canwire.boards.can.modes import ChannelMode, FilterMode, FilterSetup, LineMode, LineStatus, Siblings
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig
from canwire.bus.can.faults.faults import Faults
from canwire.values.event import InfoCode
from canwire.values.frame import record_to_send
from canwire.values.record import HIGH_PRIORITY, SELF_RECEPTION, SINGLE_SHOT
from tests.effort import examples
from tests.hub import in_memory

pytestmark = pytest.mark.core

KINDS = ("usb-to-can", "pc-i04", "inducan104", "picocom1")
MCP2515 = "picocom1"
TIMING = BitTiming.for_bit_rate(500_000, clock_hz=8_000_000)
CLASSIC = LineMode(TIMING, error_frames=True)
BIT_NS = 2_000
JOIN_BITS = 11
EVENTS = (EventKind.INFO, EventKind.ERROR, EventKind.STATE, EventKind.ARBITRATION_LOST, EventKind.ABORTED)


class Bench:
    """Line 0 of a board of one kind, and a USB-to-CAN beside it whose two lines are at work on the same bus."""

    def __init__(
        self, kind: str, mode: LineMode = CLASSIC, *, alone: bool = False, start: bool = True
    ) -> None:
        boards = (
            BoardConfig(kind=kind, serial="HW000001"),
            BoardConfig(kind="usb-to-can", serial="HW000002"),
        )
        self.bench = in_memory.Bench(Config(bus=Config.default().bus, board=boards))
        self.world = self.bench.world
        self.hub = self.bench.hub()
        self.kind = kind
        self.faults = Faults(self.world.buses["can0"], seed=0)
        self.board, self.other_board = self.world.boards
        self.others: list[Any] = []
        self.control = self.hub.open_control(self.board, 0)
        self.channels: list[Any] = []
        self.other = self.hub.open_channel(self.other_board, 0)
        self.other.set_up(ChannelMode(4096, 1024))
        self.other.activate()
        if not alone:
            self.others = [self.at_work(line) for line in (0, 1)]
        if start:
            self.control.initialise(mode)
            self.control.start()
            self.run(0.001)

    def at_work(self, line: int) -> Any:
        control = self.hub.open_control(self.other_board, line)
        control.initialise(LineMode(TIMING))
        control.start()
        return control

    def channel(self, *, events: tuple[int, ...] = (), **options: Any) -> Any:
        """An active channel of the board's line, for frames and these events."""
        channel = self.hub.open_channel(self.board, 0)
        channel.set_up(ChannelMode(**{"receive": 512, "transmit": 512, "events": events, **options}))
        channel.activate()
        self.channels.append(channel)
        return channel

    def run(self, seconds: float = 0.05) -> None:
        self.hub.run_for(seconds)

    @property
    def status(self) -> LineStatus:
        status: LineStatus = self.control.status()
        return status

    @property
    def counters(self) -> tuple[int, int, int]:
        status = self.status
        return status.tec, status.rec, status.state

    def heard(self) -> list[Frame]:
        """What the other board's first line has received."""
        return list(self.other.receive_many(4096))

    def close(self) -> None:
        self.bench.close()


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def bench(kind: str) -> Iterator[Bench]:
    made = Bench(kind)
    yield made
    made.close()


@pytest.fixture
def alone(kind: str) -> Iterator[Bench]:
    """Nobody else is on the bus."""
    made = Bench(kind, alone=True)
    yield made
    made.close()


@pytest.fixture
def idle(kind: str) -> Iterator[Bench]:
    """A line that nobody has set up yet."""
    made = Bench(kind, start=False)
    yield made
    made.close()


def everything(channel: Any) -> list[Any]:
    """Frames and events that wait."""
    found = []
    while (one := channel.receive_any()) is not None:
        found.append(one)
    return found


def told(channel: Any) -> list[tuple[int, int]]:
    """Kind, and state, error, bit or code, of the events that wait."""
    return [(event.kind, _detail(event)) for event in everything(channel) if isinstance(event, BusEvent)]


def _detail(event: BusEvent) -> int:
    if event.kind is EventKind.STATE:
        return event.state
    if event.kind is EventKind.ERROR:
        return event.error
    return event.bit if event.kind is EventKind.ARBITRATION_LOST else event.code


def ids(frames: list[Frame]) -> list[int]:
    return [frame.id for frame in frames]


# states


def test_undefined_stopped_running_stopped_undefined(idle: Bench) -> None:
    with pytest.raises(NotInitialised):
        idle.control.start()
    idle.control.initialise(CLASSIC)
    assert (idle.status.initialised, idle.status.running, idle.status.state) == (
        True,
        False,
        ErrorState.STOPPED,
    )
    idle.control.start()
    idle.control.start()
    assert (idle.status.running, idle.counters) == (True, (0, 0, ErrorState.ERROR_ACTIVE))
    idle.control.stop()
    idle.control.stop()
    assert (idle.status.initialised, idle.status.running) == (True, False)
    idle.control.start()
    idle.control.reset()
    assert (idle.status.initialised, idle.status.running, idle.status.mode) == (False, False, None)


@pytest.mark.finding("vendor 2")
def test_what_is_told_of_starting_stopping_and_resetting(idle: Bench) -> None:
    channel = idle.channel(events=EVENTS)
    idle.control.initialise(CLASSIC)
    idle.control.start()
    idle.run()
    idle.control.stop()
    idle.control.start()
    idle.control.reset()
    active, stopped = (EventKind.STATE, ErrorState.ERROR_ACTIVE), (EventKind.STATE, ErrorState.STOPPED)
    assert told(channel) == [
        (EventKind.INFO, InfoCode.STARTED), active, (EventKind.INFO, InfoCode.STOPPED), stopped,
        (EventKind.INFO, InfoCode.STARTED), active, (EventKind.INFO, InfoCode.RESET), stopped,
    ]  # fmt: skip


def test_a_line_takes_part_after_eleven_recessive_bits(idle: Bench) -> None:
    """The SJA1000 knows no other way; here the ideal controller does not either."""
    channel = idle.channel()
    idle.control.initialise(CLASSIC)
    channel.send(Frame(1))
    begun_ns = idle.hub.now_ns()
    idle.control.start()
    idle.run()
    (frame,) = idle.heard()
    length = 44 + 2  # two stuff bits behind 00000 of id 1 and of DLC 0
    waited = (frame.timestamp_ns - begun_ns) // BIT_NS - length
    assert JOIN_BITS <= waited <= JOIN_BITS + 3


def test_what_is_queued_before_the_start_goes_out_then(idle: Bench) -> None:
    channel = idle.channel()
    idle.control.initialise(CLASSIC)
    for id in (3, 1, 2):
        channel.send(Frame(id))
    idle.run()
    assert idle.heard() == []
    idle.control.start()
    idle.run()
    assert ids(idle.heard()) == [3, 1, 2]


@pytest.mark.parametrize("after_us", [5, 30, 100, 200, 260])
def test_stopping_waits_for_the_frame_on_the_wire(bench: Bench, after_us: int) -> None:
    channel = bench.channel()
    for id in (1, 2, 3):
        channel.send(Frame(id, bytes(8)))
    bench.run(after_us * 1e-6)
    bench.control.stop()
    bench.run()
    sent = ids(bench.heard())
    assert sent in ([1], [1, 2])
    assert channel.status().pending == 3 - len(sent)
    bench.control.start()
    bench.run()
    assert sent + ids(bench.heard()) == [1, 2, 3]
    assert bench.others[0].status().errors == 0


def test_a_reset_breaks_the_frame_on_the_wire_and_keeps_the_queues(bench: Bench) -> None:
    channel = bench.channel()
    for id in (1, 2, 3):
        channel.send(Frame(id, bytes(8)))
    bench.run(100e-6)
    bench.control.reset()
    bench.run()
    assert bench.heard() == []
    assert bench.others[0].status().errors == 1
    status = channel.status()
    assert (status.aborted, status.delivered, status.pending) == (1, 0, 2)
    bench.control.initialise(CLASSIC)
    bench.control.start()
    bench.run()
    assert ids(bench.heard()) == [2, 3]


def test_a_stopped_line_hears_nothing_ever(bench: Bench) -> None:
    channel = bench.channel()
    bench.other.send(Frame(1))
    bench.run()
    bench.control.stop()
    bench.other.send(Frame(2))
    bench.run()
    bench.control.start()
    bench.run()
    bench.other.send(Frame(3))
    bench.run()
    assert ids(channel.receive_many(9)) == [1, 3]


# frames

SAMPLES = [
    *(Frame(0x123, bytes(range(dlc))) for dlc in range(9)),
    *(Frame(0x7FF, bytes(range(8)), dlc=dlc) for dlc in range(9, 16)),
    Frame(0), Frame(0x7EF, b"\xff" * 8), Frame(0x555, b"\x55\xaa"),
    *(Frame(0x2A, remote=True, dlc=dlc) for dlc in (0, 1, 8, 9, 15)),
    *(Frame(id, b"\x12\x34", extended=True) for id in (0, 1, 0x7FF, 0x800, 0x1234567, 0x15555555, 0x1FFFFFFF)),
    Frame(0x1FFFFFFF, bytes(8), extended=True, dlc=15), Frame(0x18DAF110, extended=True, remote=True, dlc=8),
]  # fmt: skip


def test_frames_of_all_kinds_go_out(bench: Bench) -> None:
    channel = bench.channel()
    for frame in SAMPLES:
        channel.send(frame)
    bench.run()
    assert bench.heard() == SAMPLES
    assert (bench.status.frames_sent, channel.status().delivered) == (len(SAMPLES), len(SAMPLES))


def test_frames_of_all_kinds_come_in(bench: Bench) -> None:
    channel = bench.channel()
    for frame in SAMPLES:
        bench.other.send(frame)
    bench.run()
    assert channel.receive_many(99) == SAMPLES
    assert (bench.status.frames_received, channel.status().accepted) == (len(SAMPLES), len(SAMPLES))


def test_times_of_reception_are_those_of_everybody(bench: Bench) -> None:
    """The end of the frame, to the nanosecond, whoever asks."""
    channel = bench.channel()
    witness = bench.hub.open_channel(bench.other_board, 1)
    witness.set_up(ChannelMode(64, 0))
    witness.activate()
    for frame in SAMPLES:
        bench.other.send(frame)
    bench.run()
    stamps = [frame.timestamp_ns for frame in channel.receive_many(99)]
    assert stamps == [frame.timestamp_ns for frame in witness.receive_many(99)]


def test_fd_frames_are_not_for_classic_lines(bench: Bench) -> None:
    channel = bench.channel()
    channel.writing.ring.put_bytes(record_to_send(Frame(1, bytes(12), fd=True)))
    channel.send(Frame(2))
    bench.run()
    assert ids(bench.heard()) == [2]
    assert channel.status().refused == 1
    for impossible in (replace(CLASSIC, long_data=True), replace(CLASSIC, data_timing=TIMING)):
        with pytest.raises(Unsupported):
            bench.control.initialise(impossible)
    assert bench.status.running


def test_back_to_back(bench: Bench) -> None:
    """The next frame is in the chip's buffer before the three bits between two frames are over."""
    channel = bench.channel()
    for _ in range(20):
        channel.send(Frame(0x555, b"\x55" * 8))
    bench.run()
    stamps = [frame.timestamp_ns for frame in bench.heard()]
    gaps = {late - early for early, late in itertools.pairwise(stamps)}
    assert gaps == {(44 + 64 + 1 + 3) * BIT_NS}  # one stuff bit, in the CRC


# filters


@pytest.mark.parametrize("extended", [False, True])
def test_the_lines_filter(kind: str, extended: bool) -> None:
    setup = FilterSetup(FilterMode.INCLUSIVE)
    bench = Bench(kind, start=False)
    bench.control.initialise(replace(CLASSIC, standard_filter=setup, extended_filter=setup))
    bench.control.set_acceptance(
        0x100 << 1, 0x7FF << 1 if not extended else 0x1FFFFFFF << 1, extended=extended
    )
    bench.control.add_ids(0x200 << 1, 0x1FFFFFFE << 1 if extended else 0x7FE << 1, extended=extended)
    bench.control.start()
    bench.run()
    channel = bench.channel()
    for id in (0xFF, 0x100, 0x101, 0x200, 0x201, 0x202):
        bench.other.send(Frame(id, extended=extended))
    bench.run()
    assert ids(channel.receive_many(9)) == [0x100, 0x200, 0x201]
    assert bench.status.frames_received == 6
    bench.close()


@pytest.mark.parametrize("extended", [False, True])
def test_a_format_that_is_not_wanted(kind: str, extended: bool) -> None:
    bench = Bench(kind, replace(CLASSIC, standard=extended, extended=not extended))
    channel = bench.channel()
    for other in (False, True):
        bench.other.send(Frame(1, extended=other))
        channel.send(Frame(2, extended=other))
    bench.run()
    assert [frame.extended for frame in channel.receive_many(9)] == [not extended]
    assert channel.status().refused == 1
    bench.close()


# how frames are sent


def test_listen_only(kind: str) -> None:
    bench = Bench(kind, replace(CLASSIC, listen_only=True))
    bench.others[1].stop()  # now nobody acknowledges
    channel = bench.channel()
    channel.send(Frame(9))
    bench.other.send(Frame(1), SINGLE_SHOT)
    bench.run()
    assert (channel.receive_many(9), bench.other.status().aborted) == ([], 1)
    bench.others[1].start()
    bench.run()
    bench.other.send(Frame(2))
    bench.run()
    assert ids(channel.receive_many(9)) == [2]
    assert (channel.status().pending, bench.status.frames_sent, bench.status.tec) == (1, 0, 0)
    bench.close()


@pytest.mark.parametrize("times", [1, 5])
def test_a_disturbed_frame_is_repeated_unless_it_is_a_single_shot(bench: Bench, times: int) -> None:
    channel = bench.channel(events=EVENTS)
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=times)
    channel.send(Frame(1))
    bench.run()
    assert ids(bench.heard()) == [1]
    bench.faults.clear()
    bench.faults.flip(frame_id=2, bit="crc delimiter")
    channel.send(Frame(2), SINGLE_SHOT)
    channel.send(Frame(3))
    bench.run()
    assert ids(bench.heard()) == [3]
    status = channel.status()
    assert (status.delivered, status.aborted, status.pending) == (2, 1, 0)
    assert bench.status.errors == times + 1
    assert [kind for kind, _ in told(channel)] == [EventKind.ERROR] * (times + 1) + [EventKind.ABORTED]


def test_lost_arbitration(bench: Bench) -> None:
    """Bit 3 of the identifier decides; a single shot is given up, any other frame waits its turn."""
    bit = -1 if bench.kind == MCP2515 else 3
    channel = bench.channel(events=EVENTS)
    for flags in (0, SINGLE_SHOT):
        channel.send(Frame(0x700))
        channel.send(Frame(0x080), flags)
        bench.run(50e-6)
        bench.other.send(Frame(0x000))
        bench.run()
    assert ids(bench.heard()) == [0x700, 0x080, 0x700]
    assert told(channel) == [
        (EventKind.ARBITRATION_LOST, bit), (EventKind.ARBITRATION_LOST, bit), (EventKind.ABORTED, 0),
    ]  # fmt: skip
    assert bench.status.arbitration_losses == 2
    assert (bench.status.errors, bench.status.tec) == (0, 0)


@pytest.mark.parametrize(
    ("mine", "theirs", "bit"),
    [
        (Frame(1), Frame(0), 10),
        (Frame(0x400), Frame(0), 0),
        (Frame(0, remote=True), Frame(0, b"\1"), 11),
        (Frame(0, extended=True), Frame(0), 11),
        (Frame(1, extended=True), Frame(0, extended=True), 30),
        (Frame(0x20000, extended=True), Frame(0, extended=True), 13),
        (Frame(0, extended=True, remote=True), Frame(0, extended=True), 31),
    ],
)
def test_where_arbitration_is_lost(bench: Bench, mine: Frame, theirs: Frame, bit: int) -> None:
    """An MCP2515 says that it was, not where."""
    channel = bench.channel(events=EVENTS)
    bench.other.send(Frame(0x555))
    bench.run(20e-6)
    channel.send(mine)
    bench.other.send(theirs)
    bench.run()
    assert told(channel) == [(EventKind.ARBITRATION_LOST, -1 if bench.kind == MCP2515 else bit)]
    assert channel.status().delivered == 1


@pytest.mark.parametrize("siblings", list(Siblings))
def test_self_reception(bench: Bench, siblings: Siblings) -> None:
    channel, sibling = bench.channel(siblings=siblings), bench.channel(siblings=siblings)
    for id, flags in ((1, SELF_RECEPTION), (2, 0)):
        channel.send(Frame(id), flags)
    bench.run()
    every = siblings in (Siblings.EVERY, Siblings.OTHERS, Siblings.OTHERS_AND_OWN)
    own = {Siblings.EVERY: [1, 2], Siblings.OTHERS_AND_OWN: [1, 2], Siblings.OTHERS: []}
    assert ids(channel.receive_many(9)) == own.get(siblings, [1])
    shared = siblings in (Siblings.ALL, Siblings.AS_BUS, Siblings.OWN_FILTERED)
    assert ids(sibling.receive_many(9)) == ([1, 2] if every else [1] if shared else [])
    assert ids(bench.heard()) == [1, 2]


def test_two_channels_take_turns(bench: Bench) -> None:
    """Each has a transmit buffer of an MCP2515, and there the lowest identifier goes first."""
    one, two = bench.channel(), bench.channel()
    for number in range(4):
        one.writing.ring.put_bytes(record_to_send(Frame(0x10 + number)))
        two.writing.ring.put_bytes(record_to_send(Frame(0x20 + number)))
    one.send(Frame(0x14))
    bench.run()
    sent = ids(bench.heard())
    assert [id for id in sent if id < 0x20] == [0x10, 0x11, 0x12, 0x13, 0x14]
    assert [id for id in sent if id >= 0x20] == [0x20, 0x21, 0x22, 0x23]
    if bench.kind == MCP2515:
        assert sent in (sorted(sent), [0x20, *sorted({*sent} - {0x20})])  # which one is loaded first
    else:
        assert [id >> 4 for id in sent[:8]] in ([1, 2] * 4, [2, 1] * 4)


def test_urgent_frames_overtake_where_there_is_a_buffer_for_them(bench: Bench) -> None:
    """An SJA1000 has one transmit buffer: there they wait behind what is in it, and behind their own channel's.

    An MCP2515 has one for each channel: there they wait behind their own channel's, and for lower identifiers.
    """
    channel = bench.channel()
    for id, flags in ((1, 0), (2, 0), (3, HIGH_PRIORITY)):
        channel.send(Frame(id, bytes(8)), flags)
    other = bench.channel()
    other.send(Frame(4, bytes(8)), HIGH_PRIORITY)
    bench.run()
    expected = {"usb-to-can": [4, 1, 3, 2], MCP2515: [1, 2, 3, 4]}
    assert ids(bench.heard()) == expected.get(bench.kind, [1, 4, 2, 3])


def test_cancel(bench: Bench) -> None:
    channel = bench.channel()
    for id in range(6):
        channel.send(Frame(id, bytes(8)))
    bench.run(50e-6)
    assert channel.cancel() == 5
    bench.run()
    assert ids(bench.heard()) == [0]
    bench.control.stop()
    channel.send(Frame(9))
    assert channel.cancel() == 1
    bench.control.start()
    bench.run()
    assert bench.heard() == []
    status = channel.status()
    assert (status.sent, status.delivered, status.aborted, status.pending) == (7, 1, 6, 0)


def test_what_waits_in_the_controller_can_be_cancelled(bench: Bench) -> None:
    channel = bench.channel()
    bench.other.send(Frame(0, bytes(8)))
    bench.run(20e-6)
    channel.send(Frame(1))
    assert channel.cancel() == 1
    channel.send(Frame(2))
    bench.run()
    assert bench.status.frames_sent == 1
    assert channel.status().delivered == 1


def test_delayed_frames(bench: Bench) -> None:
    channel = bench.channel()
    channel.send(Frame(1))
    channel.writing.ring.put_bytes(record_to_send(Frame(2), 0, 3_000_000))
    channel.send(Frame(3))
    bench.run()
    first, second, third = bench.heard()
    assert second.timestamp_ns - first.timestamp_ns == 3_000_000 + 47 * BIT_NS
    assert third.timestamp_ns - second.timestamp_ns == 50 * BIT_NS


def test_a_cyclic_list(bench: Bench, kind: str) -> None:
    if kind == "pc-i04":  # a passive board has none
        with pytest.raises(Unsupported, match="no cyclic transmit list"):
            bench.hub.open_scheduler(bench.board, 0)
        return
    scheduler = bench.hub.open_scheduler(bench.board, 0)
    quick = scheduler.add(record_to_send(Frame(0x10, b"\0")), 10, increment=2, byte_index=0)
    slow = scheduler.add(record_to_send(Frame(0x20)), 25)
    scheduler.start(quick)
    scheduler.start(slow, 2)
    scheduler.resume()
    bench.run(0.0105)
    frames = bench.heard()
    stamps = [frame.timestamp_ns for frame in frames if frame.id == 0x10]
    assert len(stamps) >= 10
    for early, late in itertools.pairwise(stamps):  # stuff bits make the ends of frames differ
        assert abs(late - early - 1_000_000) <= 3 * BIT_NS
    assert ids(frames).count(0x20) == 2
    assert [frame.data[0] for frame in frames if frame.id == 0x10] == list(range(len(stamps)))


# errors


def test_alone_a_sender_turns_passive_and_stays_so(alone: Bench) -> None:
    """ISO 11898-1: an error-passive sender that misses nothing but the acknowledgement counts no further.

    An MCP2515 does not say that it was the acknowledgement.
    """
    error = ErrorKind.OTHER if alone.kind == MCP2515 else ErrorKind.ACK
    channel = alone.channel(events=EVENTS)
    channel.send(Frame(1))
    alone.run(0.2)
    assert alone.counters == (128, 0, ErrorState.ERROR_PASSIVE)
    found = told(channel)
    assert {detail for kind, detail in found if kind is EventKind.ERROR} == {error}
    states = [detail for kind, detail in found if kind is EventKind.STATE]
    assert states == [ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE]
    assert alone.status.last_error == error
    alone.at_work(0)
    alone.run()
    assert (ids(alone.heard()), alone.counters) == ([1], (127, 0, ErrorState.ERROR_WARNING))
    for _ in range(127):
        channel.send(Frame(2))
    alone.run()
    assert alone.counters == (0, 0, ErrorState.ERROR_ACTIVE)
    assert [detail for kind, detail in told(channel) if kind is EventKind.STATE] == [
        ErrorState.ERROR_WARNING, ErrorState.ERROR_ACTIVE,
    ]  # fmt: skip


def test_states_come_at_the_very_errors_that_bring_them(alone: Bench) -> None:
    channel = alone.channel(events=EVENTS)
    channel.send(Frame(1))
    alone.run(0.02)
    events = [event for event in everything(channel) if isinstance(event, BusEvent)]
    assert [(event.kind, event.tec) for event in events[11:18]] == [
        (EventKind.ERROR, 96), (EventKind.STATE, 96), (EventKind.ERROR, 104), (EventKind.ERROR, 112),
        (EventKind.ERROR, 120), (EventKind.ERROR, 128), (EventKind.STATE, 128),
    ]  # fmt: skip


def test_a_receiver_counts_too(bench: Bench) -> None:
    channel = bench.channel(events=EVENTS)
    bench.others[1].stop()
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=3)
    bench.other.send(Frame(1))
    bench.run()
    assert ids([one for one in everything(channel) if isinstance(one, Frame)]) == [1]
    assert bench.status.errors == 3
    assert bench.status.rec > 0
    before = bench.status.rec
    bench.other.send(Frame(2))
    bench.run()
    assert bench.status.rec == before - 1


@pytest.mark.parametrize(
    ("place", "error"),
    [("stuff", ErrorKind.STUFF), ("crc delimiter", ErrorKind.FORM), ("crc", ErrorKind.CRC)],
)
def test_what_a_receiver_finds_wrong(bench: Bench, place: str, error: ErrorKind) -> None:
    """Its code is ECC, 0 where the controller has none; an MCP2515 only knows that something is wrong."""
    channel = bench.channel(frames=False, events=(EventKind.ERROR,))
    node = bench.world.boards[bench.board].lines[0].line.controller
    bench.faults.flip(frame_id=1, bit=place, seen_by=node)
    bench.other.send(Frame(1, bytes(4)))
    bench.run()
    (event, *_) = everything(channel)
    expected = ErrorKind.OTHER if bench.kind == MCP2515 else error
    assert (event.error, event.transmitting) == (expected, False)
    assert (event.code != 0) == (bench.kind not in ("usb-to-can", MCP2515))


@pytest.mark.conforms("G-11")
def test_bus_off_and_back(bench: Bench) -> None:
    """An MCP2515 would recover by itself: its driver takes it off the bus when it has."""
    channel = bench.channel(events=EVENTS)
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
    for id in (1, 2):
        channel.send(Frame(id))
    bench.run(0.2)
    status = bench.status
    assert (status.tec, status.rec, status.state, status.running) == (256, 0, ErrorState.BUS_OFF, True)
    assert [detail for kind, detail in told(channel) if kind is EventKind.STATE] == [
        ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE, ErrorState.BUS_OFF,
    ]  # fmt: skip
    bench.heard()
    bench.other.send(Frame(9))
    bench.run(1.0)
    assert channel.receive_many(9) == []  # nothing comes in, and it stays off
    assert bench.status.state == ErrorState.BUS_OFF
    bench.faults.clear()
    bench.control.stop()
    bench.control.start()
    bench.run()
    assert bench.counters == (0, 0, ErrorState.ERROR_ACTIVE)
    assert ids(bench.heard()) == [1, 2]
    assert channel.status().pending == 0


def test_in_bus_off_what_waits_can_be_given_up(bench: Bench) -> None:
    channel = bench.channel()
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
    for id in (1, 2, 3):
        channel.send(Frame(id))
    bench.run(0.2)
    assert bench.status.state == ErrorState.BUS_OFF
    assert channel.cancel() == 3
    bench.faults.clear()
    bench.control.stop()
    bench.control.start()
    channel.send(Frame(4))
    bench.run()
    bench.heard()
    status = channel.status()
    assert (status.delivered, status.aborted, status.pending) == (1, 3, 0)


def test_a_shorted_bus(bench: Bench) -> None:
    channel = bench.channel()
    bench.hub.short("can0")
    channel.send(Frame(1))
    bench.run(0.05)
    before = bench.status
    bench.hub.short("can0", False)
    bench.run()
    assert before.frames_sent == 0
    bench.control.stop()
    bench.control.start()
    bench.run()
    assert (bench.status.tec, channel.status().delivered) == (0, 1)


# finding the bit rate


def test_auto_baud(idle: Bench) -> None:
    for number in range(100):
        idle.other.send(Frame(0x555, b"\x55" * 8))
        idle.other.writing.ring.put_bytes(record_to_send(Frame(0x2AA), 0, 2_000_000 + number))
    idle.control.initialise(LineMode(None))
    timing = idle.status.mode.timing  # type: ignore[union-attr]
    assert timing is not None
    assert timing.bit_rate == 500_000
    idle.control.start()
    channel = idle.channel()
    idle.run(0.5)
    assert channel.status().accepted > 0
    assert (idle.status.errors, idle.others[0].status().errors) == (0, 0)


def test_auto_baud_on_a_silent_bus(idle: Bench) -> None:
    with pytest.raises(NothingHeard):
        idle.control.initialise(LineMode(None, timeout_ms=10))
    assert not idle.status.initialised


# pulling it out


def test_pulled_out_in_the_middle_of_its_frame(bench: Bench) -> None:
    channel = bench.channel()
    for id in (1, 2):
        channel.send(Frame(id, bytes(8)))
    bench.run(100e-6)
    bench.hub.unplug("HW000001")
    bench.run()
    for use in (channel.status, bench.control.start, bench.control.status):
        with pytest.raises(Unplugged):
            use()
    assert bench.heard() == []
    assert bench.others[0].status().errors == 1
    bench.other.send(Frame(3))
    bench.run()
    assert bench.other.status().delivered == 1
    again = bench.hub.plug(bench.kind, "HW000001")
    control = bench.hub.open_control(again.id, 0)
    control.initialise(CLASSIC)
    control.start()
    reborn = bench.hub.open_channel(again.id, 0)
    reborn.set_up(ChannelMode(8, 8))
    reborn.activate()
    reborn.send(Frame(4))
    bench.run()
    assert ids(bench.heard()) == [4]


# anything at all

FRAMES = st.builds(
    lambda id, extended, remote, data: Frame(
        id if extended else id & 0x7FF, b"" if remote else data, extended=extended, remote=remote
    ),
    st.integers(0, 0x1FFFFFFF).map(lambda id: id & ~1),
    st.booleans(),
    st.booleans(),
    st.binary(max_size=8),
)
CALM = ("mine", "mine again", "theirs", "flip", "start")
ROUGH = (*CALM, "cancel", "stop")
UNTIMED = (EventKind.ARBITRATION_LOST, EventKind.ABORTED)
Step = tuple[str, Frame, int, int]


def steps_of(*kinds: str) -> st.SearchStrategy[list[Step]]:
    """What happens, and nanoseconds until the next step."""
    flags = st.sampled_from([0, SINGLE_SHOT, SELF_RECEPTION])
    return st.lists(st.tuples(st.sampled_from(kinds), FRAMES, flags, st.integers(0, 400_000)), max_size=12)


def theirs(frame: Frame) -> Frame:
    """The same with an identifier of its own: equal ones would collide."""
    length = frame.dlc if frame.remote else None
    return Frame(frame.id | 1, frame.data, extended=frame.extended, remote=frame.remote, dlc=length)


def take(bench: Bench, channels: list[Any], step: Step) -> None:
    what, frame, flags, pause_ns = step
    if what == "mine":
        channels[0].send(frame, flags)
    elif what == "mine again":
        channels[1].send(frame, flags)
    elif what == "theirs":
        bench.other.send(theirs(frame))
    elif what == "flip":
        bench.faults.flip(bit=frame.id % 90, times=1 + flags % 3, seen_by="sender" if flags else "receivers")
    elif what == "cancel":
        channels[0].cancel()
    elif what == "stop":
        bench.control.stop()
    elif what == "start":
        bench.control.start()
    bench.run(pause_ns / 1e9)


def comparable(one: Frame | BusEvent, late: bool = False) -> Any:
    """The ideal controller says when the frame began that lost, an SJA1000's driver when it heard of it; and codes.

    Who is `late` to hear of it has other counters by then, and only guesses whose error it was.
    """
    if isinstance(one, Frame):
        return one, one.timestamp_ns
    if one.kind in UNTIMED:
        one = replace(one, timestamp_ns=0)
        if late:
            one = replace(one, tec=0, rec=0, state=ErrorState.ERROR_ACTIVE)
    if late and one.kind is EventKind.ERROR:
        one = replace(one, transmitting=False)
    return replace(one, code=0, bit=0, error=ErrorKind.NONE)


def played(kind: str, steps: list[Step], *, losses: bool = True) -> tuple[Any, ...]:
    """Everything that anybody saw (without `losses` but lost arbitrations), and every counter.

    On the way the books are checked.
    """
    with contextlib.closing(Bench(kind)) as bench:
        events = EVENTS if losses else tuple({*EVENTS} - {EventKind.ARBITRATION_LOST})
        channels = [bench.channel(events=events), bench.channel(), bench.other]
        for step in steps:
            take(bench, channels, step)
            for channel in channels:
                status = channel.status()
                assert status.sent == status.delivered + status.aborted + status.refused + status.pending
        bench.faults.clear()
        bench.control.start()
        bench.run(0.5)
        statuses = [channel.status() for channel in channels]
        assert [status.pending for status in statuses] == [0, 0, 0]
        line = replace(bench.status, mode=None, time_ns=0, load=0.0, last_error=0)
        assert line.frames_sent == statuses[0].delivered + statuses[1].delivered
        if not losses:
            line = replace(line, arbitration_losses=0)
        seen = [[comparable(one, not losses) for one in everything(channel)] for channel in channels]
        return seen, statuses, line


@pytest.mark.parametrize("kind", KINDS[1:])
@examples(40)
@given(steps=steps_of(*CALM))
def test_all_kinds_do_the_same_to_the_nanosecond(kind: str, steps: list[Step]) -> None:
    """With one channel that sends, on an MCP2515: between two their identifiers decide.

    Nor does it tell of every arbitration that one frame loses, and of none at once.
    """
    mcp2515 = kind == MCP2515
    if mcp2515:
        steps = [("mine" if what == "mine again" else what, *rest) for what, *rest in steps]
    assert played(kind, steps, losses=not mcp2515) == played("usb-to-can", steps, losses=not mcp2515)


@pytest.mark.parametrize("kind", KINDS)
@examples(40)
@given(steps=steps_of(*ROUGH))
def test_no_frame_is_lost_in_silence(kind: str, steps: list[Step]) -> None:
    """Nor is any received that was not sent. When exactly a frame is given up is the controller's own."""
    seen, _, _ = played(kind, steps)
    sent = {theirs(frame) if what == "theirs" else frame for what, frame, _, _ in steps}
    assert {one[0] for channel in seen for one in channel if isinstance(one, tuple)} <= sent
