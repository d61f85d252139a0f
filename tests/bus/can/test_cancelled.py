"""A disturbance that a script takes back: before it struck, while it lasts, in the middle of a frame."""

from __future__ import annotations

import pytest

from canwire import EventKind, Frame, Lab, LabBus, LabNode

pytestmark = pytest.mark.core

C04 = Frame(0x123, b"\x11\x22")
BIT_NS = 2_000


def pair(bus: LabBus) -> tuple[LabNode, LabNode]:
    sender, receiver = bus.node("a"), bus.node("b")
    receiver.events()
    return sender, receiver


def send(lab: Lab, sender: LabNode) -> None:
    sender.send(C04)
    lab.run_until_idle()


def test_a_flip_counts_what_it_did_and_ends_when_cancelled(lab: Lab, can_bus: LabBus) -> None:
    sender, receiver = pair(can_bus)
    fault = can_bus.faults.flip(bit=30, times=3)
    assert (fault.struck, fault.times_left) == (0, 3)
    send(lab, sender)  # repeated until the fault is used up
    assert (fault.struck, fault.times_left) == (3, 0)
    lasting = can_bus.faults.flip(bit=30, times=None)
    lasting.cancel()
    lasting.cancel()
    receiver.events()
    send(lab, sender)
    assert receiver.events(EventKind.ERROR) == []
    assert (lasting.struck, lasting.times_left) == (0, 0)


def test_a_flip_cancelled_in_the_middle_of_its_frame_does_not_strike(lab: Lab, can_bus: LabBus) -> None:
    sender, receiver = pair(can_bus)
    fault = can_bus.faults.flip(bit=30)
    sender.send(C04)
    lab.run_for(20 * BIT_NS * 1e-9)
    fault.cancel()
    lab.run_until_idle()
    assert (fault.struck, receiver.events(EventKind.ERROR), receiver.waiting) == (0, [], 1)


def test_one_of_two_is_cancelled_and_the_other_stays(lab: Lab, can_bus: LabBus) -> None:
    sender, _ = pair(can_bus)
    first, second = can_bus.faults.flip(bit=30), can_bus.faults.flip(bit=31)
    first.cancel()
    send(lab, sender)
    assert (first.struck, second.struck) == (0, 1)


def test_a_place_is_waited_for_no_longer(lab: Lab, can_bus: LabBus) -> None:
    sender, receiver = pair(can_bus)
    held = can_bus.faults.hold("dominant", at=can_bus.faults.place("eof", 2), times=9)
    sender.send(C04)
    lab.run_for(100 * BIT_NS * 1e-9)
    assert (held.struck, held.times_left) == (1, 8)
    held.cancel()
    lab.run_until_idle()
    assert (held.struck, held.times_left, receiver.waiting) == (1, 0, 1)


def test_a_level_held_until_it_is_cancelled(lab: Lab, can_bus: LabBus) -> None:
    sender, receiver = pair(can_bus)
    stuck = can_bus.faults.hold("dominant", bits=None)
    lab.run_for(0.001)
    sender.send(C04)
    lab.run_for(0.001)
    assert (stuck.struck, receiver.waiting) == (1, 0)
    stuck.cancel()
    lab.run_for(0.01)
    assert receiver.waiting == 1


def test_a_deaf_node_hears_again_once_it_is_let(lab: Lab, can_bus: LabBus) -> None:
    sender, receiver = pair(can_bus)
    can_bus.node("c")
    deaf = can_bus.faults.hold("recessive", bits=None, seen_by=receiver)
    sender.send(C04)
    lab.run_for(0.01)
    assert receiver.waiting == 0
    deaf.cancel()
    send(lab, sender)
    assert receiver.waiting == 1


def test_what_was_to_come_at_a_time_does_not(lab: Lab, can_bus: LabBus) -> None:
    _, receiver = pair(can_bus)
    fault = can_bus.faults.hold("dominant", at=1_000_000)
    fault.cancel()
    lab.run_for(0.002)
    assert (fault.struck, receiver.events()) == (0, [])


def test_noise_counts_the_bits_it_inverts(lab: Lab, can_bus: LabBus) -> None:
    sender, _ = pair(can_bus)
    much, more = can_bus.faults.noise(0.002), can_bus.faults.add_noise(0.001)
    for _ in range(300):
        send(lab, sender)
    assert much.struck > more.struck > 0
    much.cancel()
    before = much.struck, more.struck
    for _ in range(200):
        send(lab, sender)
    assert (much.struck, more.struck > before[1]) == (before[0], True)
    more.cancel()
    assert can_bus.wire.noise_left == -1


@pytest.mark.parametrize("passed", range(2, 60, 3))
def test_noise_that_begins_in_the_middle_of_a_frame_leaves_its_past_alone(
    lab: Lab, can_bus: LabBus, passed: int
) -> None:
    sender, receiver = pair(can_bus)
    send(lab, sender)
    receiver.events()
    sender.send(C04)
    lab.run_for(passed * BIT_NS * 1e-9)
    began_ns = lab.now_ns
    noise = can_bus.faults.noise(0.9)
    can_bus.wire.interrupt()  # whoever has a reason to look at the bits
    lab.run_for(4 * BIT_NS * 1e-9)
    noise.cancel()
    lab.run_for(0.01)
    assert all(event.timestamp_ns > began_ns for event in receiver.events(EventKind.ERROR))
    assert receiver.waiting == 2


def test_a_lin_fault_counts_too(lab: Lab) -> None:
    bus = lab.lin_bus("lin0")
    fault = bus.faults.checksum(times=2)
    assert (fault.struck, fault.times_left) == (0, 2)
    fault.cancel()
    assert not bus.faults.concerns(1)
