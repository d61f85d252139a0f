"""The text form: examples, round trips, candump's bytes, and nothing but BadText for bad text."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from canwire.errors import BadText
from canwire.values.dlc import FD_LENGTHS
from canwire.values.frame import Frame
from canwire.values.screen_text import parse_candump_line
from canwire.values.text import (
    LogLine,
    format_frame,
    format_log_line,
    parse_content,
    parse_frame,
    parse_log_line,
)
from tests.cases import each

EXAMPLES = [  # linux-can/can-utils lib.h, and this project's own
    ("123#", Frame(0x123)),
    ("12345678#", Frame(0x12345678, extended=True)),
    ("00000123#", Frame(0x123, extended=True)),
    ("123#R", Frame(0x123, remote=True)),
    ("123#R7", Frame(0x123, remote=True, dlc=7)),
    ("123#R8_9", Frame(0x123, remote=True, dlc=9)),
    ("12345678#R5", Frame(0x12345678, extended=True, remote=True, dlc=5)),
    ("123#00", Frame(0x123, b"\0")),
    ("123#1122334455667788", Frame(0x123, bytes.fromhex("1122334455667788"))),
    ("123#1122334455667788_E", Frame(0x123, bytes.fromhex("1122334455667788"), dlc=14)),
    ("123##0112233", Frame(0x123, b"\x11\x22\x33", fd=True)),
    ("123##1AABB", Frame(0x123, b"\xaa\xbb", fd=True, bit_rate_switch=True)),
    ("123##2", Frame(0x123, fd=True, error_state_indicator=True)),
    (
        "123##3" + "00" * 64,
        Frame(0x123, bytes(64), fd=True, bit_rate_switch=True, error_state_indicator=True),
    ),
]
READ_ONLY = [
    ("123#11.22.33.44.55.66.77.88", Frame(0x123, bytes.fromhex("1122334455667788"))),
    ("123#11.2233.44556677.88", Frame(0x123, bytes.fromhex("1122334455667788"))),
    ("123#11.", Frame(0x123, b"\x11")),
    ("7a1#r", Frame(0x7A1, remote=True)),
    ("123#R0", Frame(0x123, remote=True)),
    ("123##5aabb", Frame(0x123, b"\xaa\xbb", fd=True, bit_rate_switch=True)),
    ("123##1.11.22", Frame(0x123, b"\x11\x22", fd=True, bit_rate_switch=True)),
    ("123##0112233445566778899", Frame(0x123, bytes.fromhex("112233445566778899000000"), fd=True)),
]
BAD = [
    ("", "has no #"),
    ("123", "has no #"),
    ("12#11", "identifier '12' must have 3 hex digits"),
    ("1234#11", "identifier '1234'"),
    ("xyz#11", "identifier 'xyz'"),
    ("١٢٣#11", "identifier"),
    ("800#", "identifier 800"),
    ("52345678#", "29 bits"),
    ("123#1", "data '1' must be pairs"),
    ("123#1g", "data '1g' must be pairs"),
    ("123#1.1", "pairs of hex"),
    ("123#112233445566778899", "at most 8"),
    ("123#1122_9", "after 8 bytes"),
    ("123#1122334455667788_8", "_9 to _F"),
    ("123#R9", "after R"),
    ("123#Rx", "after R"),
    ("123#R4_9", "after 8 bytes"),
    ("123##", "digit of flags after"),
    ("123##g11", "digit of flags after"),
    ("123##1" + "00" * 65, "65 bytes"),
    ("123##1112233445566778899_9", "classic frames"),
    (" 123#11", "identifier"),
    ("123#11\n", "pairs of hex"),
    ("20000080#000000000000000000", "9 bytes: an error frame"),
    ("20000080#R", "an error frame carries"),
    ("20000000#FF", "without an error class"),
]


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    kind = draw(st.sampled_from(["classic", "remote", "fd", "raw"]))
    if kind == "remote":
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 15)))
    if kind == "raw":
        data = draw(st.binary(min_size=8, max_size=8))
        return Frame(id, data, extended=extended, dlc=draw(st.integers(9, 15)))
    if kind == "classic":
        return Frame(id, draw(st.binary(max_size=8)), extended=extended)
    size = draw(st.sampled_from(FD_LENGTHS))
    return Frame(
        id,
        draw(st.binary(min_size=size, max_size=size)),
        extended=extended,
        fd=True,
        bit_rate_switch=draw(st.booleans()),
        error_state_indicator=draw(st.booleans()),
    )


@each(("text", "frame"), EXAMPLES)
def test_examples_both_ways(text: str, frame: Frame) -> None:
    assert parse_frame(text) == frame
    assert format_frame(frame) == text


@each(("text", "frame"), READ_ONLY)
def test_other_spellings_are_read(text: str, frame: Frame) -> None:
    assert parse_frame(text) == frame


@each(("text", "why"), BAD)
def test_bad_text_says_what_is_wrong(text: str, why: str) -> None:
    with pytest.raises(BadText, match=why) as caught:
        parse_frame(text)
    assert repr(text)[:20] in str(caught.value)
    if "#" in text and not text.startswith(" ") and not text.endswith("\n"):
        with pytest.raises(BadText, match=why):
            parse_log_line(f"(1.5) can0 {text}")


def test_an_error_frame_is_not_for_sending() -> None:
    with pytest.raises(BadText, match="error frame"):
        parse_frame("20000080#0000000000000000")


@given(frames())
def test_frames_come_back(frame: Frame) -> None:
    assert parse_frame(format_frame(frame)) == frame


@given(
    frames(),
    st.integers(0, 2**63 // 1000),
    st.sampled_from([None, "R", "T"]),
    st.sampled_from(["can0", "vcan12"]),
)
def test_log_lines_come_back(frame: Frame, micros: int, direction: str | None, interface: str) -> None:
    text = format_log_line(LogLine(micros * 1000, interface, frame, direction))
    found = parse_log_line(text + "\n")
    assert found == LogLine(micros * 1000, interface, frame, direction)
    assert found.content.timestamp_ns == micros * 1000
    assert format_log_line(found) == text


@each(
    "text",
    [
        "(1436509052.249713) vcan0 044#2A366C2BBA",
        "(0000000166.000000) vcan0 21A#FE3612FE690507AD",
        "(1436509052.249713) can0 12345678#112233 T",
        "(1436509052.249713) can0 123#R4 R",
        "(1436509052.249713) can0 123##1AABB",
    ],
)
def test_log_lines_keep_every_byte(text: str) -> None:
    assert format_log_line(parse_log_line(text)) == text


@each(
    ("text", "time_ns"),
    [
        ("(166.000001) can0 123#", 166_000_001_000),
        ("(0.5)  can0  123#\r\n", 500_000_000),
        ("(1436509052.249713123) can0 123#", 1_436_509_052_249_713_123),
    ],
)
def test_times_have_one_to_nine_decimals(text: str, time_ns: int) -> None:
    line = parse_log_line(text)
    assert line.timestamp_ns == line.content.timestamp_ns == time_ns


def test_output_cuts_times_to_microseconds() -> None:
    assert format_log_line(LogLine(1_999, "can0", Frame(1))) == "(0000000000.000001) can0 001#"


@each(
    "line",
    [
        "",
        "123#",
        "can0 123#",
        "(1.5 can0 123#",
        "(1) can0 123#",
        "(-1.5) can0 123#",
        "(1.5) can0",
        "(1.5) can0 123# X",
        "(99999999999.0) can0 123#",
        "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)",
    ],
)
def test_bad_log_lines(line: str) -> None:
    with pytest.raises(BadText):
        parse_log_line(line)


_NEARLY = st.text(alphabet="0123456789ABCDEFabcdefRrT#_.()[]{}' canvx\n-²١", max_size=60)


@given(st.one_of(st.text(), _NEARLY))
@example("(1.1) c 123#" + "." * 5000)
@example("(" + "9" * 5000 + ".0) c 123#")
def test_random_text_raises_nothing_but_bad_text(text: str) -> None:
    for parse in (parse_frame, parse_content, parse_log_line, parse_candump_line):
        for candidate in (
            text,
            f"(1.5) can0 {text}",
            f"  can0  {text}",
            f"123#{text}",
            f"can0 123 [2] {text}",
        ):
            try:
                parse(candidate)
            except BadText:
                continue
            assert "#" in candidate or "[" in candidate or "{" in candidate


@given(st.lists(frames(), min_size=1, max_size=5), st.sampled_from(["R", "T"]))
def test_python_can_reads_and_writes_the_same_lines(sent: list[Frame], direction: str) -> None:
    canutils = pytest.importorskip("can.io.canutils")
    sent = [frame for frame in sent if frame.fd or frame.dlc <= 8]  # it has no raw data length codes
    lines = [LogLine(at * 1_000_000, "can0", frame, direction) for at, frame in enumerate(sent)]
    text = "".join(format_log_line(line) + "\n" for line in lines)

    messages = list(canutils.CanutilsLogReader(io.StringIO(text)))

    assert [(m.arbitration_id, bytes(m.data), m.dlc, m.is_rx) for m in messages] == [
        (frame.id, frame.data, len(frame.data) if frame.fd else frame.dlc, direction == "R") for frame in sent
    ]
    written = io.StringIO()
    writer = canutils.CanutilsLogWriter(written)
    for message in messages:
        writer.on_message_received(message)
    back = [parse_log_line(line) for line in written.getvalue().splitlines()]
    for frame, line, found in zip(sent, lines, back, strict=True):
        if not frame.remote:  # it does not write the length a remote frame asks for
            assert found == line


def test_a_real_log_is_read_whole() -> None:
    lines = (Path(__file__).parents[2] / "examples" / "car-candump.log").read_text().splitlines()
    for text in lines:
        line = parse_log_line(text)
        assert format_log_line(line).split(" ", 1)[1] == text.split(" ", 1)[1]
    assert len(lines) == 12_974


@pytest.mark.finding("newcomer F12")
def test_a_log_line_gives_its_frame() -> None:
    assert parse_log_line("(1.0) can0 123#1122").frame == Frame(0x123, b"\x11\x22")
    assert parse_log_line("(1.0) can0 20000040#0000000000000000").frame is None
