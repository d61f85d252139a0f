"""`canwire bits`: the vectors of can-protocol.md section 11, durations, and a drawing that reads back."""

from __future__ import annotations

import json
from typing import Any

import pytest

import canwire
from canwire.commands import main
from canwire.commands.lab.waveform import draw
from tests.cases import each

# (frame, dynamic stuff bits, CRC, full stream with the ACK slot dominant), copied from section 11
STREAMS = {
    "C01": ("000#", 6, 0x0000, "00000100000100000100000100000100000100001011111111"),
    "C04": ("123#1122", 2, 0x04B7, "00010010001100000110000100010010001000001100101101111011111111"),
    "C17": ("123#R", 1, 0x1B9D, "000100100011100000100011011100111011011111111"),
    "C20": ("12345678#R", 2, 0x1F52, "010010001101110001010110011110001000001000111110010100101011111111"),
    "D01": ("123##0", 1, 0x0515A, "000100100011001000001001001100010110001101011101001011111111"),
    "D03": ("123##311", 0, 0x04A55, "0001001000110010110001000100010000010010101010001011010111011111111"),
    "D14": (
        "12345678##0AABB",
        1,
        0x0169F,
        "01001000110111000101011001111000010000011010101010101110110001100000110110010011111011011111111",
    ),
}
COUNTING = bytes(range(64)).hex()


def facts(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    assert main(["bits", *words, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


@each(("text", "stuff_bits", "crc", "stream"), STREAMS.values(), ids=STREAMS)
def test_vectors(
    capsys: pytest.CaptureFixture[str], text: str, stuff_bits: int, crc: int, stream: str
) -> None:
    found = facts(capsys, text)
    assert set(found) == {"bits", "length", "stuff_bits", "crc", "duration_ns", "fields"}
    assert found["bits"] == stream
    assert (found["length"], found["stuff_bits"], found["crc"]) == (len(stream), stuff_bits, crc)


@each(
    ("words", "duration_ns"),
    [
        (["123#1122"], 124_000),  # C04: 62 bits
        (["123#1122", "--bit-rate", "1000000"], 62_000),
        (["123#1122", "--bit-rate", "30000"], 62e9 / 30_000),
        (["100##1" + COUNTING], 343_500),  # D12, from section 4
        (["456##1" + COUNTING[:24]], 122_000),  # D06, from section 4
        (["456##1" + COUNTING[:24], "--data-bit-rate", "500000"], 332_000),
        (["456##0" + COUNTING[:24], "--data-bit-rate", "8000000"], 332_000),  # no BRS: one rate
    ],
)
def test_duration(capsys: pytest.CaptureFixture[str], words: list[str], duration_ns: float) -> None:
    assert facts(capsys, *words)["duration_ns"] == pytest.approx(duration_ns, rel=1e-12)


@pytest.mark.conforms("G-06")
@pytest.mark.parametrize("text", ["123#1122", "12345678#R", "7FF#FFFFFFFFFFFFFFFF", "321##1" + COUNTING[:40]])
def test_the_bus_takes_as_long(capsys: pytest.CaptureFixture[str], text: str) -> None:
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
        sender, receiver = bus.node("sender"), bus.node("receiver")
        sender.send(canwire.parse_frame(text))
        frame = receiver.receive(timeout=0.01)
    assert frame is not None
    assert facts(capsys, text)["duration_ns"] == frame.timestamp_ns


NON_ISO_CRCS = [("123##0", 0x012B7), ("123##311", 0x11E8A), ("12345678##0AABB", 0x1EBB6)]  # D01, D03, D14


@pytest.mark.parametrize(("text", "crc"), NON_ISO_CRCS)
def test_non_iso(capsys: pytest.CaptureFixture[str], text: str, crc: int) -> None:
    iso, non_iso = facts(capsys, text), facts(capsys, text, "--non-iso")
    assert (non_iso["crc"], non_iso["length"]) == (crc, iso["length"] - 5)
    assert "STUFF COUNT" not in [field["name"] for field in non_iso["fields"]]


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("123#1122", "SOF ID RTR IDE r0 DLC DATA CRC,CRC DEL,ACK,ACK DEL,EOF"),
        ("12345678#R", "SOF ID SRR IDE,ID EXT,RTR r1 r0 DLC CRC,CRC DEL,ACK,ACK DEL,EOF"),
        ("123##1AA", "SOF ID RRS IDE FDF res BRS ESI DLC DATA,STUFF COUNT,CRC,CRC DEL,ACK,ACK DEL,EOF"),
        (
            "12345678##0AA",
            "SOF ID SRR IDE,ID EXT,RRS FDF res BRS ESI DLC DATA,STUFF COUNT,CRC,CRC DEL,ACK,ACK DEL,EOF",
        ),
    ],
)
def test_fields_have_their_formats_names(capsys: pytest.CaptureFixture[str], text: str, names: str) -> None:
    found = facts(capsys, text)
    expected = [name for part in names.split(",") for name in ([part] if part in TWO_WORDS else part.split())]
    assert [field["name"] for field in found["fields"]] == expected
    assert "".join(field["bits"] for field in found["fields"]) == found["bits"]


TWO_WORDS = {"ID EXT", "STUFF COUNT", "CRC DEL", "ACK DEL"}


def test_stuff_bits_are_where_five_equal_bits_end(capsys: pytest.CaptureFixture[str]) -> None:
    found = facts(capsys, "000#")
    places = [place for field in found["fields"] for place in field["stuff"]]
    assert places == [5, 11, 17, 23, 29, 35]
    assert [found["bits"][place] for place in places] == ["1"] * 6


@pytest.mark.smoke
def test_page_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bits", "123#DEADBEEF", "--bit-rate", "250000"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:3] == [
        "123#DEADBEEF  data frame, 11-bit identifier, DLC 4, 4 data bytes",
        "78 bits from SOF to the end of EOF, 2 stuff bits among them (in parentheses)",
        "312 us at 250000 bit/s; 3 bits of intermission follow",
    ]
    assert "DATA     11011110101011011011111(0)011101111" in lines
    assert "CRC      1(0)00111001101011  0x4e6b" in lines
    assert all(line.isascii() and len(line) <= 100 for line in lines)  # no terminal: plain


def test_a_terminal_gets_lines_of_its_width(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "40")
    assert main(["bits", "123#1122"]) == 0
    drawing = [line for line in capsys.readouterr().out.splitlines() if set(line) & set("─┐└┌┘")]
    assert len(drawing) == 7  # 62 bits, 19 a row, two lines each; the last row has no dominant bit
    assert max(map(len, drawing)) == 38


@each(("fancy", "stroke"), [(True, "─"), (False, "_")])
@each("width", [40, 61, 1000])
def test_the_drawing_shows_every_level(fancy: bool, stroke: str, width: int) -> None:
    stream = STREAMS["C04"][3]
    lines = draw([int(bit) for bit in stream], [0] * len(stream), [], width, fancy=fancy)
    assert max(map(len, lines)) <= width
    shown = ""
    for block in "\n".join(lines).split("\n\n"):
        upper, lower, *_ = *block.split("\n"), ""
        columns = range(1, max(len(upper), len(lower)), 2)
        highs = "".join("1" if upper[k : k + 1] == stroke else "0" for k in columns)
        lows = "".join("0" if lower[k : k + 1] == stroke else "1" for k in columns)
        assert highs == lows
        shown += highs
    assert shown == stream


def test_the_drawing_names_fields_and_marks_stuff_bits() -> None:
    levels, stuffed = [0, 0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1, 0]
    assert draw(levels, stuffed, [(0, "SOF"), (1, "ID"), (4, "CRC"), (6, "A")], 80, fancy=True) == [
        "   ID    CRC A",
        "┐         ┌─┐",
        "└─────────┘ └─",
        "           s",
    ]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["123"], "has no #"),
        (["800#"], "identifier"),
        (["123#11223344556677889900"], "at most 8"),
        (["123#", "--bit-rate", "0"], "--bit-rate 0: more than 0 bit/s"),
        (["123#", "--data-bit-rate", "-1"], "--data-bit-rate -1"),
    ],
)
def test_mistakes_are_one_line(capsys: pytest.CaptureFixture[str], words: list[str], why: str) -> None:
    assert main(["bits", *words]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("canwire: ")
    assert captured.err.count("\n") == 1
    assert why in captured.err
