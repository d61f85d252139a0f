"""Filters of a channel against Acceptance.accepts: on the bus exactly those frames arrive."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import Acceptance, Frame
from canwire.values.acceptance import frame_key, list_key
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

# few identifiers, so that filters and frames meet
narrow = st.sampled_from([0, 1, 0x100, 0x101, 0x123, 0x7FF])
wide = st.sampled_from([0, 1, 0x100, 0x123, 0x7FF, 0x12345678, 0x1FFFFFFF])
data = st.binary(max_size=8) | st.lists(st.sampled_from([0, 1, 0x80, 0xFF]), max_size=3).map(bytes)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(wide if extended else narrow)
    kind = draw(st.sampled_from(["data", "data", "remote", "fd"]))
    if kind == "remote":
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 15)))
    if kind == "fd":
        payload = draw(data) + draw(st.sampled_from([b"", bytes(64)]))
        return Frame(id, payload[:64] if len(payload) > 8 else payload, extended=extended, fd=True)
    return Frame(id, draw(data), extended=extended)


# masks that compare a few bits or nearly all, or else next to nothing would ever pass
few_bits = st.lists(st.integers(0, 63), max_size=4).map(lambda bits: sum(1 << bit for bit in set(bits)))
masks = few_bits | few_bits.map(lambda mask: mask ^ (1 << 64) - 1) | st.integers(0, (1 << 64) - 1)


@st.composite
def acceptances(draw: st.DrawFn) -> Acceptance:
    """Pairs and lists whose codes come from frames, some of them off by a bit."""
    codes = st.tuples(frames(), few_bits).map(lambda drawn: frame_key(drawn[0]) ^ drawn[1])
    exact = frames().map(frame_key)
    pairs = draw(st.lists(st.tuples(codes | exact, masks), max_size=3))
    listed = draw(st.frozensets(frames().map(list_key), max_size=4))
    return Acceptance(tuple(pairs), listed)


def arriving(many: list[Frame], filters: Acceptance | None) -> tuple[list[Frame], canwire.LabNode]:
    with canwire.Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000)
        sender, receiver = bus.node("sender"), bus.node("receiver", filters=filters)
        sender.send_many(many)
        lab.run_until_idle()
        return receiver.receive_many(len(many) + 1), receiver


@examples(60)
@given(st.lists(frames(), min_size=1, max_size=20), acceptances())
def test_exactly_what_the_filter_accepts_arrives(many: list[Frame], acceptance: Acceptance) -> None:
    got, receiver = arriving(many, acceptance)
    expected = [frame for frame in many if acceptance.accepts(frame)]
    assert got == expected
    assert (receiver.accepted, receiver.lost, receiver.waiting) == (len(expected), 0, 0)


@examples(60)
@given(st.lists(frames(), min_size=1, max_size=20), st.lists(narrow, max_size=4), st.lists(wide, max_size=4))
def test_identifier_lists(many: list[Frame], short: list[int], long: list[int]) -> None:
    acceptance = Acceptance.identifier_list((id << 1 for id in short), extended=False)
    acceptance |= Acceptance.identifier_list((id << 1 | 1 for id in long), extended=True)
    got, _ = arriving(many, acceptance)
    listed = [
        frame
        for frame in many
        if (not frame.extended and not frame.remote and frame.id in short)
        or (frame.extended and frame.remote and frame.id in long)
    ]
    assert got == listed


@each(("filters", "passes"), [(None, True), (Acceptance.everything(), True), (Acceptance.nothing(), False)])
def test_all_or_nothing(filters: Acceptance | None, passes: bool) -> None:
    many = [Frame(1), Frame(1, extended=True), Frame(2, remote=True, dlc=3), Frame(3, bytes(64), fd=True)]
    assert arriving(many, filters)[0] == (many if passes else [])


def test_a_byte_that_is_not_there_is_no_zero() -> None:
    """Key bits 47 and 46: a filter may ask whether data bytes exist at all."""
    empty, one, two = Frame(1), Frame(1, b"\0"), Frame(1, b"\0\0")
    for wanted in (empty, one, two):
        acceptance = Acceptance(((frame_key(wanted), (1 << 64) - 1),))
        assert arriving([empty, one, two], acceptance)[0] == [wanted]


def test_bytes_behind_the_data_of_an_array_do_not_pass_filters() -> None:
    """Records that a program made itself may hold anything behind the frame's data."""
    rubbish = canwire.Frame(1, b"\x11\x22\x33")
    with canwire.Lab() as lab:
        bus = lab.can_bus()
        sender = bus.node("sender")
        wants_two = bus.node("two", filters=Acceptance(((frame_key(rubbish), (1 << 64) - 1),)))
        wants_one = bus.node("one", filters=Acceptance(((frame_key(Frame(1, b"\x11")), (1 << 64) - 1),)))
        sender.send(rubbish)
        lab.run_until_idle()
        array = wants_two.receive_array()
        array["info"] = array["info"] & 0xFFF0FFFF | 1 << 16  # now it says: one byte
        array["time_ns"] = 0
        sender.send_array(array)
        lab.run_until_idle()
        assert wants_two.receive() is None
        assert wants_one.receive() == Frame(1, b"\x11")
