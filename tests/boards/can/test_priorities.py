"""Frames that wait by priority, those given up at an error, and those that come back at once."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BitTiming, EventKind, Frame
from canwire.boards.can.backlog import ROOM, Backlog
from canwire.boards.can.channel import ALL_REQUESTS, Channel
from canwire.boards.can.line import Line
from canwire.boards.catalogue import ideal_line, mcp2515_line, plug, sja1000_line
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.drivers.driver import LineSettings
from canwire.ring import Ring, ring_size, rounded_capacity
from canwire.timeline import Timeline
from canwire.values.frame import record_to_send
from canwire.values.record import ABORT_ON_ERROR, LOOP_BACK, SELF_RECEPTION
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

TIMING = BitTiming.for_bit_rate(500_000, clock_hz=8_000_000)
MAKERS = {"ideal": ideal_line, "sja1000": sja1000_line, "mcp2515": mcp2515_line}


class Bench:
    """A line of one kind, and a node that acknowledges and takes everything down."""

    def __init__(self, kind: str, *, alone: bool = False) -> None:
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.faults = Faults(self.bus, seed=0)
        self.line = self._started(MAKERS[kind]("line", self.timeline))
        self.heard = Channel(1 << 12, 0)
        if not alone:
            self._started(ideal_line("other", self.timeline)).open(self.heard)
        self.timeline.run_until(1_000_000)

    def _started(self, line: Line) -> Line:
        plug(line, self.bus)
        line.driver.configure(LineSettings(TIMING))
        line.driver.start(0)
        return line

    def channel(self, *, events: tuple[int, ...] = (), receive: int = 64, transmit: int = 512) -> Channel:
        rings = [
            Ring(size, buffer=memoryview(bytearray(ring_size(rounded_capacity(size)))))
            for size in (receive, transmit)
        ]
        channel = Channel(receive, transmit, rings=(rings[0], rings[1]), events=frozenset(events))
        channel.untrusted = channel.prioritised = True
        channel.allowed = ALL_REQUESTS
        return self.line.open(channel)

    def run(self) -> None:
        self.timeline.run_until(self.timeline.now_ns + 1_000_000_000)

    def ids(self) -> list[int]:
        return [frame.id for frame in self.heard.receive.take_frames(1 << 12)]


def queue(channel: Channel, id: int, priority: int, flags: int = 0) -> None:
    channel.transmit.put_bytes(record_to_send(Frame(id, b"\1"), flags, priority << 32))


@pytest.fixture(params=list(MAKERS))
def bench(request: pytest.FixtureRequest) -> Bench:
    return Bench(request.param)


@pytest.mark.conforms("AC-31")
def test_the_lowest_priority_number_goes_first_whoever_sent_it(bench: Bench) -> None:
    one, two = bench.channel(), bench.channel()
    for channel, id, priority in (
        (one, 1, 9),
        (one, 2, 9),
        (two, 3, 0),
        (one, 4, 255),
        (two, 5, 10),
        (two, 6, 1),
    ):
        queue(channel, id, priority)
    bench.line.kick()
    bench.run()
    assert bench.ids() == [3, 6, 1, 2, 5, 4]
    assert (one.delivered, two.delivered, one.in_flight, two.in_flight) == (3, 3, 0, 0)


@examples(60)
@given(st.lists(st.tuples(st.integers(0, 255), st.integers(0, 2)), max_size=60), st.integers(0, 2))
def test_a_backlog_is_a_sorted_queue(pushed: list[tuple[int, int]], dropped: int) -> None:
    backlog, channels = Backlog(), [Channel(1, 1) for _ in range(3)]
    for number, (priority, owner) in enumerate(pushed):
        backlog.push(priority, number.to_bytes(80, "little"), channels[owner])
    rest = [(priority, number) for number, (priority, owner) in enumerate(pushed) if owner != dropped]
    assert backlog.drop(channels[dropped]) == len(pushed) - len(rest)
    assert backlog.room(channels[dropped]) == ROOM
    for _, number in sorted(rest):
        assert int.from_bytes(backlog.front()[0], "little") == number
        backlog.pop()
    assert len(backlog) == 0


def test_a_channel_that_floods_keeps_its_own_frames_waiting_only(bench: Bench) -> None:
    flood, other = bench.channel(transmit=1024), bench.channel()
    for number in range(1000):
        queue(flood, number, 5)
    bench.line.kick()
    assert flood.transmit.fill() >= 1000 - ROOM - 1
    queue(other, 0x7FF, 4)
    bench.line.kick()
    bench.timeline.run_until(bench.timeline.now_ns + 1_000_000)
    assert 0x7FF in bench.ids()
    bench.run()
    assert flood.delivered == 1000


def test_cancelled_frames_are_counted(bench: Bench) -> None:
    channel = bench.channel()
    for number in range(10):
        queue(channel, number, 3)
    bench.line.kick()
    bench.timeline.run_until(bench.timeline.now_ns + 20_000)  # the first one is on the wire
    bench.line.cancel(channel)
    bench.run()
    assert bench.ids() == [0]
    assert (channel.sent, channel.delivered, channel.aborted, channel.in_flight) == (10, 1, 9, 0)


@pytest.mark.conforms("AC-33")
@each("kind", MAKERS)
def test_a_lone_sender_gives_up_at_the_first_error(kind: str) -> None:
    bench = Bench(kind, alone=True)
    channel = bench.channel(events=(EventKind.ERROR,))
    queue(channel, 0x123, 1, ABORT_ON_ERROR)
    bench.line.kick()
    bench.run()
    assert (channel.aborted, channel.delivered) == (1, 0)
    assert bench.line.driver.counters().tec == 8
    assert channel.receive.fill() == 1


@each("kind", MAKERS)
def test_a_lost_arbitration_is_no_error(kind: str) -> None:
    bench = Bench(kind)
    channel, rival = bench.channel(), ideal_line("rival", bench.timeline)
    plug(rival, bench.bus)
    rival.driver.configure(LineSettings(TIMING))
    rival.driver.start(bench.timeline.now_ns, integrated=True)
    sender = rival.open(Channel(16, 16))
    bench.timeline.at(bench.timeline.now_ns + 1000, lambda: rival.send(sender, Frame(0x001, b"")))
    bench.timeline.at(bench.timeline.now_ns + 1000, bench.line.kick)
    queue(channel, 0x123, 1, ABORT_ON_ERROR)
    bench.run()
    assert bench.ids() == [0x001, 0x123]
    assert bench.line.driver.counters().arbitration_losses == 1


@pytest.mark.conforms("AC-32")
def test_a_frame_that_loops_back_arrives_at_once_and_once(bench: Bench) -> None:
    sender, sibling = bench.channel(), bench.channel()
    queue(sender, 0x123, 0, LOOP_BACK)
    bench.line.kick()
    for channel in (sender, sibling):
        assert [frame.id for frame in channel.receive.take_frames(9)] == [0x123]
    bench.run()
    assert (sender.receive.fill(), sibling.receive.fill()) == (0, 0)
    assert bench.ids() == [0x123]


def test_self_reception_is_on_the_wire_first(bench: Bench) -> None:
    sender = bench.channel()
    queue(sender, 0x123, 0, SELF_RECEPTION)
    bench.line.kick()
    assert sender.receive.fill() == 0
    bench.run()
    assert sender.receive.fill() == 1


def test_what_the_line_cannot_send_is_refused(bench: Bench) -> None:
    channel = bench.channel()
    channel.transmit.put_bytes(record_to_send(Frame(0x1, b"\1" * 12, fd=True)))
    queue(channel, 2, 0)
    bench.line.kick()
    bench.run()
    assert bench.ids() == [2]
    assert (channel.sent, channel.refused, channel.delivered) == (2, 1, 1)
