"""Who wins the bus, where the losers learn of it, and that they come later: ISO 11898-1 arbitration."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BusEvent, ErrorKind, ErrorState, EventKind, Frame, Lab, LabBus, LabNode
from tests.effort import examples

pytestmark = pytest.mark.core

BOTH_WAYS = pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])


def arbitration_field(frame: Frame) -> tuple[int, ...]:
    """The bits that decide, as the wire has them: identifier, RTR or SRR, IDE, extension, RTR; 0 wins."""
    remote = int(frame.remote)
    if not frame.extended:
        return (*bits(frame.id, 11), remote, 0)
    return (*bits(frame.id >> 18, 11), 1, 1, *bits(frame.id & 0x3FFFF, 18), remote)


def bits(value: int, width: int) -> list[int]:
    return [value >> k & 1 for k in reversed(range(width))]


@st.composite
def near_frames(draw: st.DrawFn) -> Frame:
    """Frames whose identifiers often begin alike, so that every bit of the field gets to decide."""
    extended = draw(st.booleans())
    base = draw(st.sampled_from([0x000, 0x123, 0x5AA, 0x7FF]))
    if draw(st.booleans()):
        base ^= 1 << draw(st.integers(0, 10))
    extension = draw(st.sampled_from([0, 1, 0x20000, 0x3FFFF]))
    id = base << 18 | extension if extended else base
    if draw(st.booleans()):
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 8)))
    return Frame(id, draw(st.binary(max_size=4)), extended=extended)


@pytest.mark.conforms("G-04")
@BOTH_WAYS
@examples(40)
@given(frames=st.lists(near_frames(), min_size=1, max_size=8, unique_by=arbitration_field))
def test_frames_pending_at_idle_go_in_order_of_their_arbitration_fields(
    bitwise: bool, frames: list[Frame]
) -> None:
    with Lab() as lab:
        bus = lab.can_bus()
        bus.wire.bitwise = bitwise
        listener = bus.node("listener")
        nodes = [bus.node(f"node {k}") for k in range(len(frames))]
        for node, frame in zip(nodes, frames, strict=True):
            node.send(frame)
        lab.run_until_idle()
        assert listener.receive_many(99) == sorted(frames, key=arbitration_field)
        assert [node.delivered for node in nodes] == [1] * len(nodes)
        assert [node.waiting for node in nodes] == [len(frames) - 1] * len(nodes)
        # whoever comes at place k has lost k times
        places = {frame: k for k, frame in enumerate(sorted(frames, key=arbitration_field))}
        assert [node.arbitration_losses for node in nodes] == [places[frame] for frame in frames]
        assert (bus.error_frames, bus.frames) == (0, len(frames))


@pytest.mark.conforms("G-04")
@BOTH_WAYS
@examples(40)
@given(
    # the node's number is added to each identifier
    queues=st.lists(st.lists(st.integers(0, 0x7F), max_size=5), min_size=2, max_size=4)
)
def test_each_time_the_lowest_of_the_heads_of_the_queues_goes(bitwise: bool, queues: list[list[int]]) -> None:
    """A node offers its frames in the order in which they were sent; between nodes the bus decides."""
    waiting = [[id << 3 | k for id in queue] for k, queue in enumerate(queues)]
    with Lab() as lab:
        bus = lab.can_bus()
        bus.wire.bitwise = bitwise
        listener = bus.node("listener")
        nodes = [bus.node(f"node {k}") for k in range(len(waiting))]
        for node, queue in zip(nodes, waiting, strict=True):
            node.send_many(Frame(id) for id in queue)
        lab.run_until_idle()
        came = [frame.id for frame in listener.receive_many(99)]
    expected = []
    while heads := [queue for queue in waiting if queue]:
        expected.append(min(heads, key=lambda queue: queue[0]).pop(0))
    assert came == expected


DATA, REMOTE = False, True
PRECEDENCE = [  # winner, loser, the bit that decides
    (Frame(0x123), Frame(0x124), 8),
    (Frame(0x000), Frame(0x400), 0),
    (Frame(0x7FE), Frame(0x7FF), 10),
    (Frame(0x123, b"\xff"), Frame(0x123, remote=True), 11),  # RTR
    (Frame(0x123), Frame(0x123 << 18, extended=True), 11),  # RTR against SRR
    (Frame(0x123), Frame(0x123 << 18, extended=True, remote=True), 11),
    (Frame(0x123, remote=True), Frame(0x123 << 18, extended=True), 12),  # IDE
    (Frame(0x123, remote=True), Frame(0x123 << 18, extended=True, remote=True), 12),
    (Frame(0x122 << 18 | 0x3FFFF, extended=True), Frame(0x123), 10),
    (Frame(0x123 << 18, extended=True), Frame(0x123 << 18 | 0x20000, extended=True), 13),
    (Frame(0x123 << 18, extended=True), Frame(0x123 << 18 | 1, extended=True), 30),
    (Frame(0x123 << 18 | 5, extended=True), Frame(0x123 << 18 | 5, extended=True, remote=True), 31),
]


@pytest.mark.conforms("G-04", "G-05")
@BOTH_WAYS
@pytest.mark.parametrize("loser_first", [False, True])
@pytest.mark.parametrize(("winner", "loser", "bit"), PRECEDENCE, ids=lambda value: str(value))
def test_precedence_and_the_bit_that_decides(
    lab: Lab, can_bus: LabBus, winner: Frame, loser: Frame, bit: int, loser_first: bool, bitwise: bool
) -> None:
    can_bus.wire.bitwise = bitwise
    a, b, c = (can_bus.node(name) for name in "abc")
    a.events()
    b.events()
    for node, frame in [(b, loser), (a, winner)] if loser_first else [(a, winner), (b, loser)]:
        node.send(frame)
    lab.run_until_idle()
    assert c.receive_many(9) == [winner, loser]
    assert a.events() == []
    assert [(event.kind, event.bit, event.timestamp_ns) for event in b.events()] == [
        (EventKind.ARBITRATION_LOST, bit, 0)
    ]
    assert (a.arbitration_losses, b.arbitration_losses) == (0, 1)


def losses_at(bit: int) -> tuple[Frame, Frame]:
    """Two frames that differ first at this bit of the arbitration field, winner first."""
    if bit <= 10:
        return Frame(0x2AA & ~(1 << 10 - bit)), Frame(0x2AA | 1 << 10 - bit)
    if bit == 11:
        return Frame(0x2AA), Frame(0x2AA << 18 | 5, extended=True)
    if bit == 12:
        return Frame(0x2AA, remote=True), Frame(0x2AA << 18, extended=True, remote=True)
    id = 0x2AA << 18 | 0x15555
    if bit == 31:
        return Frame(id, extended=True), Frame(id, extended=True, remote=True)
    mask = 1 << 30 - bit
    return Frame(id & ~mask, extended=True), Frame(id | mask, extended=True)


@pytest.mark.conforms("G-05")
@BOTH_WAYS
@pytest.mark.parametrize("bit", range(32))
def test_the_loser_is_told_the_position(lab: Lab, can_bus: LabBus, bit: int, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    winner, loser = losses_at(bit)
    a, b = can_bus.node("a"), can_bus.node("b")
    b.events()
    b.send(loser)
    a.send(winner)
    lab.run_until_idle()
    (lost,) = b.events()
    assert lost == BusEvent(EventKind.ARBITRATION_LOST, 0, bit=bit, transmitting=True, pending=True)
    assert b.receive_many(9) == [winner]
    assert a.receive_many(9) == [loser]


@pytest.mark.conforms("G-04")
def test_a_frame_that_comes_too_late_waits_however_low_its_identifier(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    a.send_many([Frame(0x7FF, bytes(8)), Frame(0x7FE)])
    lab.at(2_000, lambda: b.send(Frame(0x000)))  # one bit after the SOF
    lab.run_until_idle()
    assert [frame.id for frame in c.receive_many(9)] == [0x7FF, 0x000, 0x7FE]
    assert (a.arbitration_losses, b.arbitration_losses) == (1, 0)


def test_a_frame_sent_in_the_bit_time_of_another_node_s_start_takes_part(lab: Lab, can_bus: LabBus) -> None:
    """At the same instant: whoever asks first has no advantage."""
    a, b, c = (can_bus.node(name) for name in "abc")
    lab.at(10_000, lambda: a.send(Frame(0x200)))
    lab.at(10_000, lambda: b.send(Frame(0x100)))
    lab.run_until_idle()
    assert [frame.id for frame in c.receive_many(9)] == [0x100, 0x200]


# what arbitration cannot settle


def collided(bus: LabBus, *pairs: tuple[str, Frame]) -> tuple[list[LabNode], LabNode]:
    listener = bus.node("listener")
    nodes = [bus.node(name) for name, _ in pairs]
    for node in (listener, *nodes):
        node.events()
    for node, (_, frame) in zip(nodes, pairs, strict=True):
        node.send(frame)
    return nodes, listener


@pytest.mark.conforms("G-07")
@pytest.mark.parametrize("extended", [False, True])
@pytest.mark.parametrize(
    ("one", "other"), [(b"\x11\x22", b"\x11\x23"), (b"\x00", b"\x80"), (b"", b"\x01"), (b"\x55", bytes(8))]
)
def test_same_identifier_other_data_is_a_bit_error_and_never_a_mixture(
    lab: Lab, can_bus: LabBus, one: bytes, other: bytes, extended: bool
) -> None:
    frames = [Frame(0x123, one, extended=extended), Frame(0x123, other, extended=extended)]
    (a, b), c = collided(can_bus, ("a", frames[0]), ("b", frames[1]))
    lab.run_for(0.0005)
    first = [event for node in (a, b) for event in node.events(EventKind.ERROR) if event.transmitting]
    assert ErrorKind.BIT in {event.error for event in first}
    assert can_bus.error_frames >= 1
    assert c.waiting == 0
    lab.run_until_idle()  # error passive, the one that reads its recessive bit dominant no longer disturbs
    assert sorted(frame.data for frame in c.receive_many(99)) == sorted([one, other])
    assert set(a.receive_many(9)) <= {frames[1]}
    assert set(b.receive_many(9)) <= {frames[0]}
    assert (a.delivered, b.delivered) == (1, 1)


@pytest.mark.conforms("G-07")
@given(data=st.lists(st.binary(max_size=8), min_size=2, max_size=3, unique=True), extended=st.booleans())
def test_collisions_are_never_silently_merged(data: list[bytes], extended: bool) -> None:
    frames = [Frame(0x2AA, payload, extended=extended) for payload in data]
    with Lab() as lab:
        nodes, listener = collided(lab.can_bus(), *[(f"n{k}", frame) for k, frame in enumerate(frames)])
        lab.run_for(0.1)
        came = listener.receive_many(99)
        assert lab.buses["can0"].error_frames > 0
        assert set(came) <= set(frames)
        assert len(came) == sum(node.delivered for node in nodes)
        for node, frame in zip(nodes, frames, strict=True):
            assert node.delivered == came.count(frame)
            assert node.delivered == 1 or node.state is not ErrorState.ERROR_ACTIVE


def test_identical_frames_at_once_are_one_frame_on_the_wire(lab: Lab, can_bus: LabBus) -> None:
    """Nobody can notice: no bit differs, both senders see an acknowledge from the listener."""
    frame = Frame(0x123, b"\x11")
    (a, b), c = collided(can_bus, ("a", frame), ("b", frame))
    lab.run_until_idle()
    assert (a.delivered, b.delivered, can_bus.error_frames) == (1, 1, 0)
    assert (a.waiting, b.waiting) == (0, 0)
    assert c.receive_many(9) == [frame]
    assert (a.tec, b.tec, c.rec) == (0, 0, 0)


@pytest.mark.conforms("G-07")
@pytest.mark.parametrize("extended", [False, True])
def test_classic_and_fd_frame_with_one_identifier(lab: Lab, can_bus: LabBus, extended: bool) -> None:
    """Arbitration finds no winner; the FD sender drives FDF recessive, reads dominant: a bit error."""
    classic = Frame(0x123, b"\x11", extended=extended)
    fd = Frame(0x123, b"\x11", extended=extended, fd=True)
    (a, b), c = collided(can_bus, ("a", classic), ("b", fd))
    lab.run_for(0.000_15)
    error = b.events(EventKind.ERROR)[0]
    assert (error.error, error.transmitting) == (ErrorKind.BIT, True)
    assert all(
        event.error is not ErrorKind.BIT or event.bit > error.bit for event in a.events(EventKind.ERROR)
    )
    lab.run_until_idle()
    assert {(frame.fd, frame.data) for frame in c.receive_many(9)} == {(False, b"\x11"), (True, b"\x11")}
    assert (a.delivered, b.delivered) == (1, 1)


# priorities and delays within one node


def test_high_priority_goes_before_the_frame_that_waits_in_the_controller(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    b.send(Frame(0x000, bytes(8)))
    lab.run_for(0.000_02)  # the bus is busy, 0x100 waits in the mailbox and 0x101 in the queue
    a.send(Frame(0x100))
    a.send(Frame(0x7FF), high_priority=True)
    a.send(Frame(0x101))
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(9)] == [0x7FF, 0x100, 0x101]


def test_high_priority_changes_nothing_between_nodes(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    a.send(Frame(0x200), high_priority=True)
    b.send(Frame(0x100))
    lab.run_until_idle()
    assert [frame.id for frame in c.receive_many(9)] == [0x100, 0x200]


@BOTH_WAYS
def test_single_shot_is_given_up_on_lost_arbitration(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a, b, c = (can_bus.node(name) for name in "abc")
    a.events()
    b.send(Frame(0x100))
    a.send(Frame(0x200), single_shot=True)
    a.send(Frame(0x300))
    lab.run_until_idle()
    assert [frame.id for frame in c.receive_many(9)] == [0x100, 0x300]
    assert (a.sent, a.delivered, a.aborted, a.pending) == (2, 1, 1, 0)
    assert [event.kind for event in a.events()] == [EventKind.ARBITRATION_LOST, EventKind.ABORTED]


@BOTH_WAYS
def test_single_shot_is_given_up_on_an_error(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a, b = can_bus.node("a"), can_bus.node("b")
    a.events()
    can_bus.faults.inject("bit", times=1)
    a.send(Frame(0x200), single_shot=True)
    a.send(Frame(0x300))
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(9)] == [0x300]
    assert (a.sent, a.delivered, a.aborted, a.tec) == (2, 1, 1, 7)
    assert [event.kind for event in a.events()] == [EventKind.ERROR, EventKind.ABORTED]


def test_single_shot_without_trouble_is_delivered(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(Frame(0x200), single_shot=True)
    lab.run_until_idle()
    assert (b.receive_many(9), a.delivered, a.aborted) == ([Frame(0x200)], 1, 0)


def test_single_shot_alone_on_the_bus_is_tried_once(lab: Lab, can_bus: LabBus) -> None:
    a = can_bus.node("a")
    a.send(Frame(0x200), single_shot=True)
    lab.run_until_idle()
    assert (a.delivered, a.aborted, a.tec, can_bus.error_frames) == (0, 1, 8, 1)


def test_a_delayed_frame_waits_after_the_one_before_it(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(Frame(0x7FF, bytes(8)))
    a.send(Frame(0x2AA, b"\xaa" * 8), delay_ns=1_000_000)  # C08: 108 bits
    a.send(Frame(0x7FE))
    lab.run_until_idle()
    first, second, third = b.receive_many(9)
    assert second.timestamp_ns == first.timestamp_ns + 1_000_000 + 108 * 2000
    assert third.id == 0x7FE


def test_a_delay_in_the_past_does_not_hold_a_frame_up(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(Frame(0x100))
    lab.run_for(0.01)
    a.send(Frame(0x2AA, b"\xaa" * 8), delay_ns=1_000_000)
    lab.run_until_idle()
    assert [frame.timestamp_ns for frame in b.receive_many(9)][1] == 10_000_000 + 108 * 2000


def test_others_use_the_time_of_a_delay(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    a.send(Frame(0x100))
    a.send(Frame(0x101), delay_ns=2_000_000)
    b.send_many([Frame(0x200)] * 5)
    lab.run_until_idle()
    assert [frame.id for frame in c.receive_many(9)] == [0x100, *[0x200] * 5, 0x101]


def test_cancel_gives_up_what_waits_but_not_what_is_on_the_wire(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send_many(Frame(id) for id in range(10))
    lab.run_for(0.000_02)
    assert a.cancel() == 9
    lab.run_until_idle()
    assert [frame.id for frame in b.receive_many(99)] == [0]
    assert (a.sent, a.delivered, a.aborted, a.pending) == (10, 1, 9, 0)


def test_cancel_of_a_frame_that_lost_arbitration(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = (can_bus.node(name) for name in "abc")
    a.send(Frame(0x200))
    b.send(Frame(0x100))
    lab.run_for(0.000_05)  # past the identifiers: a receives
    assert a.cancel() == 1
    lab.run_until_idle()
    assert [frame.id for frame in c.receive_many(9)] == [0x100]
    assert (a.aborted, a.pending) == (1, 0)


@examples(30)
@given(st.lists(near_frames(), min_size=2, max_size=4, unique_by=arbitration_field), st.integers(1, 40))
def test_losses_are_the_same_wherever_one_stops_to_look(frames: list[Frame], step_bits: int) -> None:
    """A frame that nobody stops in is counted as a whole, one that is looked at bit by bit: with the same result."""

    def losses(bitwise: bool, stopping: bool) -> list[tuple[int, ...]]:
        with Lab() as lab:
            bus = lab.can_bus(bit_rate=500_000)
            bus.wire.bitwise = bitwise
            nodes = [bus.node(f"n{k}") for k in range(len(frames))]
            for node, frame in zip(nodes, frames, strict=True):
                node.send(frame)
            seen = []
            while stopping and bus.frames < len(frames):
                lab.run_for(step_bits * 2e-6)
                seen.append(tuple(node.arbitration_losses for node in nodes))
            lab.run_until_idle()
            return [*seen, tuple(node.arbitration_losses for node in nodes)]

    stopped = losses(bitwise=False, stopping=True)
    assert stopped == losses(bitwise=True, stopping=True)
    assert stopped[-1:] == losses(bitwise=False, stopping=False)
