"""No frame is lost in silence: at any moment, whatever goes wrong, the books balance.

For every receiver accepted = read + waiting + lost; for every sender sent = delivered + aborted + pending.
"""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import ErrorState, Frame, Lab, LabBus, LabNode, QueueFull
from tests.cases import each

pytestmark = pytest.mark.core

SEEDS = 40
ROUNDS = 40


@dataclass
class Books:
    """What a test itself has counted for one node."""

    node: LabNode
    sent: int = 0
    refused: int = 0
    read: list[Frame] = field(default_factory=list)

    def check(self) -> None:
        node = self.node
        assert node.accepted == len(self.read) + node.waiting + node.lost, node
        assert node.sent == self.sent, node
        assert node.sent == node.delivered + node.aborted + node.pending, node
        assert node.pending >= 0
        assert node.waiting >= 0


@each("seed", range(SEEDS))
def test_the_books_balance_whatever_goes_wrong(seed: int) -> None:
    chance = random.Random(seed)
    with Lab(seed=seed) as lab:
        bus = lab.can_bus(
            bit_rate=chance.choice([125_000, 500_000, 1_000_000]),
            data_bit_rate=chance.choice([None, 2_000_000]),
        )
        books = [Books(node) for node in some_nodes(bus, chance)]
        sent: set[Frame] = set()
        for _ in range(ROUNDS):
            something_happens(lab, bus, books, sent, chance)
            for book in books:
                book.check()
        make_good(lab, bus, books)
        for book in books:
            book.read += book.node.receive_many(1 << 20)
            book.check()
            assert {identity(frame) for frame in book.read} <= {identity(frame) for frame in sent}
        assert bus.frames == sum(book.node.delivered for book in books) or bus.wire.collisions


def identity(frame: Frame) -> tuple[object, ...]:
    """A frame without its ESI, which a passive sender sets."""
    return frame.id, frame.extended, frame.remote, frame.fd, frame.bit_rate_switch, frame.dlc, frame.data


def some_nodes(bus: LabBus, chance: random.Random) -> list[LabNode]:
    filters = [None, [(0x100, 0x700)], [(0x0, 0x1, True), (0x7F, 0x7F)], []]
    return [
        bus.node(
            f"n{k}",
            filters=chance.choice(filters),
            receive_queue=chance.choice([1, 2, 8, 64, 4096]),
            transmit_queue=chance.choice([1, 4, 64]),
            self_reception=chance.random() < 0.3,
            listen_only=k > 1 and chance.random() < 0.2,
        )
        for k in range(chance.randrange(2, 6))
    ]


def something_happens(
    lab: Lab, bus: LabBus, books: list[Books], sent: set[Frame], chance: random.Random
) -> None:
    """Traffic, perhaps a fault or a reader, and some time."""
    book = chance.choice(books)
    for _ in range(chance.randrange(12)):
        send_something(chance.choice(books), sent, chance)
    match chance.randrange(14):
        case 0:
            bus.faults.noise(chance.choice([0, 1e-4, 1e-3, 1e-2]))
        case 1:
            seen_by = chance.choice(["all", "receivers", "sender", book.node])
            bus.faults.flip(bit=chance.randrange(100), times=chance.randrange(1, 20), seen_by=seen_by)
        case 2:
            bus.faults.disconnect(book.node)
        case 3:
            bus.faults.reconnect(book.node)
        case 4:
            book.node.stop()
        case 5:
            book.node.start()
        case 6:
            book.node.restart()
        case 7:
            book.node.cancel()
        case 8:
            bus.faults.short()
            lab.run_for(chance.uniform(0, 0.000_1))
            bus.faults.clear_short()
    lab.run_for(chance.choice([0, 0.000_003, 0.000_1, 0.000_777, 0.004]))
    for reader in books:
        if chance.random() < 0.3:
            reader.read += reader.node.receive_many(chance.choice([1, 3, 1000]))


def send_something(book: Books, sent: set[Frame], chance: random.Random) -> None:
    if book.node.settings.listen_only:
        return
    frame = random_frame(chance, int(book.node.name[1:]), fd=book.node.bus.data_timing is not None)
    options = {"single_shot": chance.random() < 0.2, "high_priority": chance.random() < 0.2}
    delay_ns = chance.choice([0, 0, 0, 50_000])
    try:
        book.node.send(frame, delay_ns=delay_ns, **options)
    except QueueFull:
        book.refused += 1
    else:
        book.sent += 1
        sent.add(frame)


def random_frame(chance: random.Random, number: int, *, fd: bool) -> Frame:
    """The lowest three bits of the identifier are the sender's: no collisions."""
    extended = chance.random() < 0.3
    id = chance.randrange(1 << (26 if extended else 8)) << 3 | number
    if fd and chance.random() < 0.3:
        data = chance.randbytes(chance.choice([0, 8, 16, 64]))
        return Frame(id, data, extended=extended, fd=True, bit_rate_switch=chance.random() < 0.5)
    if chance.random() < 0.1:
        return Frame(id, extended=extended, remote=True, dlc=chance.randrange(9))
    return Frame(id, chance.randbytes(chance.randrange(9)), extended=extended)


def make_good(lab: Lab, bus: LabBus, books: list[Books]) -> None:
    """Everything repaired: whatever is still pending goes out, as somebody is always there to acknowledge."""
    bus.faults.clear()
    for book in books:
        bus.faults.reconnect(book.node)
        if book.node.state is ErrorState.STOPPED:
            book.node.start()
    for _ in range(3):
        for book in books:
            book.node.restart()
        lab.run_for(0.02)
    lab.run_until_idle()
    listeners = [book.node.settings.listen_only for book in books]
    assert listeners.count(False) >= 2
    assert [book.node.pending for book in books] == [0] * len(books)
    assert all(book.node.state is not ErrorState.BUS_OFF for book in books)


@pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])
@settings(deadline=None, max_examples=40)
@given(
    traffic=st.lists(
        st.tuples(st.integers(0, 3), st.integers(0, 0xFF), st.binary(max_size=8), st.integers(0, 300_000)),
        max_size=25,
    )
)
def test_without_faults_everybody_gets_everything_in_one_order(
    bitwise: bool, traffic: list[tuple[int, int, bytes, int]]
) -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=1_000_000)
        bus.wire.bitwise = bitwise
        nodes = [bus.node(f"n{k}", self_reception=True) for k in range(4)]
        sent = []
        at_ns = 0
        for number, base, data, pause_ns in traffic:
            frame = Frame(base << 3 | number, data)
            sent.append(frame)
            at_ns += pause_ns
            lab.at(at_ns, lambda node=nodes[number], frame=frame: node.send(frame))
        lab.run_until_idle()
        received = [node.receive_many(999) for node in nodes]
        times = [[frame.timestamp_ns for frame in frames] for frames in received]
        assert all(frames == received[0] for frames in received)
        assert all(stamps == times[0] for stamps in times)
        assert times[0] == sorted(set(times[0]))
        assert Counter(received[0]) == Counter(sent)
        for node, number in zip(nodes, range(4), strict=True):
            own = [frame for frame in sent if frame.id & 7 == number]
            assert [frame for frame in received[0] if frame.id & 7 == number] == own
            assert (node.delivered, node.aborted, node.pending, node.lost) == (len(own), 0, 0, 0)


@settings(deadline=None, max_examples=40)
@given(
    capacity=st.sampled_from([1, 2, 4, 16]),
    steps=st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), max_size=8),
)
def test_a_slow_reader_loses_the_newest_frames_and_knows_how_many(
    capacity: int, steps: list[tuple[int, int]]
) -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=1_000_000)
        a, b = bus.node("a"), bus.node("b", receive_queue=capacity)
        model: list[int] = []
        number = lost = read = 0
        for arriving, reading in steps:
            for _ in range(arriving):
                a.send(Frame(0x1, number.to_bytes(4, "big")))
                if len(model) < capacity:
                    model.append(number)
                else:
                    lost += 1
                number += 1
            lab.run_until_idle()
            got = [int.from_bytes(frame.data, "big") for frame in b.receive_many(reading)]
            assert got == model[:reading]
            del model[:reading]
            read += len(got)
            assert (b.lost, b.accepted, b.waiting) == (lost, number, len(model))
            assert b.accepted == read + b.waiting + b.lost
