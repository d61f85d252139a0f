"""Who leaves a bus or comes to it in an intermission, to the picosecond: whole frames and bit by bit are the same."""

from __future__ import annotations

import pytest

from canwire import ErrorKind, EventKind, Frame, Lab
from canwire.bus.can.node import QUIET
from tests.bus.can.test_two_ways import start_with_counters

pytestmark = pytest.mark.core

BIT_NS = 2_000
C04 = Frame(0x123, b"\x11\x22")  # 62 bits
UNLIKE_PPM = -50  # all oscillators alike: a bit lasts 2,000,100 ps, so that bits end between nanoseconds


@pytest.mark.finding("wire-2 7")
def test_a_lone_sender_that_stops_behind_its_error_frame_leaves_the_same_load_both_ways() -> None:
    """The bus is busy up to the end of the intermission once its last bit has been sampled, else up to the stop."""
    for stop_ns in range(66 * BIT_NS, 72 * BIT_NS, BIT_NS // 4):
        whole, bitwise = (busy_after_a_stop(stop_ns, way, ["a"]) for way in (False, True))
        assert whole == bitwise, stop_ns
    sampled_ns, ended_ns = 70 * BIT_NS + BIT_NS * 7 // 8, 71 * BIT_NS
    assert busy_after_a_stop(sampled_ns, False, ["a"]) == sampled_ns
    assert busy_after_a_stop(sampled_ns + 1, False, ["a"]) == ended_ns


@pytest.mark.finding("wire-2 7")
def test_all_that_leave_in_an_intermission_leave_the_same_load_both_ways() -> None:
    for stop_ns in range(60 * BIT_NS, 66 * BIT_NS, BIT_NS // 4):
        whole, bitwise = (busy_after_a_stop(stop_ns, way, ["a", "b"]) for way in (False, True))
        assert whole == bitwise, stop_ns
    assert busy_after_a_stop(64 * BIT_NS, False, ["a", "b"]) == 64 * BIT_NS


@pytest.mark.finding("wire-2 4")
@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.parametrize("length", range(9))
def test_who_has_seen_11_recessive_bits_where_a_frame_begins_takes_part_in_it(
    lab: Lab, length: int, bitwise: bool
) -> None:
    """Whatever part of a nanosecond that boundary has: the ACK delimiter begins its count, 11 bits before the SOF."""
    bus = lab.can_bus(bit_rate=500_000)
    bus.wire.bitwise = bitwise
    a, b, c = (bus.node(name, oscillator_ppm=UNLIKE_PPM) for name in "abc")
    c.stop()
    lab.at(50 * BIT_NS, c.start)
    lab.at(55 * BIT_NS, lambda: a.send_many([Frame(0x123, bytes(range(length)))] * 3))
    lab.at(60 * BIT_NS, lambda: c.send(Frame(0x010)))
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(9)] == [0x123, 0x010, 0x123, 0x123]


@pytest.mark.finding("wire-2 7")
def test_looking_closely_at_an_intermission_moves_no_bit_of_it() -> None:
    """An error-passive sender's suspend time, in whole nanoseconds, says nothing of where the intermission began."""
    for length in range(9):
        plain, close = (busy_with_a_passive_sender(length, descends) for descends in (False, True))
        assert plain == close, length


@pytest.mark.parametrize("bitwise", [False, True])
def test_the_next_frame_in_a_mailbox_says_nothing_of_the_one_that_nobody_acknowledged(
    lab: Lab, bitwise: bool
) -> None:
    """An error in the error delimiter after a missing acknowledge counts on from that frame's bits."""
    bus = lab.can_bus(bit_rate=500_000)
    bus.wire.bitwise = bitwise
    a = bus.node("a")
    a.events()
    a.send(C04, single_shot=True)
    a.send(Frame(0x123, bytes(8)))
    lab.at(61 * BIT_NS, bus.faults.short)  # in the delimiter
    lab.at(63 * BIT_NS, bus.faults.clear_short)
    lab.run_until(70 * BIT_NS)
    errors = [(event.error, event.bit) for event in a.events(EventKind.ERROR)]
    assert errors[0] == (ErrorKind.ACK, 53)
    assert errors[1] == (ErrorKind.FORM, 54)


def busy_after_a_stop(stop_ns: int, bitwise: bool, names: list[str]) -> int:
    """For how long the bus was busy whose nodes all stop then; the first of them has sent."""
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        bus.wire.bitwise = bitwise
        nodes = [bus.node(name) for name in names]
        nodes[0].send(C04)
        for node in nodes:
            lab.at(stop_ns, node.stop)
        lab.run_until(100 * BIT_NS)
        return bus.wire.busy_ns()


def busy_with_a_passive_sender(length: int, descends: bool) -> int:
    """For how long its first try makes the bus busy, which nobody acknowledges, by the end of the intermission."""
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        bus.wire.bitwise = True
        a = bus.node("a", oscillator_ppm=UNLIKE_PPM)
        start_with_counters(a, 140, 0)
        a.send(Frame(0x123, bytes(range(length))))
        lab.run_until(BIT_NS)
        while bus.wire.activity(a.line.controller) != QUIET:
            lab.run_until(lab.now_ns + BIT_NS // 32)
        if descends:
            bus.wire.descend()  # behind the intermission's last sample point
        lab.run_until(lab.now_ns + BIT_NS)
        return bus.wire.busy_ns()
