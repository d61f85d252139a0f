"""What `canwire dump` shows of a frame, and which frames: stamps, filters, JSON."""

from __future__ import annotations

import json
import time
from argparse import Namespace
from contextlib import ExitStack

import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import BadValue, BusEvent, ErrorKind, EventKind, Frame, LogLine, WantedMode
from canwire.commands import main
from canwire.commands.can_line import bring_up
from canwire.commands.dump.as_json import format_json
from canwire.commands.dump.filters import accepts, parse_filters
from canwire.commands.dump.stamps import Stamps
from canwire.commands.dump.verb import Dump
from canwire.commands.shared_hub import find_line

SECOND = 1_000_000_000


@pytest.mark.parametrize(
    ("kind", "shown"),
    [
        ("a", ["(1000000001.500000)", "(1000000001.500250)", "(1000000003.000000)"]),
        ("d", ["(000.000000)", "(000.000250)", "(001.499750)"]),
        ("z", ["(000.000000)", "(000.000250)", "(001.500000)"]),
    ],
)
def test_stamps(kind: str, shown: list[str]) -> None:
    stamps = Stamps(kind, 1_000_000_000 * SECOND)
    assert [stamps.text(at) for at in (1_500_000_000, 1_500_250_000, 3 * SECOND)] == shown


def test_a_date(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    assert Stamps("A", 0).text(86_400 * SECOND + 1_000) == "(1970-01-02 00:00:00.000001)"
    monkeypatch.undo()
    time.tzset()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (["123:7FF"], {0x123}),
        (["700:700"], {0x7E0, 0x7E8}),
        (["123~7FF"], {0x7E0, 0x7E8, 0x18FF1234}),
        (["123:7FF,7e8:7ff"], {0x123, 0x7E8}),
        (["123:7FF", "7E0:7FF"], {0x123, 0x7E0}),
        (["18FF0000:1FFF0000"], {0x18FF1234}),
        (["00000123:1FFFFFFF"], set()),
        ([], {0x123, 0x7E0, 0x7E8, 0x18FF1234}),
    ],
)
def test_filters(text: list[str], shown: set[int]) -> None:
    frames = [Frame(0x123), Frame(0x7E0), Frame(0x7E8), Frame(0x18FF1234, extended=True)]
    filters = parse_filters(text)
    assert {frame.id for frame in frames if accepts(filters, frame)} == shown
    assert accepts(filters, BusEvent(EventKind.ERROR))


@pytest.mark.parametrize("text", ["", "123", "123:", ":7FF", "123:7FG", "800:7FF", "123456789:1", "123=7FF"])
def test_filters_that_are_none(text: str) -> None:
    with pytest.raises(BadValue, match="--filter"):
        parse_filters([text])


@given(st.integers(0, 0x7FF), st.integers(0, 0x7FF), st.integers(0, 0x7FF))
def test_a_filter_and_its_inverse_share_out_all_frames(code: int, mask: int, id: int) -> None:
    (one,), (other,) = parse_filters([f"{code:03X}:{mask:X}"]), parse_filters([f"{code:03X}~{mask:X}"])
    assert one.accepts(Frame(id)) == ((id & mask) == (code & mask)) != other.accepts(Frame(id))


def test_json() -> None:
    frame = Frame(0x18FF1234, b"\x11\x22", extended=True)
    assert json.loads(format_json(LogLine(1_500_000_000, "can0", frame))) == {
        "time_s": 1.5,
        "line": "can0",
        "id": "18FF1234",
        "data": "1122",
        "dlc": 2,
    }
    asked = json.loads(format_json(LogLine(0, "can0", Frame(0x12, remote=True, dlc=4))))
    assert (asked["id"], asked["remote"], asked["dlc"], "data" in asked) == ("012", True, 4, False)
    fast = json.loads(format_json(LogLine(0, "can0", Frame(1, bytes(12), fd=True, bit_rate_switch=True))))
    assert (fast["fd"], fast["bit_rate_switch"], fast["dlc"]) == (True, True, 9)
    error = BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, tec=8)
    told = json.loads(format_json(LogLine(0, "can0", error)))
    assert (told["event"], told["error"], told["tec"], told["state"]) == ("error", "stuff", 8, "error_active")


@pytest.mark.parametrize(
    "words", [["--json", "-l"], ["--json", "-t", "a"], ["-l", "-t", "d"], ["--filter", "x"]]
)
def test_what_does_not_go_together(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", "can0", *words]) == 2
    assert capsys.readouterr().err.startswith("canwire: -")


def test_a_line_is_candumps(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = Namespace(
        line="can0", log=False, count=2, timeout=None, errors=False, bus_name=False, stamps="z", json=False
    )
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        shown, sender = (find_line(hub, address) for address in ("HW000001:0", "HW000001:1"))
        channels = [
            closing.enter_context(hub.open_channel(place.board.id, place.line)) for place in (shown, sender)
        ]
        for place, channel in zip((shown, sender), channels, strict=True):
            channel.set_up(canwire.ChannelMode(receive=16, transmit=16))
            bring_up(hub, place, WantedMode())
            channel.activate()
        for id in (0x100, 0x123, 0x200, 0x123):
            channels[1].send(Frame(id, b"\x11\x22"))
        Dump(arguments, hub, shown, channels[0], parse_filters(["123:7FF"])).run()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == " (000.000000)  can0  123   [2]  11 22"
    assert [line[13:] for line in lines] == ["  can0  123   [2]  11 22"] * 2
    parsed = [canwire.parse_candump_line(line) for line in lines]
    assert [line.content for line in parsed] == [
        Frame(0x123, b"\x11\x22", timestamp_ns=line.timestamp_ns) for line in parsed
    ]
