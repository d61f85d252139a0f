"""The bench's promises: names, time, queues, and what it says when asked for the impossible."""

from __future__ import annotations

import inspect
import math

import pytest

import canwire
from canwire import (
    Acceptance,
    BadFilter,
    BadFrame,
    BadTiming,
    BadValue,
    BitTiming,
    ChannelMode,
    Closed,
    ErrorState,
    EventKind,
    Frame,
    Lab,
    LabBus,
    LabNode,
    LineMode,
    NodeScript,
    NotIdle,
    NotReceived,
    QueueFull,
    record_dtype,
)
from tests.cases import each

pytestmark = pytest.mark.core

numpy = pytest.importorskip("numpy")
C04 = Frame(0x123, b"\x11\x22")  # 62 bits
C04_NS = 62 * 2000
C08 = Frame(0x2AA, b"\xaa" * 8)  # 108 bits
C08_NS = 108 * 2000


# the names


def test_the_example_of_the_readme() -> None:
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
        a, b = bus.node("engine"), bus.node("tester", filters=[(0x100, 0x700)])
        a.send(canwire.Frame(0x123, b"\x11\x22"))
        lab.run_until_idle()
        frame = b.receive()
        assert frame == canwire.Frame(0x123, b"\x11\x22")
        assert frame is not None
        assert frame.timestamp_ns == C04_NS
        assert b.receive() is None
        assert b.receive(timeout=0.1) is None
        assert b.receive_many(1000) == []
        assert b.receive_array().shape == (0,)
        assert (a.state, a.tec, a.rec, b.lost) == (ErrorState.ERROR_ACTIVE, 0, 0, 0)
        assert 0 < bus.load < 1
        assert lab.now_ns == C04_NS + 100_000_000
        bus.faults.flip(frame_id=0x123, bit=20, times=1)
        bus.faults.disconnect(a)
        bus.faults.noise(bit_error_rate=1e-5)


@pytest.mark.core
@pytest.mark.finding("faults 6")
def test_a_node_that_starts_in_the_first_microsecond() -> None:
    """The bits it has waited for may begin before there was any time."""
    with canwire.Lab() as lab:
        bus = lab.can_bus("c", bit_rate=125_000)
        a, b = bus.node("a"), bus.node("b")
        a.send(canwire.Frame(1, b"x"))
        lab.run_for(1e-6)
        a.start()
        lab.run_for(0.02)
        assert [frame.id for frame in b.receive_many(10)] == [1]


@pytest.mark.core
@pytest.mark.finding("faults 6")
def test_the_same_alone() -> None:
    with canwire.Lab() as lab:
        a = lab.can_bus("c", bit_rate=125_000).node("a")
        a.send(canwire.Frame(1, b"x"))
        lab.run_for(1e-6)
        a.start()
        lab.run_for(0.02)
        assert a.tec > 0


PINNED = {
    Frame.__init__: "id data=b'' * extended remote fd bit_rate_switch error_state_indicator dlc timestamp_ns",
    Lab.__init__: "* time seed",
    Lab.can_bus: "name * bit_rate data_bit_rate timing data_timing iso_fd length_m node_delay_ns",
    Lab.run_for: "seconds",
    Lab.run_until: "time_ns",
    Lab.run_until_idle: "",
    LabBus.node: "name script * filters listen_only self_reception receives bit_rate timing data_timing fd iso_fd"
    " oscillator_ppm receive_queue transmit_queue",
    LabNode.send: "frame * single_shot high_priority delay_ns",
    LabNode.receive: "timeout",
    LabNode.receive_many: "limit",
    LabNode.receive_array: "limit",
    LabNode.expect: "id * within extended data",
    LabNode.expect_nothing: "* within",
}


@each("function", [key for key in PINNED if key is not Frame.__init__])
def test_names_of_arguments_are_pinned(function: object) -> None:
    parameters = inspect.signature(function).parameters.values()  # type: ignore[arg-type]
    positional = [p.name for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD and p.name != "self"]
    keywords = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]
    first, _, second = PINNED[function].partition("*")  # type: ignore[index]
    assert positional[: len(first.split())] == first.split()
    assert set(second.split()) <= set(keywords)


def test_arguments_of_a_frame() -> None:
    frame = Frame(
        id=1, data=b"", extended=True, remote=True, fd=False, bit_rate_switch=False, dlc=4, timestamp_ns=5
    )
    assert (frame.id, frame.dlc, frame.timestamp_ns) == (1, 4, 5)
    with pytest.raises(TypeError):
        Frame(1, b"", True)  # type: ignore[misc]


# time


def test_time_begins_at_0_and_passes_only_when_asked(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(C04)
    assert (lab.now_ns, b.receive()) == (0, None)
    lab.run_for(seconds=0.5)
    assert lab.now_ns == 500_000_000
    lab.run_for(0)
    assert lab.now_ns == 500_000_000


def test_run_until_includes_its_moment(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(C04)
    lab.run_until(C04_NS - 1)
    assert (b.waiting, lab.now_ns) == (0, C04_NS - 1)
    lab.run_until(C04_NS)
    assert (b.waiting, lab.now_ns) == (1, C04_NS)


def test_run_until_the_past_changes_nothing(lab: Lab) -> None:
    lab.run_for(1.0)
    lab.run_until(5)
    assert lab.now_ns == 10**9


@pytest.mark.parametrize("seconds", [-1, -1e-9, math.nan, math.inf])
def test_run_for_says_what_is_wrong(lab: Lab, seconds: float) -> None:
    with pytest.raises(BadValue, match="seconds"):
        lab.run_for(seconds)
    assert lab.now_ns == 0


def test_run_until_idle_stops_with_the_last_frame(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    lab.run_until_idle()
    assert lab.now_ns == 0
    a.send_many([C04, C08])
    lab.run_until_idle()
    assert lab.now_ns == C04_NS + 3 * 2000 + C08_NS
    assert b.waiting == 2


def test_run_until_idle_waits_for_timers_but_not_for_periodic_ones(lab: Lab, can_bus: LabBus) -> None:
    a, _ = can_bus.node("a"), can_bus.node("b")
    lab.at(2_000_000_000, lambda: a.send(C04))
    lab.at(3_000_000_000, lambda: None, background=True)
    lab.run_until_idle()
    assert lab.now_ns == 2_000_000_000 + C04_NS
    assert a.delivered == 1


def test_timers_run_in_order_of_time_then_as_scheduled(lab: Lab) -> None:
    order: list[str] = []
    lab.at(20, lambda: order.append("c"))
    lab.at(10, lambda: order.append("a"))
    lab.at(20, lambda: order.append("d"))
    lab.at(10, lambda: order.append("b"))
    cancelled = lab.at(15, lambda: order.append("never"))
    cancelled.cancel()
    cancelled.cancel()
    lab.run_until(20)
    assert "".join(order) == "abcd"


def test_a_timer_in_the_past_runs_now(lab: Lab) -> None:
    lab.run_for(1.0)
    seen: list[int] = []
    lab.at(5, lambda: seen.append(lab.now_ns))
    lab.run_for(0)
    assert seen == [10**9]


def test_an_exception_in_a_callback_surfaces_where_time_passes(lab: Lab) -> None:
    def broken() -> None:
        raise RuntimeError("mine")

    lab.at(10, broken)
    with pytest.raises(RuntimeError, match="mine"):
        lab.run_for(1.0)
    lab.run_for(1.0)
    assert lab.now_ns >= 10**9


def test_a_lone_sender_is_not_idle(lab: Lab, can_bus: LabBus) -> None:
    can_bus.node("engine").send(C04)
    with pytest.raises(NotIdle) as caught:
        lab.run_until_idle()
    text = str(caught.value)
    assert "can0" in text
    assert "engine (ERROR_PASSIVE, TEC 128) repeats its frame" in text


def test_a_shorted_bus_is_not_idle(lab: Lab, can_bus: LabBus) -> None:
    can_bus.node("a")
    can_bus.faults.short()
    with pytest.raises(NotIdle, match="shorted"):
        lab.run_until_idle()


def test_buses_run_on_one_timeline_and_do_not_hear_each_other(lab: Lab) -> None:
    fast, slow = lab.can_bus("fast", bit_rate=1_000_000), lab.can_bus("slow", bit_rate=125_000)
    a, b = fast.node("a"), fast.node("b")
    c, d = slow.node("a"), slow.node("b")
    a.send_many([C08] * 3)
    c.send(C04)
    lab.run_until_idle()
    assert [frame.timestamp_ns for frame in b.receive_many(9)] == [108_000, 219_000, 330_000]
    assert [frame.timestamp_ns for frame in d.receive_many(9)] == [62 * 8000]
    assert (fast.frames, slow.frames) == (3, 1)


# receiving


def test_receive_with_a_timeout_goes_exactly_to_the_arrival(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many([C04, C08])
    assert b.receive(timeout=1.0) == C04
    assert lab.now_ns == C04_NS
    assert b.receive(timeout=1.0) == C08
    assert lab.now_ns == C04_NS + 6_000 + C08_NS
    assert b.receive(timeout=0.25) is None
    assert lab.now_ns == C04_NS + 6_000 + C08_NS + 250_000_000


def test_each_wait_lets_programs_of_the_labs_hub_send(lab: Lab, can_bus: LabBus) -> None:
    node, hub = can_bus.node("node"), lab.hub()
    board = hub.plug("usb-to-can", buses=(can_bus.name, ""))
    control = hub.open_control(board.id, 0)
    control.initialise(LineMode(BitTiming.for_bit_rate(500_000, clock_hz=8_000_000)))
    control.start()
    channel = hub.open_channel(board.id, 0)
    channel.set_up(ChannelMode(16, 16))
    channel.activate()
    for id in range(4):
        channel.send(Frame(id))
        heard = node.receive(1.0)
        assert heard is not None
        assert heard.id == id


def test_receive_takes_what_is_there_without_passing_time(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(C04)
    lab.run_for(1.0)
    assert b.receive(timeout=1.0) == C04
    assert lab.now_ns == 10**9


def test_a_timeout_at_the_very_end_of_a_frame(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(C04)
    assert b.receive(timeout=(C04_NS - 1) / 1e9) is None
    assert b.receive(timeout=1e-9) == C04


def test_a_timeout_of_0_lets_no_time_pass(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(C04)
    assert b.receive(timeout=0.0) is None
    assert lab.now_ns == 0


def test_waiting_leaves_frames_of_others_alone(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    a.send_many([C04, C08])
    lab.at(C04_NS - 1, lambda: c.send(Frame(0x1)))
    assert b.receive(timeout=1.0) == C04
    lab.run_until_idle()
    assert (a.receive(), b.receive(), c.receive()) == (Frame(0x1), Frame(0x1), C04)


def test_receive_many_takes_up_to_its_limit(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many(Frame(k) for k in range(10))
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(3)] == [0, 1, 2]
    assert b.receive_many(0) == []
    assert [frame.id for frame in b.receive_many(100)] == list(range(3, 10))


@pytest.mark.parametrize("limit", [-1, -100])
def test_a_negative_limit_takes_nothing(lab: Lab, can_bus: LabBus, limit: int) -> None:
    """It must not give back to the ring what was never taken."""
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many(Frame(k) for k in range(4))
    lab.run_until_idle()
    b.receive_many(2)
    for take in (b.receive_many, b.receive_array):
        try:
            taken = take(limit)
        except BadValue:
            continue
        assert len(taken) == 0
    assert [frame.id for frame in b.receive_many(100)] == [2, 3]
    assert b.accepted == 4


def test_receive_array_is_the_frames_as_records(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    frames = [
        C04,
        Frame(0x12345678, b"\x01", extended=True),
        Frame(0x7F0, remote=True, dlc=4),
        Frame(0x2, bytes(range(64)), fd=True, bit_rate_switch=True),
        Frame(0x1, bytes(12), fd=True),
    ]
    a.send_many(frames)
    lab.run_until_idle()
    records, received = b.receive_array(), c.receive_many(9)
    assert records.dtype == record_dtype()
    assert records.dtype.itemsize == 80
    assert received == frames
    for record, frame in zip(records, received, strict=True):
        assert int(record["id"]) == frame.id
        assert int(record["time_ns"]) == frame.timestamp_ns
        assert bytes(record["data"])[: len(frame.data)] == frame.data
        assert not any(bytes(record["data"])[len(frame.data) :])


def test_receive_array_up_to_a_limit(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many(Frame(k) for k in range(10))
    lab.run_until_idle()
    assert list(b.receive_array(4)["id"]) == [0, 1, 2, 3]
    assert list(b.receive_array()["id"]) == [4, 5, 6, 7, 8, 9]
    assert len(b.receive_array()) == 0


def test_records_stay_as_they_were_when_more_frames_come(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b", receive_queue=4)
    a.send_many(Frame(k) for k in range(4))
    lab.run_until_idle()
    records = b.receive_array()
    a.send_many(Frame(0x700 + k) for k in range(4))
    lab.run_until_idle()
    assert list(records["id"]) == [0, 1, 2, 3]


def test_send_array_sends_what_receive_array_gave(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    frames = [C04, Frame(0x2, bytes(64), fd=True, bit_rate_switch=True), Frame(0x7F0, remote=True, dlc=4)]
    a.send_many(frames)
    lab.run_until_idle()
    records = b.receive_array()
    c.receive_many(9)
    records["time_ns"] = 0
    assert b.send_array(records) == 3
    lab.run_until_idle()
    assert c.receive_many(9) == frames
    assert (b.sent, b.delivered) == (3, 3)


def test_send_array_takes_as_many_as_fit(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a", transmit_queue=4), can_bus.node("b")
    records = numpy.zeros(10, record_dtype())
    records["id"] = range(10)
    count = a.send_array(records)
    assert 4 <= count < 10
    assert a.sent == count
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(99)] == list(range(count))


def test_send_array_refuses_what_is_no_frame(can_bus: LabBus) -> None:
    a = can_bus.node("a")
    records = numpy.zeros(3, record_dtype())
    records["id"] = (1, 2, 0x800)
    with pytest.raises(BadFrame, match="record 2"):
        a.send_array(records)
    assert (a.sent, a.pending) == (0, 0)
    with pytest.raises(TypeError, match="dtype"):
        a.send_array(numpy.zeros(3))


# queues


def test_a_full_transmit_queue_says_so_and_loses_nothing(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a", transmit_queue=4), can_bus.node("b")
    queued = 0

    def fill() -> None:
        nonlocal queued
        for k in range(100):
            a.send(Frame(k))
            queued += 1

    with pytest.raises(QueueFull, match="can0/a: transmit queue full, 4 frames wait") as caught:
        fill()
    assert caught.value.capacity == 4
    assert queued >= 4
    assert a.sent == a.pending == queued
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(999)] == list(range(queued))
    a.send(Frame(0x700))
    lab.run_until_idle()
    assert b.receive() == Frame(0x700)


def test_send_many_keeps_what_came_before_the_queue_was_full(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a", transmit_queue=8), can_bus.node("b")
    with pytest.raises(QueueFull):
        a.send_many(Frame(k) for k in range(100))
    queued = a.sent
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(999)] == list(range(queued))


OVERRUN = 1 << 20  # of a record's info


def test_frames_for_a_full_queue_are_counted_and_marked(lab: Lab, can_bus: LabBus) -> None:
    """The next frame that finds room says that some are missing before it."""
    a, b, c = can_bus.node("a"), can_bus.node("b", receive_queue=4), can_bus.node("c")
    a.send_many(Frame(k) for k in range(10))
    lab.run_until_idle()
    assert (b.accepted, b.waiting, b.lost) == (10, 4, 6)
    assert (c.waiting, c.lost) == (10, 0)
    first = b.receive_array()
    a.send_many([Frame(0x7F0), Frame(0x7F1)])
    lab.run_until_idle()
    second = b.receive_array()
    assert list(first["id"]) == [0, 1, 2, 3]
    assert list(second["id"]) == [0x7F0, 0x7F1]
    marked = [bool(info & OVERRUN) for info in [*first["info"], *second["info"]]]
    assert marked == [False] * 4 + [True, False]
    assert (b.accepted, b.lost) == (12, 6)


# expectations


def test_expect_finds_its_frame_among_others(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many([Frame(1), Frame(2, b"\x01"), Frame(2, b"\x02"), Frame(2, extended=True), Frame(3)])
    assert b.expect(2, within=0.1, data=b"\x02").data == b"\x02"
    assert b.expect(2, within=0.1, extended=True).extended
    assert b.expect(3, within=0.1) == Frame(3)


def test_expect_says_what_came_instead(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(Frame(0x77, b"\x01"))
    with pytest.raises(NotReceived, match=r"no frame 0x78 within 0\.05 s; 1 others, last: Frame\(0x077"):
        b.expect(0x78, within=0.05)
    assert lab.now_ns == 50_000_000
    with pytest.raises(AssertionError, match="0 others, last: nothing"):
        b.expect(0x78, within=0.05)


def test_expect_does_not_wait_longer_than_within(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    lab.at(30_000_000, lambda: a.send(Frame(1)))
    with pytest.raises(NotReceived):
        b.expect(1, within=0.02)
    assert lab.now_ns == 20_000_000
    b.expect(1, within=0.02)


def test_expect_nothing(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    b.expect_nothing(within=0.1)
    assert lab.now_ns == 100_000_000
    a.send(C04)
    with pytest.raises(NotReceived, match="arrived where silence was expected"):
        b.expect_nothing(within=0.1)


# what is wrong, and what is over


def test_names_are_taken_once(lab: Lab, can_bus: LabBus) -> None:
    can_bus.node("a")
    with pytest.raises(BadValue, match="'a' already"):
        can_bus.node("a")
    with pytest.raises(BadValue, match="'can0' already"):
        lab.can_bus("can0")
    other = lab.can_bus("can1")
    assert other.node("a").name == "a"
    assert set(lab.buses) == {"can0", "can1"}
    assert set(can_bus.nodes) == {"a"}


def test_wrong_values_are_named(lab: Lab, can_bus: LabBus) -> None:
    with pytest.raises(BadValue, match="time 'slow'"):
        Lab(time="slow")
    with pytest.raises(BadTiming, match="bit_rate 0"):
        lab.can_bus("x", bit_rate=0)
    with pytest.raises(BadTiming, match="1234567"):
        lab.can_bus("x", bit_rate=1_234_567)
    with pytest.raises(BadValue, match="length_m -1"):
        lab.can_bus("x", length_m=-1)
    with pytest.raises(BadValue, match="node_delay_ns -5"):
        lab.can_bus("x", node_delay_ns=-5)
    with pytest.raises(BadTiming, match="oscillator_ppm"):
        can_bus.node("x", oscillator_ppm=1e6)
    with pytest.raises(BadFilter, match="0x800"):
        can_bus.node("x", filters=[(0x800, 0x7FF)])
    with pytest.raises(BadValue, match="0"):
        can_bus.node("x", receive_queue=0)
    # whatever was refused has left nothing behind
    assert set(lab.buses) == {"can0"}
    assert can_bus.nodes == {}
    a, b = can_bus.node("x"), can_bus.node("y")
    a.send(C04)
    assert b.receive(timeout=0.1) == C04


@pytest.mark.parametrize("delay_ns", [-1, -(10**9), 1 << 64])
def test_an_impossible_delay_is_named(can_bus: LabBus, delay_ns: int) -> None:
    a = can_bus.node("a")
    with pytest.raises(BadValue, match="delay_ns"):
        a.send(C04, delay_ns=delay_ns)
    assert (a.sent, a.pending) == (0, 0)


def test_closing_twice_is_fine() -> None:
    lab = Lab()
    bus = lab.can_bus()
    a = bus.node("a")
    a.close()
    a.close()
    bus.close()
    bus.close()
    lab.close()
    lab.close()
    with Lab() as other:
        other.close()


def closed_bench() -> tuple[Lab, LabBus, LabNode]:
    lab = Lab()
    bus = lab.can_bus()
    a, b = bus.node("a"), bus.node("b")
    b.send(C04)
    lab.run_until_idle()
    lab.close()
    return lab, bus, a


@pytest.mark.parametrize(
    "use",
    [
        lambda lab, bus, node: lab.can_bus("x"),
        lambda lab, bus, node: lab.run_for(0.1),
        lambda lab, bus, node: lab.run_until(10**10),
        lambda lab, bus, node: lab.run_until_idle(),
        lambda lab, bus, node: lab.at(10**10, print),
        lambda lab, bus, node: bus.node("x"),
        lambda lab, bus, node: node.send(C04),
        lambda lab, bus, node: node.send_many([C04]),
        lambda lab, bus, node: node.send_array(numpy.zeros(1, record_dtype())),
        lambda lab, bus, node: node.start(),
        lambda lab, bus, node: node.restart(),
        lambda lab, bus, node: (node.receive_many(99), node.receive(timeout=0.1)),
    ],
    ids=["can_bus", "run_for", "run_until", "run_until_idle", "at", "node", "send", "send_many", "send_array",
         "start", "restart", "receive"],
)  # fmt: skip
def test_what_is_closed_says_so(use: object) -> None:
    lab, bus, node = closed_bench()
    with pytest.raises(Closed, match="is closed"):
        use(lab, bus, node)  # type: ignore[operator]


def test_counters_of_what_is_closed_can_still_be_read() -> None:
    lab, bus, a = closed_bench()
    assert (a.state, a.tec, a.rec, a.accepted, a.lost) == (ErrorState.STOPPED, 0, 0, 1, 0)
    assert (bus.frames, bus.error_frames, lab.now_ns) == (1, 0, C04_NS)
    assert a.receive() == C04
    assert a.events() == []
    assert isinstance(bus.load, float)


def test_a_closed_node_leaves_the_others_running(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    b.close()
    a.send(C04)
    lab.run_until_idle()
    assert (a.delivered, b.waiting, c.waiting) == (1, 0, 1)
    with pytest.raises(Closed):
        b.send(C04)


def test_stop_keeps_the_queue_and_start_goes_on(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.stop()
    a.stop()
    a.send_many([C04, C08])
    lab.run_for(0.01)
    assert (a.state, a.pending, b.waiting) == (ErrorState.STOPPED, 2, 0)
    a.start()
    lab.run_until_idle()
    assert b.receive_many(9) == [C04, C08]


def test_a_node_stopped_in_the_middle_of_its_frame(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    a.send(C08)
    lab.run_until(C08_NS // 2)
    a.stop()
    lab.run_for(0.01)
    assert (b.waiting, c.waiting, a.pending) == (0, 0, 1)
    assert b.rec > 0
    a.start()
    lab.run_until_idle()
    assert (b.receive_many(9), c.receive_many(9)) == ([C08], [C08])


def test_events_begin_with_the_first_call_and_can_be_chosen(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.inject("bit", times=2)
    a.send(C04)
    lab.run_for(0.000_1)
    assert a.events() == []
    lab.run_until_idle()
    assert [event.kind for event in a.events(EventKind.ERROR)] == [EventKind.ERROR]
    a.stop()
    assert a.events(EventKind.ERROR) == []
    assert b.receive() == C04


def test_filters_by_acceptance(lab: Lab, can_bus: LabBus) -> None:
    a = can_bus.node("a")
    b = can_bus.node("b", filters=Acceptance.everything())
    c = can_bus.node("c", filters=Acceptance.nothing())
    a.send(C04)
    lab.run_until_idle()
    assert (b.accepted, c.accepted, c.waiting, c.lost) == (1, 0, 0, 0)


def test_own_timings(lab: Lab) -> None:
    timing = BitTiming.from_btr(0x00, 0x1C)
    bus = lab.can_bus(timing=timing)
    assert bus.timing is timing
    a, b = bus.node("a"), bus.node("b", timing=BitTiming.for_bit_rate(500_000, 0.8))
    a.send(C04)
    assert b.receive(timeout=0.1) == C04


def test_the_last_frames_of_a_bus(lab: Lab) -> None:
    bus = lab.can_bus()
    a, b = bus.node("a"), bus.node("b")
    assert bus.recent() == []
    bus.remember(2)
    a.send_many([Frame(1), Frame(2)])
    b.send(Frame(0))
    lab.run_until_idle()
    assert bus.recent() == [("a", Frame(1)), ("a", Frame(2))]


def test_repr_shows_the_state(can_bus: LabBus) -> None:
    assert repr(can_bus.node("engine")) == "<node can0/engine: ERROR_ACTIVE, TEC 0, REC 0>"


# the same again


class Chatter(NodeScript):
    def __init__(self, id: int, period_s: float) -> None:
        self.id = id
        self.period_s = period_s
        self.count = 0

    def on_start(self) -> None:
        self.every(self.period_s, self.speak)

    def speak(self) -> None:
        self.count += 1
        self.send(Frame(self.id, self.count.to_bytes(8, "big")))

    def on_message(self, frame: Frame) -> None:
        if frame.data[-1] == 0 and frame.id < 0x700:
            self.send(Frame(0x700 | frame.id & 0xFF, frame.data[-2:]))


def log_of_a_run(seed: int) -> str:
    """Some 50 % load for two seconds, answers, noise, a node cut off, one that goes bus-off and comes back."""
    with Lab(seed=seed) as lab:
        bus = lab.can_bus(bit_rate=500_000)
        logger = bus.node("logger", receive_queue=65_536)
        nodes = [bus.node(f"n{k}", Chatter(0x100 + k, 0.001_5 + 0.000_1 * k)) for k in range(4)]
        for node in nodes:
            node.events()
        bus.faults.noise(1e-5)
        lab.at(500_000_000, lambda: bus.faults.disconnect(nodes[1]))
        lab.at(700_000_000, lambda: bus.faults.reconnect(nodes[1]))
        lab.at(
            900_000_000,
            lambda: bus.faults.flip(frame_id=0x102, bit="dlc", times=33, seen_by="sender") and None,
        )
        lab.at(1_200_000_000, nodes[2].restart)
        lab.run_for(2.0)
        lines = [repr(frame) for frame in logger.receive_many(1 << 20)]
        lines += [repr(event) for node in nodes for event in node.events()]
        lines += [repr((node, node.counters, node.pending)) for node in nodes]
        return "\n".join([*lines, repr((bus.load, bus.mean_load, bus.frames, bus.error_frames, lab.now_ns))])


@pytest.mark.conforms("G-17")
def test_a_script_that_runs_twice_gives_identical_logs() -> None:
    """Byte by byte. How much faster than real time an hour at 50 % load is, the benchmark shows."""
    log = log_of_a_run(7)
    assert log == log_of_a_run(7)
    assert log != log_of_a_run(8)
    assert log.count("\n") > 2000
    assert "BUS_OFF" in log


@pytest.mark.finding("newcomer F12")
class TestWhatWouldNotWork:
    def test_a_data_phase_slower_than_the_rest(self, lab: Lab) -> None:
        with pytest.raises(
            BadTiming, match="data bit rate 250000 bit/s: not below the bit rate, 500000; leave it out"
        ):
            lab.can_bus(bit_rate=500_000, data_bit_rate=250_000)
        assert lab.can_bus(bit_rate=500_000, data_bit_rate=500_000).data_timing is not None
        with pytest.raises(BadTiming, match="data bit rate 500000 bit/s: not below the bit rate, 1000000"):
            lab.buses["can0"].node("a", bit_rate=1_000_000)

    def test_names_of_python_can(self, lab: Lab) -> None:
        with pytest.raises(
            TypeError,
            match=r"can_bus\(\) has no argument 'bitrate': what python-can calls bitrate is bit_rate",
        ):
            lab.can_bus(bitrate=500_000)  # type: ignore[arg-type]
        with pytest.raises(
            TypeError, match=r"node\(\) has no argument 'receive_own_messages': .* is self_reception here"
        ):
            lab.can_bus().node("a", receive_own_messages=True)  # type: ignore[arg-type]
        with pytest.raises(
            TypeError, match=r"node\(\) has no argument 'listen_onyl'; did you mean 'listen_only'"
        ):
            lab.buses["can0"].node("a", listen_onyl=True)  # type: ignore[arg-type]


def test_a_closed_node_leaves_nothing_behind(lab: Lab, can_bus: LabBus) -> None:
    """Its name is free, the wire knows nothing of it, and no bus grows with those that came and went."""
    a, b = can_bus.node("a"), can_bus.node("b")
    for _ in range(3):
        guest = can_bus.node("guest")
        lab.run_for(0.001)  # 11 recessive bits, and it takes part
        a.send(C04)
        lab.run_until_idle()
        assert guest.receive() == b.receive() == C04
        guest.close()
        guest.close()
        with pytest.raises(Closed):
            guest.send(C04)
        assert (guest.lost, guest.waiting) == (0, 0)
    assert list(can_bus.nodes) == ["a", "b"]
    assert len(can_bus.wire.nodes) == 2


def test_a_node_that_closes_as_it_hears_a_frame_hides_it_from_nobody(lab: Lab, can_bus: LabBus) -> None:
    nodes = [can_bus.node(name) for name in "abcde"]
    nodes[1].on_frames(nodes[1].close)
    nodes[3].on_frames(nodes[3].close)
    for _ in range(2):
        nodes[0].send(C04)
        lab.run_until_idle()
    assert [node.waiting for node in nodes] == [0, 1, 2, 1, 2]
    assert list(can_bus.nodes) == ["a", "c", "e"]


def test_a_sender_that_closes_in_the_middle_of_its_frame(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    a.send(C04)
    lab.run_for(50e-6)
    a.close()
    lab.run_for(0.001)
    b.send(C04)
    lab.run_until_idle()
    assert (b.delivered, c.waiting) == (1, 1)


def test_a_closed_node_whose_plug_was_pulled(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.disconnect(b)
    b.close()
    assert can_bus.node("b") is not b
    a.send(C04)
    lab.run_until_idle()
    assert a.delivered == 1


def test_nodes_of_a_closed_lab_can_still_be_looked_at() -> None:
    with Lab() as lab:
        bus = lab.can_bus()
        node = bus.node("a")
    assert bus.nodes == {"a": node}


def test_a_bus_says_what_could_not_work_on_copper() -> None:
    fast = BitTiming.for_bit_rate(4_000_000, 0.8)
    with Lab() as lab:
        bus = lab.can_bus("can0", timing=BitTiming.for_bit_rate(500_000, 0.875), data_timing=fast)
        bus.node("one")
        assert bus.warnings == []
        other = bus.node("other", timing=BitTiming.for_bit_rate(500_000, 0.75))
        assert [warning.what for warning in bus.warnings] == ["sample points"]
        other.close()
        assert bus.warnings == []
        bus.node("slow", oscillator_ppm=20_000)
        assert [warning.what for warning in bus.warnings] == ["oscillators"]
