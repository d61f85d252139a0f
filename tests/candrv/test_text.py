"""WriteFile's and ReadFile's texts. Source: CANDRV manual, 8.3, 8.4; rulings.md 14."""

from __future__ import annotations

import re
from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from canwire import BadText
from canwire.candrv import (
    CanbusEvent,
    Event,
    EventReader,
    MalformedMessage,
    Message,
    MessageParser,
    format_event,
    format_message,
    parse_event,
)

dwords = st.integers(0, 0xFFFF_FFFF)
times = st.integers(0, (1 << 64) - 1)


def size(rtr: int, dlc: int) -> int:
    return 0 if rtr else min(dlc, 8)


messages = st.tuples(dwords, st.integers(0, 1), st.integers(0, 15), st.binary(min_size=8, max_size=8)).map(
    lambda one: Message(*one[:3], one[3][: size(one[1], one[2])])
)
MESSAGE_TYPES = [CanbusEvent.RECEIVED, CanbusEvent.TRANSMITTED, CanbusEvent.ABORTED]


@st.composite
def events(draw: st.DrawFn) -> Event:
    kind = draw(st.sampled_from([*CanbusEvent, 0x800, 0x1234_5678]))
    if kind not in MESSAGE_TYPES:
        return Event(int(kind), draw(times))
    lost = draw(dwords) if kind == CanbusEvent.RECEIVED else 0
    message = draw(messages)
    return Event(int(kind), draw(times), lost, 0, *message)


def everything(parser: MessageParser, text: bytes) -> list[Message]:
    """All messages, and all of the text used."""
    found: list[Message] = []
    at = 0
    while True:
        message, at = parser.next(text, at)
        if message is None:
            assert at == len(text)
            return found
        found.append(message)


# WriteFile


@pytest.mark.conforms("FS-23", "FS-24", "FS-09")
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (b"731 0 4 11 22 33 44\n", [Message(0x731, 0, 4, b"\x11\x22\x33\x44")]),  # 8.3, example 1
        (b"123 0 2 a B\n", [Message(0x123, 0, 2, b"\x0a\x0b")]),  # what example 2 prints
        (b"0 0 8 0 0 0 0 0 0 0 0\n", [Message(0, 0, 8, bytes(8))]),  # CanWrite
        (b"3e7 0 8 0 0 0 0 0 0 0 0\n", [Message(999, 0, 8, bytes(8))]),
        (b"1FFFFFFF 1 0\n", [Message(0x1FFFFFFF, 1, 0)]),
        (b"112 1 8\n", [Message(0x112, 1, 8)]),
        (b"112 1 2 11 22\n", [Message(0x112, 1, 2)]),  # a remote frame has no data
        (b"731,0\t4;11::22--33 44\n", [Message(0x731, 0, 4, b"\x11\x22\x33\x44")]),
        (b"  731 0 1 ff  \r", [Message(0x731, 0, 1, b"\xff")]),
        (b"731 0 1 ff\0", [Message(0x731, 0, 1, b"\xff")]),
        (b"731 0 1 ff\r\n\0\n", [Message(0x731, 0, 1, b"\xff")]),
        (b"\r\n\0 \n", []),
        (b"", []),
        (b"731 0 2 11 22 33 44\n", [Message(0x731, 0, 2, b"\x11\x22")]),
        (b"731 0 0 999 z 7\n", [Message(0x731, 0, 0)]),  # what is not used may be anything
        (b"731 0 8 1 2 3 4 5 6 7 8 9 a b c d e f 10\n", [Message(0x731, 0, 8, bytes(range(1, 9)))]),
        (b"731 0 9 1 2 3 4 5 6 7 8\n", [Message(0x731, 0, 9, bytes(range(1, 9)))]),
        (b"731 0 f 1 2 3 4 5 6 7 8 9\n", [Message(0x731, 0, 15, bytes(range(1, 9)))]),
        (b"000000000731 00 01 0ff\n", [Message(0x731, 0, 1, b"\xff")]),
        (b"1 0 0\n2 0 0\r3 0 0\0", [Message(1), Message(2), Message(3)]),
        (b"1 0 1 ff\xff\xfe\n", [Message(1, 0, 1, b"\xff")]),
    ],
)
def test_messages(text: bytes, expected: list[Message]) -> None:
    assert everything(MessageParser(), text) == expected
    assert list(MessageParser().messages(text)) == expected
    parser = MessageParser()
    assert [one for at in range(len(text)) for one in everything(parser, text[at : at + 1])] == expected
    assert not parser.pending


@pytest.mark.conforms("FS-25")
@pytest.mark.parametrize(
    ("text", "consumed", "why"),
    [
        (b"731\n", 3, "ends before its RTR"),
        (b"731 0\n", 5, "ends before its DLC"),
        (b"731 0 4\n", 7, "ends after 0 of 4 data bytes"),
        (b"731 0 4 11 22 33\r\n", 16, "ends after 3 of 4"),
        (b"731 0 9 1 2 3 4 5 6 7\n", 21, "ends after 7 of 8"),
        (b"731 2 0\n", 4, "RTR is more than 1"),
        (b"731 10 0\n", 5, "RTR is more than 1"),
        (b"731 0 10\n", 7, "DLC is more than F"),
        (b"731 0 1 100\n", 10, "data byte 0 is more than FF"),
        (b"731 0 2 1 fff\n", 12, "data byte 1 is more than FF"),
        (b"100000000 0 0\n", 8, "identifier is more than FFFFFFFF"),
        (b"0x731 0 4 11 22 33 44\n", 2, "RTR is more than 1"),
        (b"hello\n", 5, "ends before its RTR"),
        (b"1 0 0\n2 0 0\n3 5\n", 14, "RTR"),
    ],
)
def test_malformed_messages(text: bytes, consumed: int, why: str) -> None:
    parser = MessageParser()
    with pytest.raises(MalformedMessage, match=why) as caught:
        everything(parser, text)
    assert caught.value.consumed == consumed
    assert f"at character {consumed + 1}" in str(caught.value)
    assert isinstance(caught.value, BadText)
    assert not parser.pending
    assert everything(parser, b"731 0 1 11\n") == [Message(0x731, 0, 1, b"\x11")]
    # letter by letter the same one is wrong
    for at in range(consumed):
        everything(parser, text[at : at + 1])
    with pytest.raises(MalformedMessage, match=why):
        everything(parser, text[consumed : consumed + 1])


@pytest.mark.conforms("FS-24", "FS-25")
def test_what_was_consumed_is_counted_from_the_call_on() -> None:
    parser = MessageParser()
    assert parser.next(b"731 0 ") == (None, 6)
    assert parser.pending
    with pytest.raises(MalformedMessage) as caught:
        parser.next(b"4 11\n")
    assert caught.value.consumed == 4
    first, at = parser.next(b"1 0 0\n2 9")
    assert (first, at) == (Message(1), 6)
    with pytest.raises(MalformedMessage) as caught:
        parser.next(b"1 0 0\n2 9", at)
    assert caught.value.consumed == 8


def test_resetting_forgets_what_has_begun() -> None:
    parser = MessageParser()
    parser.next(b"731 0 4 1")
    parser.reset()
    assert everything(parser, b"1 0 0\n") == [Message(1)]


def cut(text: bytes, places: list[int]) -> list[bytes]:
    edges = [0, *sorted({place % (len(text) + 1) for place in places}), len(text)]
    return [text[one:other] for one, other in pairwise(edges)]


@pytest.mark.conforms("FS-24")
@given(
    sent=st.lists(messages, max_size=5),
    ends=st.lists(st.sampled_from([b"\n", b"\r", b"\0", b"\r\n", b"\n\n\0"]), min_size=5, max_size=5),
    gaps=st.lists(st.sampled_from([b" ", b",", b"\t", b", ", b" x "]), min_size=1, max_size=3),
    places=st.lists(st.integers(0, 10_000), max_size=8),
)
def test_messages_come_back_however_the_text_is_cut(
    sent: list[Message], ends: list[bytes], gaps: list[bytes], places: list[int]
) -> None:
    lines = [format_message(one)[:-1] for one in sent]
    spaced = [line.replace(b" ", gaps[i % len(gaps)]) for i, line in enumerate(lines)]
    text = b"".join(line + end for line, end in zip(spaced, ends, strict=False))
    parser = MessageParser()
    assert [one for piece in cut(text, places) for one in everything(parser, piece)] == sent


def outcome(pieces: list[bytes]) -> tuple[list[Message], int | None]:
    """Messages, and how much was used before the first mistake."""
    parser, found, before = MessageParser(), [], 0
    for piece in pieces:
        at = 0
        try:
            while True:
                message, at = parser.next(piece, at)
                if message is None:
                    break
                found.append(message)
        except MalformedMessage as error:
            return found, before + error.consumed
        before += len(piece)
    return found, None


@pytest.mark.conforms("FS-25")
@given(
    text=st.binary(max_size=40) | st.text("0123456789abcdefABCDEFx ,\t\r\n\0", max_size=60).map(str.encode),
    places=st.lists(st.integers(0, 10_000), max_size=8),
)
@example(b"1 0 1 7\n1 0 0\n1 1 1\n", [])
def test_garbage_means_the_same_however_it_is_cut(text: bytes, places: list[int]) -> None:
    whole = outcome([text])
    assert outcome(cut(text, places)) == whole
    assert outcome([text[at : at + 1] for at in range(len(text))]) == whole
    for message in whole[0]:
        assert len(message.data) == size(message.rtr, message.dlc)


@pytest.mark.conforms("FS-25")
def test_endless_digits_are_refused_at_once_and_endless_gaps_cost_nothing() -> None:
    parser = MessageParser()
    with pytest.raises(MalformedMessage) as caught:
        parser.next(b"f" * 1_000_000)
    assert caught.value.consumed == 8
    assert parser.next(b"731 0 0 " + b"7 " * 100_000)[0] is None
    assert parser.next(b"\n")[0] == Message(0x731)


# ReadFile

EXACT = [  # ruling 14: the grammar of 8.4
    (
        Event(CanbusEvent.RECEIVED, 12568, 5, 1, 0x112, 1, 0),
        b"received\t0:12568\t00000112\t1\t0\r\n\t5\n",
    ),
    (
        Event(CanbusEvent.RECEIVED, 7, 0, 1, 0x731, 0, 4, b"\x11\x22\x33\x44"),
        b"received\t0:7\t00000731\t0\t4\r\n\t11\t22\t33\t44\t0\n",
    ),
    (
        Event(CanbusEvent.TRANSMITTED, 12345, 9, 1, 0x731, 0, 4, b"\x11\x22\x33\x44"),
        b"transmitted\t0:12345\t00000731\t0\t4\r\n\t11\t22\t33\t44\n",
    ),
    (Event(CanbusEvent.TRANSMITTED, 1, 0, 1, 0x7, 0, 0), b"transmitted\t0:1\t00000007\t0\t0\r\n\n"),
    (
        Event(CanbusEvent.ABORTED, 1 << 32 | 2, 0, 2, 0x12ABCDEF, 0, 1, b"\xfe"),
        b"aborted\t1:2\t12abcdef\t0\t1\r\n\tfe\n",
    ),
    (
        Event(CanbusEvent.RECEIVED, 7, 0, 1, 1, 0, 15, b"\1\2\3\4\5\6\7\x08"),
        b"received\t0:7\t00000001\t0\t15\r\n\t01\t02\t03\t04\t05\t06\t07\t08\t0\n",
    ),
    (Event(CanbusEvent.RECEIVED, 7, 0, 1, 1, 1, 8), b"received\t0:7\t00000001\t1\t8\r\n\t0\n"),
    (Event(CanbusEvent.ARBITRATION_LOST, 1), b"arbitration lost\t0:1\n"),
    (Event(CanbusEvent.DEVICE_CHANGED, 13210), b"device changed\t0:13210\n"),
    (Event(CanbusEvent.ENTERING_STANDBY, 1), b"entering standby\t0:1\n"),
    (Event(CanbusEvent.LEAVING_STANDBY, 1), b"leaving standby\t0:1\n"),
    (Event(CanbusEvent.OVERRUN, 1), b"overrun\t0:1\n"),
    (Event(CanbusEvent.WARNING, 1), b"warning\t0:1\n"),
    (Event(CanbusEvent.PASSIVE, 1), b"passive\t0:1\n"),
    (Event(CanbusEvent.BUS_ERROR, 0xFFFF_FFFF), b"bus error\t0:4294967295\n"),
    (Event(0x800, 1), b"unknown event 2048\t0:1\n"),
]


@pytest.mark.conforms("FS-26", "FS-27", "FS-09")
@pytest.mark.parametrize(("event", "text"), EXACT)
def test_events(event: Event, text: bytes) -> None:
    assert format_event(event) == text
    assert parse_event(text) == event._replace(fmt=0, lost=event.lost if event.event == 1 else 0)


@pytest.mark.conforms("FS-27")
def test_all_eleven_events_have_words() -> None:
    told = {event.event for event, _ in EXACT}
    assert told >= {int(one) for one in CanbusEvent}
    assert not any(format_event(Event(int(one))).startswith(b"unknown") for one in CanbusEvent)


@pytest.mark.conforms("FS-26")
@pytest.mark.parametrize(
    ("text", "event"),
    [  # the three examples of 8.4, with tabs and as they are printed
        (
            "transmitted\t0:12345\t731\t0\t4\t11\t22\t33\t44\n",
            Event(2, 12345, 0, 0, 0x731, 0, 4, b"\x11\x22\x33\x44"),
        ),
        (
            "transmitted  0:12345  731  0  4  11  22  33  44",
            Event(2, 12345, 0, 0, 0x731, 0, 4, b"\x11\x22\x33\x44"),
        ),
        ("received\t0:12568\t112\t1\t0\t5\n", Event(1, 12568, 5, 0, 0x112, 1, 0)),
        ("received  0:12568  112  1  0  5", Event(1, 12568, 5, 0, 0x112, 1, 0)),
        ("device changed\t0:13210\n", Event(0x200, 13210)),
        ("received\t0:1\t1ABCDEF0\t0\t1\tAB\t0\n", Event(1, 1, 0, 0, 0x1ABCDEF0, 0, 1, b"\xab")),
    ],
)
def test_the_short_form_is_read(text: str, event: Event) -> None:
    assert parse_event(text) == parse_event(text.encode()) == event


@pytest.mark.conforms("FS-26", "FS-27")
@given(event=events())
def test_events_come_back(event: Event) -> None:
    text = format_event(event)
    assert parse_event(text) == event
    assert text.isascii()
    assert len(text) < 120
    short = text.replace(b"\r\n", b"")
    assert parse_event(short) == event


@given(told=st.lists(events(), max_size=5), places=st.lists(st.integers(0, 10_000), max_size=8))
def test_a_stream_of_events_however_it_is_cut(told: list[Event], places: list[int]) -> None:
    reader = EventReader()
    text = b"".join(map(format_event, told))
    assert [one for piece in cut(text, places) for one in reader.feed(piece)] == told


def test_a_stream_goes_on_behind_what_is_malformed() -> None:
    reader = EventReader()
    found = reader.feed(b"warning\t0:1\nnonsense\nwarning\t0:2\n")
    assert next(found) == Event(8, 1)
    with pytest.raises(BadText, match="nonsense"):
        next(found)
    assert list(reader.feed(b"\n\npassive\t0:3\n")) == [Event(8, 2), Event(0x80, 3)]
    with pytest.raises(BadText, match="without the end"):
        list(reader.feed(b"x" * 1000))
    assert list(reader.feed(b"warning\t0:1\n")) == [Event(8, 1)]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "no event"),
        ("received", "no event"),
        ("received\t12568\t112\t1\t0\t5", "high:low"),
        ("recieved\t0:1\t112\t1\t0\t5", "'recieved' is no event"),
        ("unknown event x\t0:1", "is no event"),
        ("unknown event 9999999999\t0:1", "is no number"),
        ("warning\t0:1\t5", "more than a time"),
        ("warning\t0:4294967296", "from 0 to 4294967295"),
        ("received\t0:1\t112\t1", "are missing"),
        ("received\t0:1\t112345678\t1\t0\t5", "is no identifier"),
        ("received\t0:1\t112\t2\t0\t5", "from 0 to 1"),
        ("received\t0:1\t112\t0\t16\t5", "from 0 to 15"),
        ("received\t0:1\t112\t0\t2\t11\t22", "needs 2 bytes and the count"),
        ("received\t0:1\t112\t0\t1\t111\t0", "is no byte"),
        ("received\t0:1\t112\t0\t0\t-1", "is no number"),
        ("received\t0:1\t112\t0\t0\t٣", "is no number"),
        ("transmitted\t0:1\t112\t0\t1\t11\t22", "needs 1 bytes"),
    ],
)
def test_malformed_events(text: str, why: str) -> None:
    with pytest.raises(BadText, match=re.escape(why)):
        parse_event(text)


@given(text=st.text(max_size=80) | st.binary(max_size=80))
def test_any_text_is_an_event_or_bad(text: str | bytes) -> None:
    try:
        event = parse_event(text)
    except BadText:
        return
    assert parse_event(format_event(event)) == event
