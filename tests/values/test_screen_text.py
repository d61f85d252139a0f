"""candump's screen lines, byte by byte: examples, options, round trips, the installed log2long."""

from __future__ import annotations

import subprocess

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadText
from canwire.values.dlc import FD_LENGTHS
from canwire.values.event import BusEvent, ErrorState, EventKind
from canwire.values.frame import Frame
from canwire.values.screen_text import format_candump_line, parse_candump_line
from canwire.values.text import LogLine, format_log_line, parse_frame
from tests.cases import each
from tests.missing import needs_program


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


SCREEN: list[
    tuple[str, Frame | BusEvent]
] = [  # linux-can/can-utils: lib.h's examples, and what the installed log2long prints
    ("  can0  123   [8]  11 22 33 44 55 66 77 88", Frame(0x123, bytes.fromhex("1122334455667788"))),
    ("  can0  123   [0] ", Frame(0x123)),
    ("  can0  12345678   [3]  11 22 33", Frame(0x12345678, b"\x11\x22\x33", extended=True)),
    ("  can0  123   [4]  remote request", Frame(0x123, remote=True, dlc=4)),
    ("  can0  12345678   [0]  remote request", Frame(0x12345678, extended=True, remote=True)),
    ("  can0  12345678  [03]  11 22 33", Frame(0x12345678, b"\x11\x22\x33", extended=True, fd=True)),
    ("  can0  123  [64] " + " 5A" * 64, Frame(0x123, b"\x5a" * 64, fd=True)),
    (
        "  can0  20000004   [8]  00 08 00 00 00 00 00 00   ERRORFRAME",
        BusEvent(EventKind.STATE, state=ErrorState.ERROR_WARNING),
    ),
]


@pytest.mark.conforms("PC-01")
@each(("text", "content"), SCREEN)
def test_screen_lines_both_ways(text: str, content: Frame | BusEvent) -> None:
    assert format_candump_line(LogLine(0, "can0", content)) == text
    assert parse_candump_line(text + "\n") == (0, "can0", content, None)


def test_screen_lines_with_options() -> None:
    frame = Frame(0x123, b"A\x00'", fd=True, bit_rate_switch=True)
    line = LogLine(1_436_509_052_249_713_000, "can0", frame, "T")
    text = format_candump_line(line, timestamp=True, indent=True, ascii=True, width=6)
    assert text == " (1436509052.249713)    can0  TX B -       123  [03]  41 00 27                  'A.''"
    assert parse_candump_line(text) == line
    swapped = LogLine(0, "can0", Frame(0x123, b"A\x11B"))
    text = format_candump_line(swapped, swap=True, ascii=True)
    assert text == "  can0  123   [3]  42`11`41                  `B.A`"
    assert parse_candump_line(text) == swapped
    raw = LogLine(0, "can0", Frame(0x123, bytes(8), dlc=11))
    text = format_candump_line(raw, raw_dlc=True)
    assert text == "  can0  123   {B}  00 00 00 00 00 00 00 00"
    assert parse_candump_line(text) == raw


@given(frames(), st.booleans(), st.booleans(), st.booleans(), st.booleans())
def test_screen_lines_come_back(frame: Frame, indent: bool, ascii: bool, raw_dlc: bool, swap: bool) -> None:
    line = LogLine(1_000, "can0", frame, "R")
    text = format_candump_line(line, timestamp=True, indent=indent, ascii=ascii, raw_dlc=raw_dlc, swap=swap)
    found = parse_candump_line(text)
    if raw_dlc or frame.dlc <= 8 or frame.fd:
        assert found == line
    assert isinstance(found.content, Frame)
    assert (found.content.id, found.content.data) == (frame.id, frame.data)


@each(
    "text",
    [
        "",
        "  can0  123   [2]  11",
        "  can0  123   [2]  11 22 33",
        "  can0  123   [9]  11 22 33 44 55 66 77 88 99",
        "  can0  123   [3]  22`11",
        "  can0  123   [3]  33`22 11",
        "  can0  123   [1]  10101010",
        "  can0  923   [0]",
        "  can0  123  [09]  11 22 33 44 55 66 77 88 99",
        " (99999999999.0)  can0  123   [0]",
    ],
)
def test_bad_screen_lines(text: str) -> None:
    with pytest.raises(BadText, match=r"^'"):
        parse_candump_line(text)


@pytest.mark.conforms("PC-01")
@needs_program("log2long")
def test_screen_lines_agree_with_log2long() -> None:
    contents: list[Frame | BusEvent] = [
        parse_frame(text) for text in ("123#R8_9", "123##3AABB", "123#1122334455667788_E")
    ]
    contents += [content for _, content in SCREEN]
    contents += [Frame(0x100, bytes(range(start, start + 8))) for start in range(0, 256, 8)]
    contents += [Frame(0x1F, bytes(size), fd=True) for size in FD_LENGTHS]
    lines = [LogLine(1_436_509_052_249_713_000, "vcan0", content) for content in contents]
    log = "".join(format_log_line(line) + "\n" for line in lines)

    shown = subprocess.run(
        ["log2long"], input=log, capture_output=True, text=True, check=True, timeout=20
    ).stdout

    ours = [format_candump_line(line, timestamp=True, indent=True, ascii=True) for line in lines]
    assert [" " + line for line in shown.splitlines()] == ours
