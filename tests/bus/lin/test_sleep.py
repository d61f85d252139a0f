"""Sleep by command and by idleness, wake-up pulses and their repetition."""

from __future__ import annotations

from itertools import pairwise

import pytest

from canwire import Lab, LabLinNode, LinErrorKind, LinEventKind, LinFrame, LinState
from tests.cases import each

pytestmark = pytest.mark.core

BIT_NS = 50_000
SECOND = 1_000_000_000


def seen(node: LabLinNode) -> list[tuple[str, int]]:
    """Kinds of events and their times in microseconds; errors by their own kind."""
    return [
        (
            event.error.name if event.kind is LinEventKind.ERROR else event.kind.name,
            event.timestamp_ns // 1000,
        )
        for event in node.events()
        if event.kind is not LinEventKind.STATE
    ]


def test_the_go_to_sleep_command_puts_everybody_to_sleep() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        nodes = [bus.master(), bus.slave("a"), bus.slave("b")]
        for node in nodes:
            node.events()
        nodes[0].sleep()
        lab.run_until_idle()
        assert [node.state for node in nodes] == [LinState.ASLEEP] * 3
        assert [seen(node) for node in nodes] == [[("SLEEP", 6200)]] * 3
        frame = nodes[1].receive()
        assert frame == LinFrame(0x3C, b"\0" + b"\xff" * 7)
        lab.run_for(20)
        assert [seen(node) for node in nodes] == [[]] * 3  # asleep nobody minds the silence


def test_only_the_first_byte_of_the_command_counts() -> None:
    """PT-CT 52.2."""
    with Lab() as lab:
        bus = lab.lin_bus()
        slave, master = bus.slave(), bus.master()
        master.send(LinFrame(0x3C, bytes(range(8))))
        lab.run_until_idle()
        assert slave.state is LinState.ASLEEP


@each("frame", [LinFrame(0x3C, b"\1" + bytes(7)), LinFrame(0x3D, bytes(8)), LinFrame(0, bytes(8))])
def test_other_frames_do_not(frame: LinFrame) -> None:
    with Lab() as lab:
        bus = lab.lin_bus()
        slave = bus.slave()
        bus.master().send(frame)
        lab.run_until_idle()
        assert slave.state is LinState.OPERATIONAL


@pytest.mark.conforms("X4-45")
@pytest.mark.parametrize("bitwise", [False, True])
def test_four_seconds_without_an_edge(bitwise: bool) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.wire.bitwise = bitwise
        slave, master = bus.slave(responses={1: b"\xff"}), bus.master()
        slave.events()
        master.ask(1)
        lab.run_for(10)
        # the checksum of 01 with FF is 0x3E: its last edge is where its stop bit begins
        assert LinFrame(1, b"\xff").checksum == 0x3E
        edge_us = (34 + 10 + 9) * 50
        assert seen(slave) == [("NOBUS", edge_us + 4_000_000), ("SLEEP", edge_us + 4_000_000)]
        assert master.state is LinState.ASLEEP


def test_a_bus_that_was_silent_all_along() -> None:
    with Lab() as lab:
        bus = lab.lin_bus()
        slave = bus.slave()
        slave.events()
        lab.run_for(3)
        late = bus.slave("late")
        late.events()
        lab.run_for(10)
        assert seen(slave) == [("NOBUS", 4_000_000), ("SLEEP", 4_000_000)]
        assert seen(late) == [("NOBUS", 7_000_000), ("SLEEP", 7_000_000)]


@pytest.mark.parametrize(("sleep_after", "state"), [(0.5, LinState.ASLEEP), (None, LinState.OPERATIONAL)])
def test_another_idle_time_or_none(sleep_after: float | None, state: LinState) -> None:
    with Lab() as lab:
        slave = lab.lin_bus(sleep_after=sleep_after).slave()
        lab.run_for(1.0)
        assert slave.state is state


def test_a_schedule_keeps_the_bus_awake() -> None:
    with Lab() as lab:
        bus = lab.lin_bus()
        slave = bus.slave()
        bus.master(schedule=[(0x10, 3.0)])
        lab.run_for(60)
        assert slave.state is LinState.OPERATIONAL


def test_a_shorted_wire_has_no_edges() -> None:
    with Lab() as lab:
        bus = lab.lin_bus()
        slave = bus.slave()
        slave.events()
        lab.run_for(1)
        bus.faults.short()
        lab.run_for(5)
        assert seen(slave) == [("NOBUS", 5_000_000), ("SLEEP", 5_000_000)]


def asleep(lab: Lab, start_up: float = 0.0) -> list[LabLinNode]:
    bus = lab.lin_bus(bit_rate=20_000)
    nodes = [bus.master(responses={9: b"\7"}), bus.slave("a", start_up=start_up), bus.slave("b")]
    lab.run_until(SECOND // 10)
    nodes[0].sleep()
    lab.run_until(SECOND)
    assert [node.state for node in nodes] == [LinState.ASLEEP] * 3
    for node in nodes:
        node.events()
    return nodes


@each("rate", [1000, 2400, 9600, 19200, 20000])
def test_the_pulse_has_250_us_to_5_ms(rate: int) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=rate)
        slave = bus.slave()
        changes: list[tuple[int, int]] = []
        bus.wire.bits.capture = lambda at_ps, level: changes.append((at_ps // 1000, level))
        slave.wake()
        lab.run_until_idle()
        (fell, _), (rose, _) = changes
        assert 250_000 <= rose - fell <= 5_000_000


def test_a_slave_wakes_everybody_up() -> None:
    with Lab() as lab:
        master, a, b = asleep(lab)
        b.wake()
        lab.run_until_idle()
        assert [node.state for node in (master, a, b)] == [LinState.OPERATIONAL] * 3
        assert seen(master) == seen(a) == [("WAKEUP", 1_000_250)]
        assert a.counters.wake_ups == 1
        master.send(LinFrame(9, b"\7"))
        assert a.expect(9, within=0.1).data == b"\7"


def test_a_pulse_is_repeated_until_a_header_comes() -> None:
    """150 to 250 ms apart, after three pulses 1.5 s; and so on."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave()
        slave.events()
        falls: list[int] = []
        bus.wire.bits.capture = lambda at_ps, level: level or falls.append(at_ps // 1_000_000)
        slave.wake()
        lab.run_for(4.5)
        gaps = [later - earlier for earlier, later in pairwise(falls)]
        assert gaps[:5] == [200_500, 200_500, 1_500_500, 200_500, 200_500]
        assert [kind for kind, _ in seen(slave)] == ["WAKEUP"] * 3  # nobody answered
        master = bus.master()
        master.send(LinFrame(1, b"\1"))
        lab.run_until_idle()
        falls.clear()
        lab.run_for(3)
        assert falls == []


def test_repetition_does_not_keep_the_bench_busy() -> None:
    with Lab() as lab:
        slave = lab.lin_bus().slave()
        slave.wake()
        lab.run_until_idle()
        assert lab.now_ns < 1_000_000


def test_a_master_may_wake_the_bus_by_a_header() -> None:
    """Its break wakes the slaves, which miss this header and hear the next."""
    with Lab() as lab:
        master, a, _ = asleep(lab)
        master.send(LinFrame(9, b"\1"))
        master.send(LinFrame(9, b"\2"))
        lab.run_until_idle()
        assert [frame.data for frame in a.receive_many(9) if frame.id == 9] == [b"\2"]


def test_a_master_s_own_pulse() -> None:
    with Lab() as lab:
        master, a, _ = asleep(lab)
        master.wake()
        master.send(LinFrame(9, b"\1"))
        lab.run_until_idle()
        assert a.expect(9, within=0.1).data == b"\1"
        lab.run_for(1)
        assert a.counters.wake_ups == 1  # a master does not repeat it


def test_a_woken_slave_needs_its_time() -> None:
    with Lab() as lab:
        master, slow, quick = asleep(lab, start_up=0.05)
        quick.wake()
        lab.run_for(0.001)
        assert (slow.state, quick.state) == (LinState.INITIALISING, LinState.OPERATIONAL)
        master.send(LinFrame(9, b"\1"))
        lab.run_for(0.06)
        assert slow.state is LinState.OPERATIONAL
        master.send(LinFrame(9, b"\2"))
        lab.run_until_idle()
        assert [frame.data for frame in slow.receive_many(9) if frame.id == 9] == [b"\2"]
        assert [frame.data for frame in quick.receive_many(9) if frame.id == 9] == [b"\1", b"\2"]
        states = [event.state for event in slow.events(LinEventKind.STATE)]
        assert states == [LinState.INITIALISING, LinState.OPERATIONAL]


def test_pulses_of_two_at_once() -> None:
    with Lab() as lab:
        master, a, b = asleep(lab)
        a.wake()
        b.wake()
        lab.run_until_idle()
        assert master.state is LinState.OPERATIONAL
        assert master.counters.wake_ups == 1


def test_too_short_a_pulse_wakes_nobody() -> None:
    with Lab() as lab:
        master, a, _ = asleep(lab)
        for span_ns, state in ((150_000, LinState.ASLEEP), (151_000, LinState.OPERATIONAL)):
            a.bus.faults.short()
            lab.run_until(lab.now_ns + span_ns)
            a.bus.faults.clear_short()
            lab.run_until_idle()
            assert (master.state, a.state) == (state, state)


def test_nobody_answers_a_wake_up() -> None:
    with Lab() as lab:
        slave = lab.lin_bus().slave()
        slave.wake()
        lab.run_for(1.0)
        assert slave.line.status().errors[LinErrorKind.WAKEUP] == 1
