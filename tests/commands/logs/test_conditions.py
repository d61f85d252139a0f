"""`canwire record --start-on`, `--stop-on`: what the conditions mean, and a recording by them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from canwire import (
    BadValue,
    BusEvent,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    LogEntry,
    load_database,
    open_log,
)
from canwire.commands import main
from canwire.commands.logs.conditions import any_of
from tests import warm
from tests.cases import each
from tests.hubs import LONG_S

ENGINE = Path(__file__).parents[3] / "examples" / "engine.dbc"
SPEED_3500 = Frame(0x100, (14000).to_bytes(2, "little") + bytes(6))  # a quarter of a turn a bit
READY = Frame(0x100, bytes([0, 0, 0, 1, 0, 0, 0, 0]))


def entry(content: Frame | BusEvent) -> LogEntry:
    return LogEntry(0, "can0", content)


@each(
    ("text", "true", "false"),
    [
        ("123", Frame(0x123), Frame(0x124)),
        ("100-1FF", Frame(0x1FF), Frame(0x200)),
        ("120:7F0", Frame(0x12F), Frame(0x130)),
        ("~123", Frame(0x124), Frame(0x123)),
        ("00000123", Frame(0x123, extended=True), Frame(0x123)),
        ("123#11..f0", Frame(0x123, b"\x11\x55\xf0\x00"), Frame(0x123, b"\x11\x55\xe0")),
        ("123#1.", Frame(0x123, b"\x1f"), Frame(0x123)),
        ("100-1FF#22", Frame(0x150, b"\x22"), Frame(0x250, b"\x22")),
        ("error", BusEvent(EventKind.ERROR, error=ErrorKind.STUFF), BusEvent(EventKind.STATE)),
        ("state", BusEvent(EventKind.STATE), Frame(1)),
        ("bus-off", BusEvent(EventKind.STATE, state=ErrorState.BUS_OFF), BusEvent(EventKind.STATE)),
        ("EngineSpeed>3000", SPEED_3500, READY),
        ("EngineData.EngineSpeed <= 3500", SPEED_3500, Frame(0x101)),
        ("EngineSpeed!=0", SPEED_3500, READY),
        ("Ready=yes", READY, SPEED_3500),
        ("Ready!=yes", SPEED_3500, READY),
        ("Gear=neutral", Frame(0x200, bytes(4)), Frame(0x200, b"\x01" + bytes(3))),  # on another page
    ],
)
def test_conditions(text: str, true: Frame | BusEvent, false: Frame | BusEvent) -> None:
    condition = any_of([text], "--start-on", load_database(ENGINE))
    assert condition is not None
    assert condition(entry(true))
    assert not condition(entry(false))


def test_any_of_several() -> None:
    condition = any_of(["123", "error"], "--start-on", None)
    assert condition is not None
    assert condition(entry(Frame(0x123)))
    assert condition(entry(BusEvent(EventKind.ERROR)))
    assert any_of([], "--stop-on", None) is None


@each(
    ("text", "why"),
    [
        ("EngineSped>1", r"--stop-on EngineSped>1: .*engine.dbc has no such signal"),
        ("Engine.EngineSpeed>1", "no message 'Engine'; did you mean EngineData"),
        ("Ready>yes", "'yes' is a text, which = and != compare"),
        ("hello", "--stop-on: 'hello': an identifier in hex"),
        ("9FF", "--stop-on: .*9FF is no identifier of 11 bits"),
    ],
)
def test_what_is_none(text: str, why: str) -> None:
    with pytest.raises(BadValue, match=why):
        any_of([text], "--stop-on", load_database(ENGINE))


def test_signals_need_a_database(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["record", "can0", "x.log", "--start-on", "EngineSpeed>3000"]) == 2
    assert "signals need the database that describes them: --db FILE" in capsys.readouterr().err
    assert main(["record", "can0", "x.log", "--before", "2s"]) == 2
    assert "before_s 2.0: needs a condition to start" in capsys.readouterr().err


@pytest.mark.realtime
@pytest.mark.conforms("PG-08")
def test_one_part_and_the_end(tmp_path: Path, hub_address: str) -> None:
    out = tmp_path / "part.log"
    words = [
        "record",
        "can0",
        str(out),
        "--start-on",
        "123#11",
        "--stop-on",
        "124",
        "--before",
        "1h",
        "--once",
    ]
    command = [sys.executable, "-m", "canwire", *words, "--hub", hub_address]
    with warm.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert "recording can0 to" in process.stderr.readline()
        frames = ["100#", "123#22", "123#11", "101#", "124#", "102#"]
        assert main(["send", "can0", *frames, "--hub", hub_address, "--timeout", str(LONG_S)]) == 0
        assert process.wait(LONG_S) == 0
        assert "entries in" in process.stderr.read()
    with open_log(out) as log:
        assert [found.frame.id for found in log if found.frame] == [0x100, 0x123, 0x123, 0x101, 0x124]
