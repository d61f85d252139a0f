"""A line and its channels: what other processes may ask of it, whose turn it is, and who gets what back."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BitTiming, BusEvent, ErrorKind, EventKind, Frame, LineError
from canwire.boards.can.channel import Channel
from canwire.boards.can.hearing import Hearing
from canwire.boards.can.line import Line
from canwire.boards.can.message_filter import (
    ALWAYS,
    BY_LIST,
    BY_PATTERN,
    NOT_EXCLUDED,
    MessageFilter,
    message_filter,
)
from canwire.boards.can.modes import FilterMode, LineMode, Siblings
from canwire.boards.catalogue import ideal_line, plug
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.drivers.driver import LineSettings
from canwire.ring import Ring, ring_size, rounded_capacity
from canwire.timeline import Timeline
from canwire.values.dlc import FD_LENGTHS
from canwire.values.frame import frame_of_record, record_to_send
from canwire.values.record import (
    ACCEPT_SHIFT,
    CONFIRM,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    FAST_DATA_RATE,
    HIGH_PRIORITY,
    OVERRUN,
    REMOTE,
    SELF_RECEPTION,
    SINGLE_SHOT,
)
from canwire.values.records import frames_to_array
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

NOMINAL = BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
DATA = BitTiming.for_bit_rate(5_000_000, clock_hz=80_000_000)
SECOND_NS = 1_000_000_000
CODE_NONE, MASK_NONE = 0x80000000, 0xFFFFFFFF
DATA_AT = 16  # in a record
EDL, FDR, SSM, HPM, SRR = EXTENDED_DATA_LENGTH, FAST_DATA_RATE, SINGLE_SHOT, HIGH_PRIORITY, SELF_RECEPTION


def hearing(*, standard: bool = True, extended: bool = True, error_frames: bool = True) -> Hearing:
    """What the bench's programs asked to hear."""
    return Hearing(LineMode(None, standard=standard, extended=extended, error_frames=error_frames))


class Bench:
    """A line that takes channels, and another node on its bus that takes down every frame."""

    def __init__(self, *, fd: bool = True, listen_only: bool = False, start: bool = True) -> None:
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.faults = Faults(self.bus, seed=0)
        self.line = self.node("line", fd=fd, listen_only=listen_only, start=start)
        self.other = self.node("other")
        self.listener = self.other.open(Channel(1 << 14, 64))

    def node(self, name: str, *, fd: bool = True, listen_only: bool = False, start: bool = True) -> Line:
        line = ideal_line(name, self.timeline)
        plug(line, self.bus)
        assert line.driver is not None
        line.driver.configure(LineSettings(NOMINAL, DATA if fd else None, listen_only=listen_only))
        if start:
            line.driver.start(0, integrated=True)
        return line

    def channel(self, receive: int = 64, transmit: int = 64, **options: object) -> Channel:
        """One whose rings another process writes and reads, as far as its line can tell."""
        channel = Channel(receive, transmit, rings=(ring(receive), ring(transmit)), **options)  # type: ignore[arg-type]
        channel.untrusted = True
        return self.line.open(channel)

    def put(self, channel: Channel, *records: bytes) -> None:
        """Write into the transmit ring, and ring the doorbell."""
        for block in records:
            assert channel.transmit.put_bytes(block)
        self.line.kick()

    def run(self, seconds: float = 1.0) -> None:
        self.timeline.run_until(self.timeline.now_ns + round(seconds * SECOND_NS))

    def heard(self) -> list[Frame]:
        """What the other node has received since it was asked last."""
        return self.listener.receive.take_frames(1 << 14)

    def occupy(self) -> None:
        """A frame of the other node goes on the wire first."""
        self.other.send(self.listener, Frame(0, bytes(8)))
        self.timeline.run_until(self.timeline.now_ns + 1_000)


def ring(capacity: int) -> Ring:
    return Ring(capacity, buffer=memoryview(bytearray(ring_size(rounded_capacity(capacity)))))


def record(id: int, info: int = 0, data: bytes = b"", time: int = 0) -> bytes:
    """80 bytes as a program may write them, right or wrong."""
    return (
        time.to_bytes(8, "little")
        + id.to_bytes(4, "little")
        + info.to_bytes(4, "little")
        + data.ljust(64, b"\xee")[:64]
    )


def dlc(code: int) -> int:
    return code << 16


def agree(channel: Channel) -> bool:
    parts = channel.delivered + channel.aborted + channel.refused + channel.pending()
    return bool(channel.sent + (channel.transmit.fill() if channel.untrusted else 0) == parts)


def infos(channel: Channel) -> list[tuple[int, int]]:
    """Identifier and info word of everything in the receive ring."""
    found = []
    while (block := channel.receive.take_bytes()) is not None:
        found.append((int.from_bytes(block[8:12], "little"), int.from_bytes(block[12:16], "little")))
    return found


# records that other processes write


@pytest.mark.conforms("X3-23")
@each("kind", [1, 2, 3, 5, 0x10, 0x11, 0xFF])
def test_what_is_no_data_frame_is_dropped_and_counted(kind: int) -> None:
    bench = Bench()
    channel = bench.channel()
    bench.put(channel, record(1), record(2, kind), record(3))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [1, 3]
    assert (channel.sent, channel.delivered, channel.refused) == (3, 2, 1)


@each(
    ("id", "info", "limits"),
    [
        pytest.param(0x800, 0, {}, id="11 bits"),
        pytest.param(0xFFFFFFFF, 0, {}, id="an event's identifier"),
        pytest.param(0x20000000, EXTENDED, {}, id="29 bits"),
        pytest.param(0x80000001, EXTENDED, {}, id="bit 31"),
        pytest.param(1, 0, {"standard": False}, id="no 11-bit frames"),
        pytest.param(1, EXTENDED, {"extended": False}, id="no 29-bit frames"),
        pytest.param(1, EDL | FDR, {"fast_data": False}, id="no switch"),
        pytest.param(1, FDR, {"fast_data": False}, id="no switch, and no FD"),
        pytest.param(1, EDL | dlc(9), {"long_data": False}, id="no long data"),
        pytest.param(1, EDL | FDR | dlc(15), {"long_data": False}, id="no long data, quickly"),
    ],
)
def test_what_the_line_must_not_send_is_refused(id: int, info: int, limits: dict[str, bool]) -> None:
    bench = Bench()
    for name in limits.keys() & {"long_data", "fast_data"}:
        setattr(bench.line, name, limits[name])
    bench.line.hear("", hearing(**{name: limits[name] for name in limits.keys() & {"standard", "extended"}}))
    channel = bench.channel()
    bench.put(channel, record(id, info))
    bench.run()
    assert bench.heard() == []
    assert (channel.sent, channel.refused, channel.pending(), channel.transmit.fill()) == (1, 1, 0, 0)


@each("info", [EDL, FDR, EDL | FDR, EDL | dlc(3)])
def test_a_classic_line_sends_no_fd_frames(info: int) -> None:
    bench = Bench(fd=False)
    channel = bench.channel()
    bench.put(channel, record(1, info), record(2))
    bench.run()
    assert bench.heard() == [Frame(2)]
    assert channel.refused == 1


@pytest.mark.conforms("X4-17")
@each(
    ("long_data", "fast_data", "passing"),
    [
        (True, True, ["plain", "switched", "long", "long and switched"]),
        (True, False, ["plain", "long"]),
        (False, True, ["plain", "switched"]),
        (False, False, ["plain"]),
    ],
)
@each("trusted", [False, True])
def test_long_data_and_the_switch_are_allowed_apart(
    long_data: bool, fast_data: bool, passing: list[str], trusted: bool
) -> None:
    frames = {
        "plain": Frame(1, bytes(8), fd=True),
        "switched": Frame(2, bytes(8), fd=True, bit_rate_switch=True),
        "long": Frame(3, bytes(12), fd=True),
        "long and switched": Frame(4, bytes(64), fd=True, bit_rate_switch=True),
    }
    bench = Bench()
    bench.line.long_data, bench.line.fast_data = long_data, fast_data
    refused = 0
    if trusted:
        channel = bench.line.open(Channel(8, 8))
        for name, frame in frames.items():
            if name in passing:
                bench.line.send(channel, frame)
            else:
                refused += 1
                with pytest.raises(LineError, match="set up without"):
                    bench.line.send(channel, frame)
    else:
        channel = bench.channel()
        bench.put(channel, *map(record_to_send, frames.values()))
    bench.run()
    assert bench.heard() == [frames[name] for name in passing]
    assert channel.refused + refused == len(frames) - len(passing)


@pytest.mark.parametrize("extended", [False, True])
def test_a_line_may_be_for_one_format_only(extended: bool) -> None:
    bench = Bench()
    bench.line.hear("", hearing(standard=extended, extended=not extended))
    channel = bench.line.open(Channel(8, 8))
    with pytest.raises(LineError, match=f"without {29 if extended else 11}-bit identifiers"):
        bench.line.send(channel, Frame(1, extended=extended))
    bench.line.send(channel, Frame(1, extended=not extended))
    bench.run()
    assert bench.heard() == [Frame(1, extended=not extended)]


@each("info", [EDL, FDR, EDL | FDR])
def test_a_channel_without_fd_sends_and_receives_none(info: int) -> None:
    bench = Bench()
    channel = bench.channel(siblings=int(Siblings.EVERY))
    channel.fd = False
    bench.put(channel, record(1, info | SRR), record(2, SRR))
    bench.other.send(bench.listener, Frame(3, fd=True))
    bench.other.send(bench.listener, Frame(4))
    other = bench.channel()
    bench.put(other, record(5, info | SRR))
    bench.run()
    assert sorted(frame.id for frame in bench.heard()) == [2, 5]
    assert sorted(id for id, _ in infos(channel)) == [2, 4]
    assert (channel.refused, channel.accepted) == (1, 2)


@pytest.mark.conforms("X4-16")
@each("info", [EDL, FDR, EDL | FDR])
def test_remote_is_ignored_where_fd_is_asked_for(info: int) -> None:
    bench = Bench()
    channel = bench.channel()
    bench.put(channel, record(0x123, info | REMOTE | dlc(3), b"abc"))
    bench.run()
    assert bench.heard() == [Frame(0x123, b"abc", fd=True, bit_rate_switch=bool(info & FDR))]


def test_a_remote_frame_has_no_data_and_keeps_its_length() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.put(channel, record(0x123, REMOTE | dlc(5), b"abcde"))
    bench.run()
    assert bench.heard() == [Frame(0x123, remote=True, dlc=5)]


def test_what_only_receivers_say_is_wiped_off() -> None:
    """Overrun, acceptance code, error state, confirmation: none of it is a sender's to set."""
    bench = Bench()
    channel = bench.channel()
    info = OVERRUN | 0xFF << ACCEPT_SHIFT | 1 << 12 | CONFIRM | 0b110 << 13 | SRR | dlc(2)
    bench.put(channel, record(0x123, info, b"ab"))
    bench.run()
    block = bench.listener.receive.take_bytes()
    assert block is not None
    assert block[8:] == record_to_send(Frame(0x123, b"ab"))[8:]
    assert [info & ~dlc(15) for _, info in infos(channel)] == [SRR]


@dataclass
class Limits:
    fd: bool
    standard: bool
    extended: bool
    long_data: bool
    fast_data: bool


def admitted(block: bytes, limits: Limits, longest_delay: int) -> Frame | None:
    """The frame that should go out for these bytes, read slowly from the manual's CANMSGINFO; None for none."""
    delay = int.from_bytes(block[:8], "little")
    id = int.from_bytes(block[8:12], "little")
    info = int.from_bytes(block[12:16], "little")
    bits = {bit for bit in range(32) if info >> bit & 1}
    fd, switch, remote, extended = bool(bits & {10, 11}), 11 in bits, 22 in bits, 23 in bits
    code = info >> 16 & 15
    if info % 256 != 0 or delay > longest_delay:
        return None
    if id >= (1 << 29 if extended else 1 << 11) or not (limits.extended if extended else limits.standard):
        return None
    if not fd:
        if remote:
            return Frame(id, extended=extended, remote=True, dlc=code)
        return Frame(id, block[16 : 16 + min(code, 8)], extended=extended, dlc=code)
    if not limits.fd or (switch and not limits.fast_data) or (code > 8 and not limits.long_data):
        return None
    data = block[16 : 16 + FD_LENGTHS[code]]
    return Frame(id, data, extended=extended, fd=True, bit_rate_switch=switch)


def mostly(value: int) -> st.SearchStrategy[bool]:
    return st.integers(0, 9).map(lambda drawn: (drawn > 0) == bool(value))


@st.composite
def nearly_records(draw: st.DrawFn) -> bytes:
    """80 bytes that are a frame to send but for a bit here and there."""
    extended = draw(st.booleans())
    id = draw(st.integers(0, (1 << 29) - 1 if extended else 0x7FF) | st.sampled_from([0x7FF, 0x800, 1 << 29]))
    info = draw(st.integers(0, 15)) << 16 | (EXTENDED if extended else 0)
    for bit in draw(st.sets(st.sampled_from([0, 3, 7, *range(8, 16), *range(20, 32)]), max_size=3)):
        info ^= 1 << bit
    time = draw(st.sampled_from([0, 0, 0, 1, 999, 2_000_000, 2_000_001, 1 << 31, 1 << 32, (1 << 64) - 1]))
    return record(id, info, draw(st.binary(min_size=64, max_size=64)), time)


@pytest.mark.conforms("X3-23", "X4-16", "X4-17")
@examples(150)
@given(
    st.lists(st.binary(min_size=80, max_size=80) | nearly_records(), max_size=12),
    st.builds(Limits, *[mostly(1)] * 5),
    st.sampled_from([8, 64]),
)
def test_whatever_stands_in_the_ring_only_frames_get_on_the_bus(
    blocks: list[bytes], limits: Limits, capacity: int
) -> None:
    """Every record is sent as the frame it is, or refused; nothing else happens, and the sums agree all the time."""
    bench = Bench(fd=limits.fd)
    bench.line.long_data, bench.line.fast_data = limits.long_data, limits.fast_data
    bench.line.hear("", hearing(standard=limits.standard, extended=limits.extended))
    channel = bench.channel(transmit=capacity)
    channel.longest_delay = 2_000_000
    expected = [frame for block in blocks if (frame := admitted(block, limits, channel.longest_delay))]
    for block in blocks:
        while not channel.transmit.free():
            bench.run(0.001)
        bench.put(channel, block)
        assert agree(channel)
    for _ in range(20):
        bench.run(0.005)
        assert agree(channel)
    got = []
    while (block := bench.listener.receive.take_bytes()) is not None:
        frame = frame_of_record(block)
        assert block[DATA_AT + len(frame.data) :] == bytes(64 - len(frame.data))
        assert int.from_bytes(block[12:16], "little") & 0xFF70F3FF & ~(REMOTE | EXTENDED | 0xF << 16) == 0
        got.append(frame)
    assert Counter(got) == Counter(expected)
    assert (channel.sent, channel.delivered) == (len(blocks), len(expected))
    assert (channel.refused, channel.aborted, channel.pending()) == (len(blocks) - len(expected), 0, 0)
    assert bench.other.controller.errors == 0


@pytest.mark.parametrize("busy", [False, True])
def test_more_rubbish_than_one_look_takes(busy: bool) -> None:
    """The frame behind it goes out by itself, and the bus is not kept waiting for it."""
    bench = Bench()
    channel = bench.channel(transmit=16384)
    bystander = bench.line.open(Channel(8, 8))
    for _ in range(10_000):
        channel.transmit.put_bytes(record(1, 0xFF))
    channel.transmit.put_bytes(record(2))
    bench.line.kick()
    assert channel.refused == 4096
    if busy:
        bench.line.send(bystander, Frame(3))
    bench.run(0.01)
    assert [frame.id for frame in bench.heard()] == ([3, 2] if busy else [2])
    assert (channel.refused, channel.sent) == (10_000, 10_001)


@pytest.mark.conforms("X3-18")
def test_whoever_comes_and_goes_gains_no_turn_by_it() -> None:
    bench = Bench()
    first, second, third = (bench.channel() for _ in range(3))
    bench.put(first, *[record(1)] * 10)
    bench.put(second, *[record(2)] * 10)
    bench.put(third, *[record(3)] * 10)
    order: list[int] = []
    while len(order) < 30:
        bench.run(40e-6)
        order += [frame.id for frame in bench.heard()]
        bench.line.close(bench.channel())
        bench.line.close(first)
        bench.line.open(first)
    assert [id for id in order if id != 1] == [2, 3] * 10
    assert all(order[:k].count(1) <= order[:k].count(2) + 1 for k in range(20))


def test_a_writer_that_never_stops_is_asked_to_signal_once() -> None:
    """The hub's end arms its ring when it has found it empty, and so hears of the next write."""
    rung: list[int] = []

    class Bell:
        def signal(self) -> None:
            rung.append(1)

        def wait_for(self, *_: object) -> bool:
            raise NotImplementedError

    bench = Bench()
    channel = bench.channel()
    channel.transmit.event = Bell()
    bench.line.kick()
    channel.transmit.put_bytes(record(1))
    channel.transmit.put_bytes(record(2))
    assert rung == [1]
    bench.line.kick()
    bench.run()
    channel.transmit.put_bytes(record(3))
    assert rung == [1, 1]


def test_a_hostile_fill_level_sends_nothing() -> None:
    bench = Bench()
    block = bytearray(ring_size(8))
    channel = Channel(8, 8, rings=(ring(8), Ring(8, buffer=memoryview(block))))
    channel.untrusted = True
    bench.line.open(channel)
    words = memoryview(block).cast("Q")
    for head, tail in ((9, 0), (0, 1), (1 << 63, 5), (2**64 - 1, 0)):
        words[8], words[16] = head, tail
        bench.line.kick()
        bench.run(0.01)
        assert bench.line.cancel(channel) == 0
    assert bench.heard() == []
    assert (channel.sent, channel.refused, channel.delivered) == (0, 0, 0)


# cancelling


def test_cancelling_gives_up_what_waits_and_counts_it() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.occupy()
    bench.put(channel, *(record(k, CONFIRM) for k in range(1, 6)))
    assert (channel.sent, channel.in_flight) == (1, 1)
    assert bench.line.cancel(channel) == 5
    bench.run()
    assert [frame.id for frame in bench.heard()] == []
    assert (channel.sent, channel.aborted, channel.pending()) == (5, 5, 0)
    assert agree(channel)


def test_what_is_on_the_wire_is_not_taken_back() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.put(channel, record(1), record(2))
    bench.run(10e-6)
    assert bench.line.cancel(channel) == 1
    bench.run()
    assert [frame.id for frame in bench.heard()] == [1]
    assert (channel.delivered, channel.aborted) == (1, 1)


# when nothing is loaded


def test_a_stopped_line_loads_nothing() -> None:
    bench = Bench(start=False)
    channel = bench.channel()
    bench.put(channel, record(1), record(2, 0xFF))
    bench.run()
    assert (channel.transmit.fill(), channel.sent, channel.refused, channel.pending()) == (2, 0, 0, 2)
    assert bench.line.driver is not None
    bench.line.driver.start(bench.timeline.now_ns)
    bench.run()
    assert bench.heard() == [Frame(1)]
    assert channel.refused == 1


def test_a_listen_only_line_loads_nothing() -> None:
    bench = Bench(listen_only=True)
    channel = bench.channel()
    trusted = bench.line.open(Channel(8, 8))
    bench.put(channel, record(1), record(2, 0xFF))
    bench.other.send(bench.listener, Frame(5))
    with pytest.raises(LineError, match="listen-only"):
        bench.line.send(trusted, Frame(1))
    bench.node("third")
    bench.run()
    assert (channel.transmit.fill(), channel.sent, channel.refused) == (2, 0, 0)
    assert channel.receive.take_frames(5) == [Frame(5)]


def test_a_line_that_is_held_loads_nothing() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.line.holding = True
    bench.put(channel, record(1), record(2))
    bench.run()
    assert (bench.heard(), channel.transmit.fill()) == ([], 2)
    bench.line.holding = False
    bench.line.kick()
    bench.run()
    assert [frame.id for frame in bench.heard()] == [1, 2]


def test_held_in_the_middle_only_the_frame_in_the_controller_goes_out() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.put(channel, record(1), record(2), record(3))
    bench.line.holding = True
    bench.run()
    assert [frame.id for frame in bench.heard()] == [1]
    assert channel.transmit.fill() == 2


# delays


@pytest.mark.conforms("X3-25", "X4-28")
@each("ticks", [1, 7, 100])
def test_a_delay_counts_ticks_from_the_end_of_the_frame_before(ticks: int) -> None:
    bench = Bench()
    channel = bench.channel()
    channel.tick_ns, channel.delay_tick_ns, channel.longest_delay = 1_000, 100_000, 100
    bench.put(channel, record(1), record(0x555, time=ticks), record(0x555))
    bench.run()
    first, second, third = (frame.timestamp_ns for frame in bench.heard())
    frame_ns = 45_000  # 44 bits of a frame without data, one of them followed by a stuffed one
    assert second - first == ticks * 100_000 + frame_ns
    assert third - second == frame_ns + 3_000


@pytest.mark.conforms("X3-25", "X4-28")
def test_more_than_the_longest_delay_is_refused() -> None:
    bench = Bench()
    channel = bench.channel()
    channel.tick_ns, channel.delay_tick_ns, channel.longest_delay = 1_000, 100_000, 65_535
    bench.put(channel, record(1), record(2, time=65_535), record(3, time=65_536), record(4, time=2**32 - 1))
    bench.run(10)
    assert [frame.id for frame in bench.heard()] == [1, 2]
    assert channel.refused == 2


def test_the_reserved_word_behind_ticks_does_not_count() -> None:
    """CANMSG2 has 32 bits of time and a reserved word (source: rulings.md 12)."""
    bench = Bench()
    channel = bench.channel()
    channel.tick_ns, channel.delay_tick_ns, channel.longest_delay = 1_000, 100_000, 10
    bench.put(channel, record(1), record(2, time=0xDEAD << 32 | 10))
    bench.run()
    first, second = bench.heard()
    assert second.timestamp_ns - first.timestamp_ns > 1_000_000


def test_a_delayed_frame_holds_up_nobody_else() -> None:
    bench = Bench()
    slow, quick = bench.channel(), bench.channel()
    bench.put(slow, record(1), record(2, time=SECOND_NS // 2), record(3))
    bench.put(quick, *(record(k) for k in range(0x10, 0x14)))
    bench.run(0.4)
    assert [frame.id for frame in bench.heard()] == [1, 0x10, 0x11, 0x12, 0x13]
    assert slow.pending() == 2
    bench.run()
    assert [frame.id for frame in bench.heard()] == [2, 3]


def test_a_delay_after_a_frame_that_is_given_up_ends_too() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.faults.flip(frame_id=1, bit=20, times=1)
    bench.put(channel, record(1, SSM), record(2, time=1_000_000))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [2]
    assert (channel.aborted, channel.delivered) == (1, 1)


# fairness


@pytest.mark.conforms("X3-18")
@each("count", [2, 3, 7])
@each("trusted", [0, 1])
def test_at_saturation_everybody_gets_the_same(count: int, trusted: int) -> None:
    bench = Bench()
    each = 40
    bench.occupy()
    for number in range(count):
        if number < trusted:
            channel = bench.line.open(Channel(8, 64))
            for _ in range(each):
                bench.line.send(channel, Frame(number + 1))
        else:
            bench.put(bench.channel(), *[record(number + 1)] * each)
    bench.run()
    sent = Counter({number + 1: 0 for number in range(count)})
    bench_heard = bench.heard()
    assert len(bench_heard) == count * each
    for frame in bench_heard:
        sent[frame.id] += 1
        assert max(sent.values()) - min(sent.values()) <= 1


@pytest.mark.conforms("X3-18")
def test_a_channel_that_comes_late_catches_up_with_nobody() -> None:
    bench = Bench()
    early, late = bench.channel(), bench.channel()
    bench.put(early, *[record(1)] * 30)
    while early.delivered < 10:
        bench.run(20e-6)
    bench.put(late, *[record(2)] * 10)
    bench.heard()
    bench.run()
    order = [frame.id for frame in bench.heard()]
    assert order[:20] in ([1, 2] * 10, [2, 1] * 10, [1, 1, *[2, 1] * 9])


# priorities and single shots


@pytest.mark.conforms("X4-25")
def test_high_priority_goes_before_what_waits_in_the_controller() -> None:
    bench = Bench()
    normal, urgent = bench.channel(), bench.channel()
    bench.occupy()
    bench.put(normal, record(1), record(2))
    bench.put(urgent, record(3, HPM))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [3, 1, 2]


@pytest.mark.conforms("X4-25")
def test_it_overtakes_nothing_in_its_own_queue() -> None:
    """But the one frame that waits in the controller's other mailbox by then."""
    bench = Bench()
    channel = bench.channel()
    bench.occupy()
    bench.put(channel, record(1), record(2), record(3), record(4, HPM), record(5))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [1, 2, 4, 3, 5]


@pytest.mark.conforms("X4-24")
def test_a_single_shot_that_loses_arbitration_is_discarded() -> None:
    bench = Bench()
    channel = bench.channel(events=frozenset({EventKind.ARBITRATION_LOST, EventKind.ABORTED}))
    bench.line.holding = True
    channel.transmit.put_bytes(record(0x100, SSM))
    channel.transmit.put_bytes(record(0x101))
    bench.occupy()
    bench.line.holding = False
    bench.line.kick()
    bench.other.send(bench.listener, Frame(0x0FF))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [0x101]
    assert (channel.sent, channel.delivered, channel.aborted, channel.pending()) == (2, 1, 1, 0)
    kinds = [info & 0xFF for _, info in infos(channel) if info & 0xFF]
    assert kinds == [EventKind.ARBITRATION_LOST, EventKind.ABORTED]


@pytest.mark.conforms("X4-24")
def test_a_single_shot_that_meets_an_error_is_discarded() -> None:
    bench = Bench()
    channel = bench.channel(events=frozenset({EventKind.ERROR, EventKind.ABORTED}))
    bench.faults.flip(frame_id=0x100, bit=20, times=1)
    bench.put(channel, record(0x100, SSM), record(0x101, SSM))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [0x101]
    assert (channel.sent, channel.delivered, channel.aborted) == (2, 1, 1)
    assert [info & 0xFF for _, info in infos(channel)] == [EventKind.ERROR, EventKind.ABORTED]


def test_without_single_shot_it_is_repeated() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.faults.flip(frame_id=0x100, bit=20, times=2)
    bench.put(channel, record(0x100))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [0x100]
    assert (channel.delivered, channel.aborted) == (1, 0)


# self-reception


def rejecting() -> MessageFilter:
    """Lets 0x100 in, nothing else."""
    filter = message_filter(FilterMode.INCLUSIVE, 2048, FilterMode.INCLUSIVE, 2048)
    filter.standard.set_pattern(0x100 << 1, 0xFFF)
    return filter


MARKED, UNMARKED = SRR, 0
# what a channel gets of its own frames and of its siblings': asked for or not, accepted by its filter or not
GETS: dict[Siblings, dict[tuple[str, bool, bool], int]] = {
    Siblings.OWN_FILTERED: {("own", True, True): MARKED, ("sibling", True, True): MARKED},
    Siblings.ALL: {(who, True, passes): MARKED for who in ("own", "sibling") for passes in (True, False)},
    Siblings.OWN: {("own", True, passes): MARKED for passes in (True, False)},
    Siblings.AS_BUS: {
        ("own", True, True): MARKED, ("own", True, False): MARKED, ("sibling", True, True): UNMARKED
    },
    Siblings.EVERY: {(who, asked, True): MARKED for who in ("own", "sibling") for asked in (True, False)},
    Siblings.OTHERS: {("sibling", asked, True): UNMARKED for asked in (True, False)},
    Siblings.OTHERS_AND_OWN: {
        (who, asked, True): mark for who, mark in (("own", MARKED), ("sibling", UNMARKED)) for asked in (True, False)
    },
}  # fmt: skip


@pytest.mark.conforms("X4-26", "X4-27", "X3-24")
@each("kind", list(Siblings))
@each("passes", [True, False])
@each("asked", [True, False])
@each("who", ["own", "sibling"])
def test_who_gets_a_line_s_own_frames_back(kind: Siblings, passes: bool, asked: bool, who: str) -> None:
    bench = Bench()
    tried, sibling = bench.channel(siblings=int(kind)), bench.channel()
    tried.filter = rejecting()
    id = 0x100 if passes else 0x101
    bench.put(tried if who == "own" else sibling, record(id, SRR if asked else 0))
    bench.run()
    assert [frame.id for frame in bench.heard()] == [id]
    expected = GETS[kind].get((who, asked, passes))
    got = infos(tried)
    assert [(found, info & SRR) for found, info in got] == ([] if expected is None else [(id, expected)])
    assert tried.accepted == len(got)


@pytest.mark.conforms("X3-24", "X4-26")
def test_it_comes_back_only_once_it_was_really_sent() -> None:
    bench = Bench()
    channel = bench.channel(siblings=int(Siblings.OWN))
    bench.occupy()
    bench.put(channel, record(1, SRR))
    while not channel.receive.fill():
        bench.run(10e-6)
    assert channel.receive.take_frames(5) == [Frame(0, bytes(8))]  # the other's, as it came first
    bench.run()
    (own,) = channel.receive.take_frames(5)
    (heard,) = bench.heard()
    assert (own.id, own.timestamp_ns) == (1, heard.timestamp_ns)


@pytest.mark.conforms("X4-33")
def test_acceptance_codes_of_frames_that_come_back() -> None:
    """Past the filter: ALWAYS; through it: what the filter says."""
    codes = {}
    for kind in (Siblings.ALL, Siblings.OWN, Siblings.AS_BUS, Siblings.EVERY):
        bench = Bench()
        channel = bench.channel(siblings=int(kind))
        channel.filter = rejecting()
        bench.put(channel, record(0x100, SRR))
        bench.run()
        codes[kind] = [info >> ACCEPT_SHIFT for _, info in infos(channel)]
    assert codes == {
        Siblings.ALL: [ALWAYS],
        Siblings.OWN: [ALWAYS],
        Siblings.AS_BUS: [ALWAYS],
        Siblings.EVERY: [BY_PATTERN],
    }


# the chain of filters


def one_filter(mode: FilterMode) -> MessageFilter:
    """Pattern 0x100, list 0x101."""
    filter = message_filter(mode, 2048, mode, 2048)
    filter.standard.set_pattern(0x100 << 1, 0xFFF)
    filter.standard.add(0x101 << 1, 0xFFF)
    return filter


@pytest.mark.conforms("X4-33", "X4-34")
@each(
    ("line", "channel", "codes"),
    [
        (None, None, {0x100: 0, 0x101: 0, 0x102: 0}),
        (None, FilterMode.PASS, {0x100: ALWAYS, 0x101: ALWAYS, 0x102: ALWAYS}),
        (None, FilterMode.INCLUSIVE, {0x100: BY_PATTERN, 0x101: BY_LIST}),
        (None, FilterMode.EXCLUSIVE, {0x102: NOT_EXCLUDED}),
        (None, FilterMode.LOCK, {}),
        (FilterMode.INCLUSIVE, FilterMode.PASS, {0x100: BY_PATTERN, 0x101: BY_LIST}),
        (FilterMode.EXCLUSIVE, FilterMode.PASS, {0x102: NOT_EXCLUDED}),
        (FilterMode.PASS, FilterMode.INCLUSIVE, {0x100: BY_PATTERN, 0x101: BY_LIST}),
        (FilterMode.EXCLUSIVE, FilterMode.INCLUSIVE, {}),
        (FilterMode.INCLUSIVE, FilterMode.EXCLUSIVE, {}),
        (FilterMode.LOCK, FilterMode.PASS, {}),
        (FilterMode.PASS, FilterMode.PASS, {0x100: ALWAYS, 0x101: ALWAYS, 0x102: ALWAYS}),
    ],
)
@each("alone", [True, False])
def test_the_line_s_filter_then_the_channel_s(
    line: FilterMode | None, channel: FilterMode | None, codes: dict[int, int], alone: bool
) -> None:
    bench = Bench()
    tried = bench.channel(events=frozenset({EventKind.STATE}))
    if not alone:
        bench.channel()
    tried.filter = None if channel is None else one_filter(channel)
    bench.line.hear("", replace(hearing(), filter=None if line is None else one_filter(line)))
    for id in (0x100, 0x101, 0x102):
        bench.other.send(bench.listener, Frame(id))
    bench.run()
    assert {id: info >> ACCEPT_SHIFT for id, info in infos(tried)} == codes
    assert bench.line.driver is not None
    bench.line.driver.stop(bench.timeline.now_ns)  # whatever is no data frame passes every filter
    assert [(info & 0xFF, info >> ACCEPT_SHIFT) for _, info in infos(tried)] == [(EventKind.STATE, ALWAYS)]


# losses


@pytest.mark.conforms("X4-32")
def test_the_first_frame_after_an_overflow_is_marked() -> None:
    bench = Bench()
    channel = bench.channel(receive=2, events=frozenset({EventKind.STATE}))

    def come(*ids: int) -> None:
        for id in ids:
            bench.other.send(bench.listener, Frame(id))
        bench.run(0.01)

    def got() -> list[tuple[int, bool]]:
        return [(id, bool(info & OVERRUN)) for id, info in infos(channel) if not info & 0xFF]

    come(1, 2)
    assert got() == [(1, False), (2, False)]
    come(3, 4, 5, 6)
    assert got() == [(3, False), (4, False)]
    come(7, 8)
    assert got() == [(7, True), (8, False)]
    assert (channel.accepted, channel.lost) == (8, 2)
    come(9, 10, 11)
    assert len(infos(channel)) == 2
    assert bench.line.driver is not None
    bench.line.driver.stop(bench.timeline.now_ns)
    bench.line.driver.start(bench.timeline.now_ns)
    assert got() == []  # events are not marked
    come(12)
    assert got() == [(12, True)]


def test_lost_events_count_and_mark_too() -> None:
    bench = Bench()
    channel = bench.channel(receive=1, events=frozenset({EventKind.INFO}))
    for _ in range(3):
        bench.line.tell(BusEvent(EventKind.INFO, 0, code=1))
    assert (channel.accepted, channel.lost, len(infos(channel))) == (3, 2, 1)
    bench.other.send(bench.listener, Frame(1))
    bench.run()
    assert [bool(info & OVERRUN) for _, info in infos(channel)] == [True]


def test_a_client_cannot_forge_the_line_s_count_of_losses() -> None:
    bench = Bench()
    block = bytearray(ring_size(1))
    channel = Channel(1, 0, rings=(Ring(1, buffer=memoryview(block)), None))
    bench.line.open(channel)
    for id in (1, 2, 3):
        bench.other.send(bench.listener, Frame(id))
    bench.run()
    memoryview(block).cast("Q")[9] = 2**64 - 1
    assert channel.lost == 2


def test_a_full_receive_ring_is_nobody_else_s_loss() -> None:
    bench = Bench()
    small, large = bench.channel(receive=1), bench.channel(receive=64)
    for id in range(10):
        bench.other.send(bench.listener, Frame(id))
    bench.run()
    assert (small.accepted, small.lost) == (10, 9)
    assert (large.accepted, large.lost, large.receive.fill()) == (10, 0, 10)


# ticks


@pytest.mark.conforms("X3-34")
def test_stamps_count_ticks_since_the_origin() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.run(0.5)
    channel.tick_ns, channel.origin_ns = 1_000, bench.timeline.now_ns
    bench.other.send(bench.listener, Frame(0x555))
    bench.run()
    (frame,) = channel.receive.take_frames(2)
    assert frame.timestamp_ns == 45  # us
    assert channel.receive.lost == 0


@pytest.mark.conforms("X3-34")
def test_stamps_wrap_at_32_bits() -> None:
    bench = Bench()
    channel = bench.channel()
    channel.tick_ns = 1_000
    bench.timeline.run_until((1 << 32) * 1_000 - 60_000)
    for _ in range(2):
        bench.other.send(bench.listener, Frame(0x555))
    bench.run()
    first, second = (frame.timestamp_ns for frame in channel.receive.take_frames(2))
    assert (first, second) == ((1 << 32) - 60 + 45, 33)


def test_nanoseconds_do_not_wrap() -> None:
    bench = Bench()
    channel = bench.channel()
    bench.timeline.run_until(1 << 40)
    bench.other.send(bench.listener, Frame(0x555))
    bench.run()
    assert channel.receive.take_frames(2)[0].timestamp_ns == (1 << 40) + 45_000


# events


def test_error_events_stay_inside_where_nobody_wants_them() -> None:
    bench = Bench()
    channel = bench.channel(events=frozenset({EventKind.ERROR}))
    bench.faults.flip(frame_id=5, bit=20, times=1)
    bench.line.hear("", hearing(error_frames=False))
    bench.other.send(bench.listener, Frame(5))
    bench.run()
    assert [info & 0xFF for _, info in infos(channel)] == [0]
    bench.line.hear("", hearing())
    bench.faults.flip(frame_id=5, bit=20, times=1)
    bench.other.send(bench.listener, Frame(5))
    bench.run()
    block = channel.receive.take_bytes()
    assert block is not None
    event = BusEvent.from_record(block)
    assert (event.kind, event.transmitting) == (EventKind.ERROR, False)
    assert event.error != ErrorKind.NONE


def test_so_many_records_are_queued_as_fit() -> None:
    bench = Bench()
    channel = bench.channel(transmit=8)
    frames = frames_to_array([Frame(number) for number in range(10)])
    bench.occupy()
    queued = [bench.line.send_records(channel, part, 0) for part in (frames[:5], frames[5:], frames[8:])]
    assert queued == [5, 4, 0]  # one more than the ring holds: the first is in the controller
    bench.run()
    assert [frame.id for frame in bench.heard()] == list(range(9))
    assert bench.line.send_records(bench.channel(), frames[:2], HIGH_PRIORITY) == 2
