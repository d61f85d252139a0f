"""A ring and its copy over a link that loses, repeats and holds back: everything arrives once, in order."""

from __future__ import annotations

from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadMessage
from canwire.hub.links.network import calls, keys, wire
from canwire.hub.links.network.flow.way import AT_ONCE, HOLD_NS, WINDOW, Way
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.mirrors import BATCH, FULL, MANY, Outgoing
from canwire.hub.links.network.notes import IncomingNotes, OutgoingNotes
from canwire.hub.links.network.wire import Count, Report
from canwire.platform import EventDescriptor, close_descriptors, create_memory
from canwire.ring import Ring, ring_size, rounded_capacity
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.conforms("PL-11")
SIZE = 8


class Pair:
    """An original with its writer, a copy with its reader, and time."""

    def __init__(self, capacity: int) -> None:
        self.original, self.copy = self._ring(capacity), self._ring(capacity)
        self.outgoing, self.incoming = Outgoing(1, self.original), Incoming(1, self.copy)
        self.now_ns = 0
        self.written = 0
        self.lost = 0
        self.read: list[int] = []

    @staticmethod
    def _ring(capacity: int) -> Ring:
        memory = create_memory(ring_size(rounded_capacity(capacity), SIZE))
        ring = Ring.over(memory, capacity, exact=True, record_size=SIZE)
        ring.event, ring.free_event = EventDescriptor(), EventDescriptor()
        close_descriptors(memory)
        return ring

    def write(self, count: int) -> None:
        for _ in range(count):
            if self.original.put_bytes(self.written.to_bytes(SIZE, "little")):
                self.written += 1
            else:
                self.lost += 1

    def take(self, count: int) -> None:
        for _ in range(count):
            record = self.copy.take_bytes()
            if record is not None:
                self.read.append(int.from_bytes(record, "little"))

    def batches(self) -> list[bytes]:
        found: list[bytes] = []
        while made := self.outgoing.batches(self.now_ns, at_once=True):
            found += made
        return found

    def deliver(self, batch: bytes) -> None:
        ring, first, records, _ = wire.frames_in(batch)
        assert ring == 1
        self.incoming.accept(first, records)

    def tell(self) -> Report | None:
        self.now_ns += HOLD_NS
        return self.incoming.report(self.now_ns, at_once=True)

    def settle(self) -> None:
        """The link is whole again."""
        for _ in range(4):
            self.now_ns += 50_000_000  # as long as the pump waits before it asks
            self.incoming.sent(self.outgoing.sent)
            report = self.tell()
            if report is not None:
                self.outgoing.acknowledge(report)
            for batch in self.batches():
                self.deliver(batch)
            self.take(1000)

    def close(self) -> None:
        for ring in (self.original, self.copy):
            for event in (ring.event, ring.free_event):
                assert isinstance(event, EventDescriptor)
                event.close()
        self.outgoing.close()
        self.incoming.close()


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("write"), st.integers(1, 100)),
        st.tuples(st.just("take"), st.integers(1, 100)),
        st.tuples(st.sampled_from(["send", "lose", "twice", "report", "silence"]), st.just(0)),
    ),
    max_size=40,
)


@examples(100)
@given(st.integers(1, 200), STEPS)
def test_everything_arrives_once_and_in_order(capacity: int, steps: list[tuple[str, int]]) -> None:
    with closing(Pair(capacity)) as pair:
        for what, count in steps:
            if what in ("write", "take"):
                getattr(pair, what)(count)
            elif what in ("send", "lose", "twice"):
                for batch in pair.batches():
                    for _ in range({"send": 1, "lose": 0, "twice": 2}[what]):
                        pair.deliver(batch)
            elif (report := pair.tell()) is not None and what == "report":
                pair.outgoing.acknowledge(report)
            assert pair.original.fill() <= capacity
            assert (
                pair.copy.fill() <= pair.original.fill()
            )  # so what overflows does so at the original, and is counted
        pair.settle()
        assert pair.read == list(range(pair.written))
        assert pair.original.lost == pair.lost
        assert pair.original.fill() == 0


def test_a_single_record_goes_at_once_and_many_wait_for_each_other() -> None:
    with closing(Pair(1024)) as pair:
        for _ in range(AT_ONCE):
            pair.write(1)
            assert len(pair.outgoing.batches(0)) == 1
        pair.write(BATCH - 1)
        assert pair.outgoing.batches(HOLD_NS - 1) == []
        assert pair.outgoing.arm(HOLD_NS - 1) == HOLD_NS
        pair.write(1)
        (batch,) = pair.outgoing.batches(HOLD_NS - 1)
        assert len(wire.frames_in(batch)[2]) == BATCH * SIZE


def test_where_many_wait_payloads_are_larger_and_a_full_load_is_known_as_one() -> None:
    with closing(Pair(8192)) as pair:
        pair.outgoing.belongs_to(Way(WINDOW))
        pair.write(MANY * BATCH - 1)
        assert [len(wire.frames_in(one)[2]) // SIZE for one in pair.outgoing.batches(0)] == [
            BATCH,
            BATCH,
            BATCH,
            BATCH - 1,
        ]
        pair.write(5000)
        loads = []
        while found := pair.outgoing.batches(HOLD_NS, at_once=True):
            loads.append([len(wire.frames_in(one)[2]) // SIZE for one in found])
        assert loads[0] == [MANY * BATCH] * FULL
        assert sum(map(sum, loads)) == 5000
        assert all(len(load) >= FULL for load in loads[:-1])


@pytest.mark.parametrize("report", [Report(1, 3, 0, False), Report(1, 1, 2, False)])
def test_a_report_that_cannot_be_is_refused(report: Report) -> None:
    with closing(Pair(16)) as pair:
        pair.write(2)
        with pytest.raises(BadMessage, match="ring 1"):
            pair.outgoing.acknowledge(report)


def test_more_than_fits_is_refused() -> None:
    with closing(Pair(4)) as pair:
        with pytest.raises(BadMessage, match="room for 4 records"):
            pair.incoming.accept(0, memoryview(bytes(5 * SIZE)))
        with pytest.raises(BadMessage, match="room for 4 records"):
            pair.incoming.accept(0, memoryview(bytes(SIZE - 1)))


@examples(100)
@given(st.lists(st.sampled_from(["add", "send", "lose", "report"]), max_size=60))
def test_notices_arrive_once_and_in_order(steps: list[str]) -> None:
    told: list[bytes] = []
    outgoing, incoming, count = OutgoingNotes(), IncomingNotes(told.append), 0
    for what in [*steps, "report", "send", "report", "send"]:
        if what == "add":
            outgoing.add(bytes([count]))
            count += 1
        elif what == "report":
            incoming.sent(outgoing.sent)
            report = incoming.report(0)
            assert report is not None
            outgoing.acknowledge(report)
        for batch in outgoing.batches(0) if what in ("send", "lose") else ():
            if what == "send":
                incoming.accept(*wire.frames_in(batch)[1:3])
    assert told == [bytes([number]) for number in range(count)]


@given(st.binary(max_size=80))
def test_what_is_no_message_is_refused_and_nothing_else(payload: bytes) -> None:
    for parse in (
        wire.frames_in,
        wire.states_in,
        wire.reports_in,
        wire.counts_in,
        calls.asked_in,
        calls.answered_in,
    ):
        try:
            parse(payload)
        except BadMessage:
            continue


_POSITION = st.integers(0, 2**64 - 1)


@given(st.integers(0, 2**32 - 1), _POSITION, _POSITION, _POSITION, _POSITION, st.booleans())
def test_messages_come_as_they_were(ring: int, a: int, b: int, c: int, d: int, again: bool) -> None:
    assert wire.states_in(wire.states([(ring, a)])) == [(ring, a)]
    assert wire.reports_in(wire.reports([Report(ring, a, b, again)])) == [Report(ring, a, b, again)]
    assert wire.counts_in(wire.counts([Count(ring, a, b, c, d)])) == [Count(ring, a, b, c, d)]
    number, first, records, _ = wire.frames_in(wire.frames(ring, a, memoryview(b"xyz")))
    assert (number, first, bytes(records)) == (ring, a, b"xyz")


@each(
    ("address", "endpoint", "name"),
    [
        ("zenoh://lab/bench1", "tcp/bench1:7449", "bench1"),
        ("zenoh://lab/192.168.1.5:80", "tcp/192.168.1.5:80", "192.168.1.5"),
        ("zenoh://lab/bench1?via=tls/router:7447", "tls/router:7447", "bench1"),
    ],
)
def test_an_address_says_where(address: str, endpoint: str, name: str) -> None:
    place = keys.parse(address)
    assert (place.realm, place.name, place.endpoint) == ("lab", name, endpoint)


@each(
    "address",
    ["zenoh://", "zenoh://lab", "zenoh://lab/", "zenoh://lab/a/b", "zenoh://lab/a:x", "zenoh://lab/a:0", "zenoh://l*b/a",
     "zenoh://lab/a?via=router", "zenoh://lab/**", "tcp://lab/a"],
)  # fmt: skip
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(ValueError, match=r"zenoh://REALM/HOST|letters, digits"):
        keys.parse(address)


def test_a_token_says_what_is_offered() -> None:
    offer = keys.Offer("lab", "bench1", "a1b2", 2, "fast")
    assert keys.offer_of(keys.token(offer)) == offer
    assert keys.offer_of("canwire/lab/hub/bench1") is None


@given(sizes=st.lists(st.sampled_from([1, 5, 96, wire.SMALL, wire.SMALL + 1, 5136]), max_size=80))
def test_small_payloads_go_together_and_come_apart_in_order(sizes: list[int]) -> None:
    payloads = [
        bytes([wire.REPORTS, *number.to_bytes(2, "big")]) + bytes(n) for number, n in enumerate(sizes)
    ]
    sent = wire.packed(payloads)
    found: list[bytes] = []
    for payload in sent:
        found += wire.parts_in(payload) if payload[0] == wire.TOGETHER else [payload]
    assert found == payloads
    assert len(sent) <= 2 * sum(size + 3 > wire.SMALL for size in sizes) + 1 + len(sizes) // 32
    assert all(len(payload) <= 40 * wire.SMALL for payload in sent if payload[0] == wire.TOGETHER)


def test_payloads_within_each_other_are_refused() -> None:
    inner = wire.packed([b"\3", b"\3"])[0]
    with pytest.raises(BadMessage, match="within others"):
        wire.parts_in(wire.packed([inner, inner])[0])


def test_positions_that_ends_wait_for_count_from_the_links_beginning() -> None:
    ring = Pair._ring(16)
    record = memoryview(bytes(SIZE))
    with closing(ring):
        ring.put_bytes(record)
        ring.take_bytes()  # before there was a link
        incoming = Incoming(1, ring)
        assert incoming.wanted == 0
        ring.threshold = 3
        ring.arm()
        assert incoming.wanted == 3
        incoming.accept(0, memoryview(bytes(2 * SIZE)))
        ring.take_bytes()
        assert [incoming.want(goal) for goal in (0, 1, 2)] == [False, True, False]
