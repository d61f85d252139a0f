"""What the wire does around frames: starting, recovery, intermission, flags, synchronisation."""

from __future__ import annotations

from functools import partial

import pytest

from canwire import ErrorState, Frame, Lab, LabBus, LabNode
from canwire.bus.can import station as states
from canwire.bus.can.bits import measure
from canwire.bus.can.clock import Clock
from canwire.bus.can.node import FLAG_BIT_ERROR_RECEIVER, FLAG_BIT_ERROR_TRANSMITTER, Mailbox, Node
from canwire.bus.can.station import Station
from canwire.bus.can.tally import Tally
from canwire.values.frame import record_of_frame
from tests.bus.can.test_two_ways import start_with_counters
from tests.cases import each

pytestmark = pytest.mark.core

BIT_NS = 2_000
C04 = Frame(0x123, b"\x11\x22")  # 62 bits


class Recorder(Node):
    """A node that writes down what the bus tells it."""

    def __init__(self) -> None:
        super().__init__()
        self.on_bus = True
        self.told: list[tuple[object, ...]] = []

    def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
        self.told.append(("error", kind, bit, transmitting))

    def count(self, rule: int, at_ns: int) -> None:
        self.told.append(("count", rule))
        self.passive = self.passive or rule in (FLAG_BIT_ERROR_RECEIVER, FLAG_BIT_ERROR_TRANSMITTER)

    def received(self, box: Mailbox, at_ns: int) -> None:
        self.told.append(("received",))

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        self.told.append(("transmitted",))


def offered(frame: Frame) -> Mailbox:
    """A mailbox with this frame, ready to go."""
    box = Mailbox()
    box.block[:] = record_of_frame(frame)
    measure(box, 0)
    return box


# joining


@each(("octet", "rate"), [(0xAA, 1), (0xCC, 2), (0x55, 1), (0xF0, 4)])
@each("late_us", [50, 100, 150, 250])
@pytest.mark.finding("wire 1")
def test_a_node_that_starts_in_a_data_phase_waits_for_its_end(octet: int, rate: int, late_us: int) -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000, data_bit_rate=rate * 1_000_000)
        a, b = bus.node("a"), bus.node("b")
        late = bus.node("late")
        late.stop()
        lab.run_until(100_000)
        frame = Frame(0x123, bytes([octet]) * 64, fd=True, bit_rate_switch=True)
        a.send(frame)
        lab.at(100_000 + late_us * 1_000, late.start)
        lab.run_until_idle()
        assert (bus.error_frames, a.tec, b.receive_many(9), late.receive_many(9)) == (0, 0, [frame], [])
        a.send(C04)
        lab.run_until_idle()
        assert late.receive_many(9) == [C04]


# recovery


@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.finding("wire 2")
def test_a_short_during_recovery_keeps_the_groups_counted(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a, _ = can_bus.node("a"), can_bus.node("b")
    bus_off(lab, can_bus, a)
    began_ns = lab.now_ns
    a.restart()
    lab.at(began_ns + 100 * 11 * BIT_NS + 3 * BIT_NS, can_bus.faults.short)
    lab.at(began_ns + 100 * 11 * BIT_NS + 4 * BIT_NS, can_bus.faults.clear_short)
    lab.run_until(began_ns + 1_405 * BIT_NS)
    assert a.state is ErrorState.BUS_OFF
    lab.run_until(began_ns + 1_450 * BIT_NS)
    assert a.state is ErrorState.ERROR_ACTIVE


# intermission


@each("quarter", range(4 * 61, 4 * 66))
@pytest.mark.finding("wire 3")
def test_a_short_around_the_intermission_does_the_same_with_and_without_a_trace(quarter: int) -> None:
    outcomes = [shorted_at(quarter * BIT_NS // 4, bitwise) for bitwise in (False, True)]
    assert outcomes[0] == outcomes[1]


@each("bit", [62, 63])
@each("bitwise", [False, True])
@pytest.mark.finding("wire 3")
def test_a_short_in_the_intermission_makes_an_overload_frame(bit: int, bitwise: bool) -> None:
    times, errors = shorted_at(bit * BIT_NS, bitwise)
    assert errors == 0
    assert times[0] == 62 * BIT_NS
    assert times[1] in (
        (bit + 79) * BIT_NS,
        (bit + 80) * BIT_NS,
    )  # flag of 6, delimiter of 8, intermission of 3


def shorted_at(from_ns: int, bitwise: bool) -> tuple[list[int], int]:
    """When two queued frames end, with the wires shorted for one bit; error frames."""
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        bus.wire.bitwise = bitwise
        a, b, _ = (bus.node(name) for name in "abc")
        a.send_many([C04, C04])
        lab.at(from_ns, bus.faults.short)
        lab.at(from_ns + BIT_NS, bus.faults.clear_short)
        lab.run_until_idle()
        return [frame.timestamp_ns for frame in b.receive_many(9)], bus.error_frames


@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.finding("wire 4")
def test_who_joins_an_sof_in_the_third_bit_is_not_left_behind(
    lab: Lab, can_bus: LabBus, bitwise: bool
) -> None:
    """A pending sender joins it, and sees an error frame: then the lowest identifier goes first."""
    can_bus.wire.bitwise = bitwise
    a, b, c = (can_bus.node(name) for name in "abc")
    c.send(C04)
    lab.at(10 * BIT_NS, partial(a.send, Frame(0x010)))
    lab.at(70 * BIT_NS, partial(b.send, Frame(0x700)))
    lab.at(64 * BIT_NS, can_bus.faults.short)
    lab.at(74 * BIT_NS, can_bus.faults.clear_short)
    lab.run_until_idle()
    assert [frame.id for frame in c.receive_many(9)] == [0x010, 0x700]


@pytest.mark.finding("wire 8")
def test_an_sof_behind_the_last_sample_of_the_intermission_is_joined() -> None:
    """The pending sender's own SOF begins at the edge; one that has nothing to send receives."""
    for offer in (offered(C04), None):
        node = Recorder()
        clock = in_third_bit(node)
        node.offer = offer
        clock.station.sample(1)
        clock.sampled(clock.due_ps)
        clock.edge(clock.start_ps + 1_900_000)
        clock.begin_bit(clock.due_ps)
        station = clock.station
        assert station.transmitting == (offer is not None)
        assert station.out == (0 if offer is not None else 1)
        assert clock.start_ps == 5_900_000
        station.sample(0)
        assert station.state == states.FRAME


def in_third_bit(node: Node) -> Clock:
    """Its clock, at the third bit of an intermission that began at 0."""
    clock = Clock(Station(node, Tally()), 0)
    clock.station.state = states.INTERMISSION
    clock.station.left = 1
    clock.begin_bit(4_000_000)
    return clock


# flags


@each("transmitting", [False, True])
@each("overload", [False, True])
@each("disturbed", range(1, 7))
@pytest.mark.finding("wire 6")
def test_a_bit_error_in_a_flag_begins_another(transmitting: bool, overload: bool, disturbed: int) -> None:
    node = Recorder()
    station = Station(node, Tally())
    into_flag(station, transmitting, overload)
    levels = [drive(station, 1 if k == disturbed else 0) for k in range(1, 21)]
    rule = FLAG_BIT_ERROR_TRANSMITTER if transmitting else FLAG_BIT_ERROR_RECEIVER
    assert ("count", rule) in node.told
    flag = disturbed + 6  # the counter reached the limit by this very error: still an active flag
    assert levels == [0] * flag + [1] * (20 - flag)


@pytest.mark.finding("wire 6")
def test_a_passive_node_begins_a_passive_flag_where_its_overload_flag_was_disturbed() -> None:
    node = Recorder()
    node.passive = True
    station = Station(node, Tally())
    into_flag(station, False, True)
    assert [drive(station, 1) for _ in range(3)] == [0, 1, 1]
    assert station.state == states.PASSIVE_FLAG


def into_flag(station: Station, transmitting: bool, overload: bool) -> None:
    """The first bit of the intermission, or of the error delimiter, is dominant."""
    station.transmitting = transmitting
    station.state = states.INTERMISSION if overload else states.DELIMITER
    station.left = 3 if overload else 7
    station.begin_bit()
    station.sample(0)


def drive(station: Station, level: int) -> int:
    """One bit of this level on the bus; what the station drives in it."""
    station.begin_bit()
    station.sample(level)
    return station.out


# the ACK slot


@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.finding("wire 5")
def test_rec_goes_down_at_the_ack_slot(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a, b = can_bus.node("a"), can_bus.node("b")
    start_with_counters(b, 0, 72)
    a.send(C04)
    lab.run_until(53 * BIT_NS + 1_000)
    assert b.rec == 72
    lab.run_until(54 * BIT_NS)
    assert b.rec == 71


@pytest.mark.finding("wire 5")
def test_rec_after_an_error_at_the_ack_delimiter(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = can_bus.node("a"), can_bus.node("b"), can_bus.node("c")
    start_with_counters(b, 0, 72)
    can_bus.faults.flip(bit="ack delimiter", seen_by=b.line.controller)
    a.send(C04)
    seen: list[int] = []
    for bit in range(53, 64):
        lab.run_until((bit + 1) * BIT_NS - 1)
        seen.append(b.rec)
    assert seen == [71, 72, 72, 72, 72, 72, 72, 72, 80, 80, 80]
    assert a.pending == 1


# synchronisation


def clock_in_frame() -> Clock:
    """A receiver's, at the start of a bit of 16 quanta whose last sample was recessive."""
    node = Recorder()
    node.bit_ps, node.sample_ps, node.quantum_ps, node.jump_ps = 2_000_000, 1_500_000, 125_000, 375_000
    clock = Clock(Station(node, Tally()), 0)
    clock.station.state = states.FRAME
    clock.begin_bit(0)
    return clock


@pytest.mark.finding("wire 7")
def test_an_edge_without_phase_error_is_the_synchronisation_of_its_bit() -> None:
    clock = clock_in_frame()
    clock.edge(0)
    clock.edge(500_000)
    assert clock.due_ps == 1_500_000


@pytest.mark.finding("wire 7")
def test_an_early_edge_is_the_only_one_up_to_the_next_sample_point() -> None:
    clock = clock_in_frame()
    clock.sampled(1_500_000)
    clock.edge(1_750_000)
    assert clock.due_ps == 1_750_000
    clock.begin_bit(1_750_000)
    clock.edge(2_250_000)
    assert clock.due_ps == 3_250_000
    clock.sampled(3_250_000)
    clock.begin_bit(3_750_000)
    clock.edge(4_125_000)
    assert clock.due_ps == 5_625_000


def bus_off(lab: Lab, bus: LabBus, node: LabNode) -> None:
    """Let every attempt of the node fail until it is bus-off."""
    bus.faults.flip(bit="ack delimiter", times=None, seen_by="sender")
    node.send(C04)
    while node.state is not ErrorState.BUS_OFF:
        lab.run_for(0.001)
    bus.faults.clear()
    lab.run_for(0.001)


# plugs in the middle of a frame


def told_after_the_plug_was_out(back_ns: int, bitwise: bool) -> tuple[object, ...]:
    """What c is told, whose plug is out from the identifier of a's first frame on until a later one."""
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        bus.wire.bitwise = bitwise
        a, _, c = (bus.node(name) for name in "abc")
        c.events()
        a.send_many([Frame(0x120, bytes(8)), Frame(0x121, bytes(8)), Frame(0x122, bytes(8))])
        c.send(Frame(0x123, b"\x33"))
        lab.run_until(9 * BIT_NS)
        bus.faults.disconnect(c)
        lab.run_until(back_ns)
        bus.faults.reconnect(c)
        lab.run_until(800 * BIT_NS)
        return c.events(), c.counters, c.arbitration_losses, a.receive_many(9), c.receive_many(9)


@pytest.mark.finding("wire-2 4")
def test_a_plug_put_back_in_mid_frame_is_the_same_both_ways() -> None:
    for back_ns in range(120 * BIT_NS, 300 * BIT_NS, 7 * BIT_NS + 777):
        whole, bitwise = (told_after_the_plug_was_out(back_ns, way) for way in (False, True))
        assert whole == bitwise, back_ns
