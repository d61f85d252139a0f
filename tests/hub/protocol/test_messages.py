"""Messages as bytes: every one goes there and back, however the stream is cut; rubbish is BadMessage, nothing else."""

from __future__ import annotations

import contextlib
import dataclasses
import types
import typing
from enum import IntEnum
from functools import cache
from operator import attrgetter
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import (
    BadMessage,
    BadValue,
    BitTiming,
    ControllerOptions,
    DelayCompensation,
    LinProduct,
    LinSchedule,
    LinSlot,
)
from canwire.hub.protocol import lin_messages
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.lin_messages import LinReply, LinRequest
from tests.cases import each

SERIALS = st.integers(0, 2**64 - 1)
TIMINGS = [
    BitTiming.for_bit_rate(rate, clock_hz=80_000_000) for rate in (125_000, 500_000, 1_000_000, 5_000_000)
]
TIMINGS.append(BitTiming(1, 13, 2, 1, clock_hz=8_000_000, triple_sampling=True))
IDS = st.integers(0, 0x3F)
DELAYS = st.integers(0, 1 << 40)
FRAME_SLOTS = st.builds(LinSlot.frame, IDS, delay_ns=DELAYS, length=st.integers(0, 8))
SLOTS = st.one_of(
    FRAME_SLOTS,
    st.builds(
        LinSlot.event,
        IDS,
        st.lists(IDS, min_size=1, max_size=3),
        delay_ns=DELAYS,
        length=st.integers(0, 8),
        resolving=st.lists(FRAME_SLOTS, max_size=3),
    ),
    st.builds(LinSlot.sporadic, st.lists(IDS, min_size=1, max_size=3), delay_ns=DELAYS),
    st.builds(LinSlot.request, st.none() | st.binary(min_size=8, max_size=8), delay_ns=DELAYS),
    st.builds(LinSlot.response, delay_ns=DELAYS),
)
COMPENSATIONS = st.builds(DelayCompensation, st.none() | st.floats(0, 100_000), st.floats(0, 100_000))
OPTIONS = st.builds(
    ControllerOptions,
    st.floats(0, 2_000),
    st.none() | COMPENSATIONS,
    st.booleans(),
    st.booleans(),
    fd_tolerant=st.booleans(),
)
SIMPLE = {
    int: st.integers(-(2**63), 2**64 - 1),
    str: st.text(max_size=40),
    bytes: st.binary(max_size=100),
    bool: st.booleans(),
    float: st.floats(allow_nan=False),
    type(None): st.none(),
    BitTiming: st.sampled_from(TIMINGS),
    ControllerOptions: OPTIONS,
    LinProduct: st.builds(LinProduct, st.integers(0, 0x7FFE), st.integers(0, 0xFFFE), st.integers(0, 0xFF)),
    LinSchedule: st.builds(LinSchedule.of, st.lists(SLOTS, min_size=1, max_size=4), st.text(max_size=10)),
}
REQUESTS = typing.get_args(m.Request | LinRequest)
REPLIES = typing.get_args(m.Reply | LinReply)


@cache
def values_of(kind: Any) -> st.SearchStrategy[Any]:
    """Anything of an annotated type, as msgspec takes it."""
    if kind in SIMPLE:
        return SIMPLE[kind]
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin is tuple:
        if parts[-1] is Ellipsis:
            return st.lists(values_of(parts[0]), max_size=4).map(tuple)
        return st.tuples(*(values_of(part) for part in parts))
    if origin is dict:
        return st.dictionaries(values_of(parts[0]), values_of(parts[1]), max_size=4)
    if origin in (typing.Union, types.UnionType):
        return st.one_of(*(values_of(part) for part in parts))
    if issubclass(kind, IntEnum):
        return st.sampled_from(list(kind))
    return fields_of(kind)


@cache
def fields_of(kind: Any) -> st.SearchStrategy[Any]:
    hints = typing.get_type_hints(kind)
    if issubclass(kind, msgspec.Struct):
        names = [field.name for field in msgspec.structs.fields(kind)]
    else:
        names = [field.name for field in dataclasses.fields(kind)]
    return st.tuples(*(values_of(hints[name]) for name in names)).map(lambda values: kind(*values))


ANY_REQUEST = st.sampled_from(REQUESTS).flatmap(fields_of)
ANY_REPLY = st.sampled_from(REPLIES).flatmap(fields_of)


def test_every_message_is_a_request_or_a_reply() -> None:
    there = [*vars(m).values(), *vars(lin_messages).values()]
    kinds = [kind for kind in there if isinstance(kind, type) and issubclass(kind, m.Message)]
    assert {*kinds} - {m.Message} == {*REQUESTS, *REPLIES}


@pytest.mark.parametrize("kind", REQUESTS, ids=attrgetter("__name__"))
@settings(max_examples=25)
@given(data=st.data(), serial=SERIALS)
def test_requests_go_there_and_back(kind: type, data: st.DataObject, serial: int) -> None:
    request = data.draw(fields_of(kind))
    assert m.decode_request(m.encode_request(serial, request)[4:]) == (serial, request)


@pytest.mark.parametrize("kind", REPLIES, ids=attrgetter("__name__"))
@settings(max_examples=25)
@given(data=st.data(), serial=SERIALS, descriptors=st.integers(0, 9))
def test_replies_go_there_and_back(kind: type, data: st.DataObject, serial: int, descriptors: int) -> None:
    reply = data.draw(fields_of(kind))
    found = m.decode_reply(m.encode_reply(serial, reply, descriptors)[4:])
    assert found == (serial, descriptors, reply)


# the stream


def fed(stream: bytes, cuts: list[int]) -> list[bytes]:
    inbox = m.Inbox(m.LARGEST_REQUEST)
    ends = sorted(cut % (len(stream) + 1) for cut in cuts)
    payloads = []
    for start, end in zip([0, *ends], [*ends, len(stream)], strict=True):
        payloads += inbox.feed(stream[start:end])
    return payloads


@given(requests=st.lists(ANY_REQUEST, max_size=5), cuts=st.lists(st.integers(0, 10**6), max_size=8))
def test_a_stream_may_be_cut_anywhere(requests: list[Any], cuts: list[int]) -> None:
    stream = b"".join(m.encode_request(serial, request) for serial, request in enumerate(requests, 1))
    found = [m.decode_request(payload) for payload in fed(stream, cuts)]
    assert found == list(enumerate(requests, 1))


@given(requests=st.lists(ANY_REQUEST, max_size=3), tail=st.binary(max_size=3))
def test_byte_by_byte_with_a_tail(requests: list[Any], tail: bytes) -> None:
    stream = b"".join(m.encode_request(7, request) for request in requests)
    whole = m.Inbox(m.LARGEST_REQUEST).feed(stream + tail)
    one_by_one = m.Inbox(m.LARGEST_REQUEST)
    assert [payload for byte in stream + tail for payload in one_by_one.feed(bytes([byte]))] == whole
    assert [m.decode_request(payload) for payload in whole] == [(7, request) for request in requests]


# rubbish


@given(st.binary(max_size=200))
def test_random_bytes_are_bad_messages_or_good_ones(data: bytes) -> None:
    for decode in (m.decode_request, m.decode_reply):
        try:
            serial, *_ = decode(data)
        except BadMessage:
            continue
        assert isinstance(serial, int)


@given(st.lists(st.binary(max_size=64), max_size=8))
def test_random_streams_are_bad_messages_or_wait(pieces: list[bytes]) -> None:
    inbox = m.Inbox(1000)
    fed_bytes = given_out = 0
    try:
        for piece in pieces:
            fed_bytes += len(piece)
            given_out += sum(4 + len(payload) for payload in inbox.feed(piece))
    except BadMessage:
        return
    assert given_out <= fed_bytes


@given(request=ANY_REQUEST, where=st.integers(0, 10**6), flip=st.integers(1, 255))
def test_a_damaged_request_never_raises_anything_else(request: Any, where: int, flip: int) -> None:
    payload = bytearray(m.encode_request(1, request)[4:])
    payload[where % len(payload)] ^= flip
    with contextlib.suppress(BadMessage):
        m.decode_request(payload)


@given(request=ANY_REQUEST, keep=st.integers(0, 10**6))
def test_a_truncated_request_is_bad(request: Any, keep: int) -> None:
    payload = m.encode_request(1, request)[4:]
    with pytest.raises(BadMessage):
        m.decode_request(payload[: keep % len(payload)])


@each(
    "payload",
    [
        [1],
        [1, ["Close"]],
        [1, ["Close", "1"]],
        [1, ["Close", 1, 2]],
        [1, ["Nonsense"]],
        [1, ["Done"]],
        [1, {"type": "Close", "handle": 1}],
        ["1", ["Close", 1]],
        [1, ["Initialise", 1, {"timing": {"prescaler": 0, "tseg1": 13, "tseg2": 2, "sjw": 1}}]],
        [1, ["OpenChannel", 0, 0, 1]],
        [1, ["AddCyclic", 1, "text", 1, 0, 0]],
        [1, ["RunSchedule", 1, {"name": "", "slots": []}, 0]],
        [1, ["RunSchedule", 1, {"name": "", "slots": [{"kind": "frame", "ids": [64]}]}, 0]],
        [1, ["RunSchedule", 1, {"name": "", "slots": [{"kind": "nonsense", "ids": [1]}]}, 0]],
        [1, ["Close", 1], 3],
        None,
    ],
)
def test_wrong_shapes_are_bad_messages(payload: Any) -> None:
    with pytest.raises(BadMessage):
        m.decode_request(msgspec.msgpack.encode(payload))


@each("before", [b"", b"\x92\x01", b"\x92\x01\x94\xa5Hello\x01\x02"])
@each("nest", [b"\x91", b"\x81\xa1a", b"\x93\x01\x02"])
def test_deep_nests_are_bad_messages(before: bytes, nest: bytes) -> None:
    for decode in (m.decode_request, m.decode_reply):
        with pytest.raises(BadMessage):
            decode(before + nest * 20_000)


# bounds


@each("length", [0, m.LARGEST_REQUEST + 1, 2**31, 2**32 - 1])
def test_lengths_out_of_bounds_are_refused_before_they_take_memory(length: int) -> None:
    inbox = m.Inbox(m.LARGEST_REQUEST)
    with pytest.raises(BadMessage, match=str(length)):
        inbox.feed(m.LENGTH.pack(length))


def test_the_largest_request_passes_and_one_byte_more_does_not() -> None:
    spare = m.LARGEST_REQUEST - len(m.encode_request(1, m.Unplug("x" * 300))[4:]) + 300
    largest = m.encode_request(1, m.Unplug("x" * spare))
    assert len(largest) == 4 + m.LARGEST_REQUEST
    assert m.Inbox(m.LARGEST_REQUEST).feed(largest) == [largest[4:]]
    with pytest.raises(BadValue, match="65537"):
        m.encode_request(1, m.Unplug("x" * (spare + 1)))


def test_too_large_a_reply_is_not_sent() -> None:
    with pytest.raises(BadMessage):
        m.encode_reply(1, m.Failed("HubError", "x" * m.LARGEST_REPLY))


@each(
    "request_",
    [m.Close("1"), m.Close(2**64), m.Unplug(object()), m.SetAcceptanceFilter(1, False, -(2**64), 0)],  # type: ignore[arg-type]
)
def test_a_callers_mistake_is_found_before_it_is_sent(request_: m.Message) -> None:
    with pytest.raises(BadValue, match=type(request_).__name__):
        m.encode_request(1, request_)
