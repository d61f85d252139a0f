"""LIN's text form: examples, round trips, and nothing but BadText for bad text."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadText
from canwire.values.event import InfoCode
from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind, LinState
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.text import (
    LinLogLine,
    format_lin_content,
    format_lin_frame,
    format_lin_log_line,
    parse_lin_content,
    parse_lin_frame,
    parse_lin_log_line,
)
from canwire.values.text import parse_log_line
from tests.cases import each

FRAMES = [
    ("10#", LinFrame(0x10)),
    ("10#0102030405060708", LinFrame(0x10, bytes(range(1, 9)))),
    ("10#0102_C", LinFrame(0x10, b"\1\2", enhanced=False)),
    ("3C#00FFFFFFFFFFFFFF", LinFrame(0x3C, b"\0" + b"\xff" * 7)),
    ("3E#01", LinFrame(0x3E, b"\1")),
    ("3E#01_E", LinFrame(0x3E, b"\1", enhanced=True)),
    ("10#R", LinFrame(0x10, header_only=True)),
    ("10#R4", LinFrame(0x10, header_only=True, length=4)),
]
READ_ONLY = [
    ("10#01.02", LinFrame(0x10, b"\1\2")),
    ("10#01.", LinFrame(0x10, b"\1")),
    ("1f#r", LinFrame(0x1F, header_only=True)),
    ("10#R0", LinFrame(0x10, header_only=True)),
    ("10#01_E", LinFrame(0x10, b"\1")),
]
EVENTS = [
    ("ERROR#CHKSUM@10", LinEvent(LinEventKind.ERROR, error=LinErrorKind.CHKSUM, id=0x10)),
    ("ERROR#NOBUS", LinEvent(LinEventKind.ERROR, error=LinErrorKind.NOBUS)),
    ("STATE#ASLEEP", LinEvent(LinEventKind.STATE, state=LinState.ASLEEP)),
    ("INFO#STARTED", LinEvent(LinEventKind.INFO, code=InfoCode.STARTED)),
    ("WAKEUP#", LinEvent(LinEventKind.WAKEUP)),
    ("SLEEP#", LinEvent(LinEventKind.SLEEP)),
    ("TIME_OVERRUN#1", LinEvent(LinEventKind.TIME_OVERRUN, code=1)),
]
BAD = [
    ("", "has no #"),
    ("10", "has no #"),
    ("1#01", "neither an identifier of 2 hex digits nor an event"),
    ("123#01", "neither an identifier"),
    ("xx#01", "neither an identifier"),
    ("40#01", "0x40"),
    ("10#1", "pairs of hex digits"),
    ("10#0g", "pairs of hex digits"),
    ("10#010203040506070809", "at most 8"),
    ("10#R9", "after R"),
    ("10#01_X", "_C or _E"),
    ("3C#01_E", "classic checksum"),
    ("ERROR#", "ERROR has no 'kind'"),
    ("ERROR#STUFF", "ERROR has no 'STUFF'"),
    ("STATE#BUSY", "STATE has no 'BUSY'"),
    ("WAKEUP#NOW", "WAKEUP has no 'NOW'"),
    ("TIME_OVERRUN#X", "TIME_OVERRUN has no 'X'"),
    ("ERROR#BIT@40", "identifier 0x40"),
    ("FOO#BIT", "neither an identifier"),
    (" 10#01", "neither an identifier"),
    ("١٠#01", "neither an identifier"),
]


@each(("text", "frame"), FRAMES)
def test_frames_both_ways(text: str, frame: LinFrame) -> None:
    assert format_lin_frame(frame) == text
    assert parse_lin_frame(text) == frame


@each(("text", "frame"), READ_ONLY)
def test_frames_that_are_only_read(text: str, frame: LinFrame) -> None:
    assert parse_lin_frame(text) == frame


@each(("text", "event"), EVENTS)
def test_events_both_ways(text: str, event: LinEvent) -> None:
    assert format_lin_content(event) == text
    assert parse_lin_content(text) == event


@each(("text", "message"), BAD)
def test_bad_text_says_what_is_wrong(text: str, message: str) -> None:
    with pytest.raises(BadText, match=message):
        parse_lin_content(text)


def test_an_event_cannot_be_sent() -> None:
    with pytest.raises(BadText, match="not a frame that can be sent"):
        parse_lin_frame("WAKEUP#")


@each(
    "text",
    [
        "(1436509052.249713) lin0 10#0102",
        "(1436509052.249713) lin0 10#0102 T",
        "(0000000000.000001) lin0 3D#R8 R",
        "(0000000001.000000) lin0 ERROR#SLNORE@3D",
    ],
)
def test_log_lines_both_ways(text: str) -> None:
    assert format_lin_log_line(parse_lin_log_line(text + "\n")) == text


def test_a_log_line_s_time_and_direction_are_the_frame_s() -> None:
    line = parse_lin_log_line("(1.5) lin0 10#01 T")
    assert (line.timestamp_ns, line.direction) == (1_500_000_000, "T")
    assert isinstance(line.content, LinFrame)
    assert (line.content.timestamp_ns, line.content.sent) == (1_500_000_000, True)


@each(
    ("text", "message"),
    [
        ("lin0 10#01", "no log line"),
        ("(1.0) lin0", "no log line"),
        ("(99999999999999999999.0) lin0 10#01", "64 bits"),
        ("(1.0) lin0 10#1", "pairs of hex"),
    ],
)
def test_bad_log_lines(text: str, message: str) -> None:
    with pytest.raises(BadText, match=message):
        parse_lin_log_line(text)


def test_lines_of_can_and_lin_are_told_apart() -> None:
    with pytest.raises(BadText):
        parse_lin_log_line("(1.0) can0 123#11")
    with pytest.raises(BadText):
        parse_log_line("(1.0) lin0 10#11")


@st.composite
def contents(draw: st.DrawFn) -> LinFrame | LinEvent:
    at_ns = draw(st.integers(0, 2**53)) * 1000
    id = draw(st.integers(0, 63))
    kind = draw(st.sampled_from(["data", "header", "error", "state", "overrun"]))
    if kind == "data":
        model = None if id in (0x3C, 0x3D) else draw(st.sampled_from([True, False]))
        return LinFrame(id, draw(st.binary(max_size=8)), enhanced=model, timestamp_ns=at_ns)
    if kind == "header":
        return LinFrame(id, header_only=True, length=draw(st.integers(0, 8)), timestamp_ns=at_ns)
    if kind == "error":
        error = draw(st.sampled_from(LinErrorKind))
        return LinEvent(LinEventKind.ERROR, at_ns, error, id=draw(st.integers(-1, 63)))
    if kind == "state":
        return LinEvent(LinEventKind.STATE, at_ns, state=draw(st.sampled_from(LinState)))
    return LinEvent(LinEventKind.TIME_OVERRUN, at_ns, code=draw(st.integers(0, 255)))


@given(contents(), st.sampled_from([None, "R"]))
def test_every_line_comes_back(content: LinFrame | LinEvent, direction: str | None) -> None:
    line = LinLogLine(content.timestamp_ns, "lin0", content, direction)
    assert parse_lin_log_line(format_lin_log_line(line)) == line


@given(st.text(max_size=40) | st.from_regex(r"\(?[0-9.]{0,8}\)? ?lin0 [0-9A-Z#_@R.]{0,20}", fullmatch=True))
def test_nothing_but_bad_text_is_raised(text: str) -> None:
    for parse in (parse_lin_content, parse_lin_log_line, parse_lin_frame):
        with contextlib.suppress(BadText):
            parse(text)  # type: ignore[operator]
