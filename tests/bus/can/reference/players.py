"""One schedule, played on canwire's bench and on the reference; both give an Outcome of the same form."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from canwire import BusEvent, EventKind, Frame, Lab, LabBus, LabNode
from tests.bus.can.reference.confinement import STOPPED
from tests.bus.can.reference.confinement import Confinement as ReferenceConfinement
from tests.bus.can.reference.frames import Heard
from tests.bus.can.reference.node import Node, Order
from tests.bus.can.reference.schedule import BIT_NS, Schedule
from tests.bus.can.reference.wire import Flip, Hold, Wire
from tests.bus.can.test_two_ways import keep_changing, start_with_counters


@dataclass
class Outcome:
    """By node: events, frames with times, what a look saw; and the levels of the wire, if they were traced."""

    events: list[list[tuple[Any, ...]]] = field(default_factory=list)
    received: list[list[tuple[int, Heard]]] = field(default_factory=list)
    seen: list[tuple[Any, ...]] = field(default_factory=list)
    delivered: list[int] = field(default_factory=list)
    levels: list[tuple[int, int]] | None = None


# canwire


def on_the_bench(schedule: Schedule, *, bitwise: bool | None) -> Outcome:
    """Bit by bit with a trace of the levels, in whole frames where the bus chooses to, or (None) now this, now that."""
    outcome = Outcome()
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000)
        nodes = []
        for k, member in enumerate(schedule.members):
            node = bus.node(f"n{k}", listen_only=member.listen_only, fd=member.knows_fd)
            node.events()
            if member.tec or member.rec:
                start_with_counters(node, member.tec, member.rec)
            nodes.append(node)
        if bitwise is None:
            keep_changing(lab, bus, random.Random(schedule.end_ns))
        elif bitwise:
            trace(bus, outcome)
        arrange(lab, bus, nodes, schedule)
        for at_ns in schedule.looks:
            lab.at(at_ns, partial(look, outcome, at_ns, nodes))
        lab.run_until(schedule.end_ns)
        for node in nodes:
            outcome.events.append([told for event in node.events() if (told := event_of(event))])
            frames = node.receive_many(10_000)
            outcome.received.append([(frame.timestamp_ns, heard_of(frame)) for frame in frames])
            outcome.delivered.append(node.delivered)
        bus.wire.bits.capture = None  # what closing brings about is no part of it
    return outcome


def trace(bus: LabBus, outcome: Outcome) -> None:
    levels: list[tuple[int, int]] = [(0, 1)]
    outcome.levels = levels
    bus.wire.bits.capture = lambda at_ps, level: levels.append((at_ps // 1000, level))
    bus.wire.bitwise = True


def arrange(lab: Lab, bus: LabBus, nodes: list[LabNode], schedule: Schedule) -> None:
    for at_ns, number, order in schedule.sends:
        frame = frame_of(order.frame)
        lab.at(at_ns, partial(nodes[number].send, frame, single_shot=order.single_shot))
    for from_ns, to_ns, number in schedule.stops:
        lab.at(from_ns, nodes[number].stop)
        lab.at(to_ns, nodes[number].start)
    for at_ns, number in schedule.restarts:
        lab.at(at_ns, nodes[number].restart)
    for bit, times, viewer in schedule.flips:
        seen_by_whom = viewer if isinstance(viewer, str) else nodes[viewer]
        bus.faults.flip(bit=bit, times=times, seen_by=seen_by_whom)
    for at_ns, bits, level, number in schedule.holds:
        seen_by: object = "all" if number is None else nodes[number]
        bus.faults.hold(level_name(level), at=at_ns, bits=bits, seen_by=seen_by)
    for at_ns, width_ns, level, number in schedule.glitches:
        seen_by = "all" if number is None else nodes[number]
        bus.faults.glitch(level_name(level), at=at_ns, width_ns=width_ns, seen_by=seen_by)
    for from_ns, to_ns in schedule.shorts:
        lab.at(from_ns, bus.faults.short)
        lab.at(to_ns, bus.faults.clear_short)


def level_name(level: int) -> str:
    return "recessive" if level else "dominant"


def look(outcome: Outcome, at_ns: int, nodes: list[LabNode]) -> None:
    seen = [(int(node.state), node.tec, node.rec, node.arbitration_losses) for node in nodes]
    outcome.seen.append((at_ns, *seen))


def event_of(event: BusEvent) -> tuple[Any, ...] | None:
    after = (int(event.state), event.tec, event.rec)
    if event.kind is EventKind.ERROR:
        return ("error", event.timestamp_ns, event.error.name, event.bit, event.transmitting, *after)
    if event.kind is EventKind.STATE:
        return ("state", event.timestamp_ns, *after)
    if event.kind is EventKind.ARBITRATION_LOST:
        return ("lost", event.timestamp_ns, event.bit, *after)
    return None


def frame_of(heard: Heard) -> Frame:
    return Frame(
        heard.id, heard.data, extended=heard.extended, remote=heard.remote, fd=heard.fd,
        bit_rate_switch=heard.bit_rate_switch, dlc=heard.dlc,
    )  # fmt: skip


def heard_of(frame: Frame) -> Heard:
    return Heard(
        frame.id, frame.extended, frame.remote, frame.fd, frame.bit_rate_switch,
        frame.error_state_indicator, frame.dlc, frame.data,
    )  # fmt: skip


# the reference


def by_the_rules(schedule: Schedule) -> Outcome:
    wire = Wire()
    nodes = []
    for member in schedule.members:
        node = Node(knows_fd=member.knows_fd, listen_only=member.listen_only, tec=member.tec, rec=member.rec)
        wire.start(node, 0)
        nodes.append(node)
    outcome = Outcome()
    order_all(wire, nodes, schedule)
    for at_ns in schedule.looks:
        wire.run_until(quanta(at_ns))
        seen = [(node.state(), node.confinement.tec, node.confinement.rec, losses(node)) for node in nodes]
        outcome.seen.append((at_ns, *seen))
    wire.run_until(quanta(schedule.end_ns))
    for node in nodes:
        outcome.events.append([in_ns(told) for told in node.log if told[0] != "sent"])
        outcome.received.append([(nanoseconds(at), heard) for at, heard in node.heard])
        outcome.delivered.append(sum(told[0] == "sent" for told in node.log))
    outcome.levels = [(nanoseconds(at), level) for at, level in wire.levels]
    return outcome


def order_all(wire: Wire, nodes: list[Node], schedule: Schedule) -> None:
    for at_ns, number, order in schedule.sends:
        wire.at(quanta(at_ns), partial(send, wire, nodes[number], order))
    for from_ns, to_ns, number in schedule.stops:
        wire.at(quanta(from_ns), partial(stop, wire, nodes[number]))
        wire.at(quanta(to_ns), partial(start, wire, nodes[number]))
    for at_ns, number in schedule.restarts:
        wire.at(quanta(at_ns), partial(restart, wire, nodes[number]))
    for bit, times, viewer in schedule.flips:
        wire.flips.append(Flip(bit, [times], viewer if isinstance(viewer, str) else nodes[viewer]))
    held = [(at_ns, bits * BIT_NS, level, number) for at_ns, bits, level, number in schedule.holds]
    for at_ns, width_ns, level, number in held + schedule.glitches:
        ends = quanta(at_ns + width_ns)
        seen_by = [] if number is None else [nodes[number]]
        wire.holds.append(Hold(quanta(at_ns), ends, level, seen_by, number is None))
    for from_ns, to_ns in schedule.shorts:
        wire.at(quanta(from_ns), partial(setattr, wire, "shorted", True))
        wire.at(quanta(to_ns), partial(setattr, wire, "shorted", False))


def send(wire: Wire, node: Node, order: Order) -> None:
    node.queue.append(order)
    clock = wire.clock_of(node)
    if clock is not None:
        clock.request(wire.now)


def stop(wire: Wire, node: Node) -> None:
    node.running = False
    node.attempt = None
    wire.stop(node)
    node.now = wire.now
    node.tell("state")


def start(wire: Wire, node: Node) -> None:
    node.confinement = ReferenceConfinement()
    node.running = True
    wire.start(node, 1)
    node.tell("state")


def restart(wire: Wire, node: Node) -> None:
    if node.state() != STOPPED and node.where == "off":
        wire.start(node, 128)


def losses(node: Node) -> int:
    return sum(told[0] == "lost" for told in node.log)


def quanta(at_ns: int) -> int:
    return at_ns * 2 // 25


def nanoseconds(at: int) -> int:
    return at * 25 // 2


def in_ns(told: tuple[Any, ...]) -> tuple[Any, ...]:
    return (told[0], nanoseconds(told[1]), *told[2:])
