"""`canwire db` and `canwire decode`, and how verbs take databases: several, by channel, not strict."""

from __future__ import annotations

import json
from argparse import Namespace
from pathlib import Path

import pytest

from canwire import Frame, frames_to_array, load_database
from canwire.commands import main
from canwire.commands.databases.chosen import databases_of
from canwire.commands.databases.picture import bits_of, picture_of
from canwire.commands.plot.choosing import choose_signals
from canwire.commands.plot.decoding import Decoding
from canwire.commands.plot.tracks import Tracks

ONE = """VERSION ""
BU_: ECU
BO_ 256 Engine: 3 ECU
 SG_ Speed : 7|12@0+ (0.5,0) [0|2000] "rpm" Vector__XXX
 SG_ Hot : 16|1@1+ (1,0) [0|1] "" Vector__XXX
BO_ 512 Brake: 1 ECU
 SG_ Pressed : 0|1@1+ (1,0) [0|1] "" Vector__XXX
VAL_ 256 Hot 0 "no" 1 "yes" ;
"""
OTHER = ONE.replace("0.5,0", "0.25,0").replace("BO_ 512 Brake", "BO_ 512 Pedal")
OVERLAPPING = ONE.replace("16|1@1+", "0|8@1+")
LOG = "(1.000000) can0 100#640001\n(2.000000) can1 100#640001\n(3.000000) can0 300#\n"


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in (("one.dbc", ONE), ("other.dbc", OTHER), ("bad.dbc", OVERLAPPING), ("drive.log", LOG)):
        (tmp_path / name).write_text(text)


def said(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> list[str]:
    assert main(list(words)) == status
    return capsys.readouterr().out.splitlines()


def test_messages_and_bits(capsys: pytest.CaptureFixture[str]) -> None:
    first, second = said(capsys, "db", "one.dbc")
    assert first.split() == ["100", "Engine", "3", "bytes", "2", "signals", "from", "ECU"]
    assert second.split()[:2] == ["200", "Brake"]
    assert said(capsys, "db", "one.dbc", "0x100")[1:7] == [
        "  byte  7 6 5 4 3 2 1 0",
        "     0  A A A A A A A A   A Speed",
        "     1  A A A A . . . .   B Hot",
        "     2  . . . . . . . B",
        "  Speed; bit 7, 12 bits, big endian, unsigned; x 0.5 + 0; 0 to 2000 rpm",
        "  Hot; bit 16, 1 bits, little endian, unsigned; x 1 + 0; 0 to 1; 0: no, 1: yes",
    ]


def test_the_picture_of_every_message_has_each_bit_once() -> None:
    message = load_database("one.dbc").message("Engine")
    assert sum(row.count("A") for row in list(picture_of(message))[1:]) == 12 + 1
    assert list(bits_of(message.signals["Speed"])) == [7, 6, 5, 4, 3, 2, 1, 0, 15, 14, 13, 12]


def test_a_search_and_a_difference(capsys: pytest.CaptureFixture[str]) -> None:
    (found,) = said(capsys, "db", "one.dbc", "--search", "RPM")
    assert "Engine.Speed" in found
    assert said(capsys, "db", "one.dbc", "--search", "nothing", status=1) == []
    assert said(capsys, "db", "one.dbc", "--diff", "one.dbc") == []
    different = said(capsys, "db", "one.dbc", "--diff", "other.dbc", status=1)
    assert [line[0] for line in different] == ["<", ">", "<", ">"]
    assert ("Brake" in different[2], "Pedal" in different[3]) == (True, True)
    assert "x 0.25 + 0" in different[1]


def test_not_strict_and_encodings(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["db", "bad.dbc"]) == 2
    assert "overlap" in capsys.readouterr().err
    assert len(said(capsys, "db", "bad.dbc", "--no-strict")) == 2
    assert main(["db", "one.dbc", "--encoding", "klingon"]) == 2
    assert "unknown encoding: klingon" in capsys.readouterr().err


def test_a_log_by_databases_of_its_channels(capsys: pytest.CaptureFixture[str]) -> None:
    assert said(capsys, "decode", "drive.log", "--db", "can0=one.dbc", "--db", "can1=other.dbc") == [
        "(1.000000) can0 100 Engine(Speed: 800 rpm, Hot: yes)",
        "(2.000000) can1 100 Engine(Speed: 400 rpm, Hot: yes)",
    ]
    assert len(said(capsys, "decode", "drive.log", "--db", "one.dbc", "--all")) == 3
    assert len(said(capsys, "decode", "drive.log", "--db", "can1=one.dbc")) == 1


def test_forms(capsys: pytest.CaptureFixture[str]) -> None:
    rows = [
        line.split("\t")
        for line in said(capsys, "decode", "drive.log", "--db", "one.dbc", "--form", "columns")
    ]
    assert rows[:3] == [
        ["time_s", "channel", "message", "signal", "value", "unit", "text"],
        ["1.000000", "can0", "Engine", "Speed", "800.0", "rpm", ""],
        ["1.000000", "can0", "Engine", "Hot", "1", "", "yes"],
    ]
    told = [
        json.loads(line) for line in said(capsys, "decode", "drive.log", "--db", "one.dbc", "--form", "json")
    ]
    assert told[0] == {
        "time_s": 1.0,
        "channel": "can0",
        "id": "100",
        "data": "640001",
        "message": "Engine",
        "signals": {"Speed": 800.0, "Hot": "yes"},
        "numbers": {"Speed": 800.0, "Hot": 1},
    }


def test_a_second_database_is_not_dropped(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["gen", "can0", "--db", "one.dbc", "--db", "other.dbc"])
    assert "one file only for this verb, not one.dbc and other.dbc" in capsys.readouterr().err


CHANNELS = ("--db", "can0=one.dbc", "--db", "can1=other.dbc")


def test_statistics_by_databases_of_channels(capsys: pytest.CaptureFixture[str]) -> None:
    text = "(1.000000) can0 100#640001\n(2.000000) can1 200#01\n(3.000000) can0 200#01\n"
    Path("drive.log").write_text(text)
    (told,) = said(capsys, "stats", "drive.log", *CHANNELS, "--json")
    assert [(one["channel"], one["id"], one["message"]) for one in json.loads(told)["identifiers"]] == [
        ("can0", 0x100, "Engine"),
        ("can0", 0x200, "Brake"),
        ("can1", 0x200, "Pedal"),
    ]


def test_plots_by_databases_of_channels(capsys: pytest.CaptureFixture[str]) -> None:
    """Of one channel's files the first that knows a frame counts."""
    databases = databases_of(Namespace(db=["can0=one.dbc", "other.dbc"], encoding=None, no_strict=False))
    assert databases is not None
    chosen = choose_signals(databases, ["Speed", "Pedal.Pressed"])
    tracks = Tracks(chosen.labels)
    decoding = Decoding(chosen, tracks)
    for channel in ("can0", "can1"):
        frames = [Frame(0x100, b"\x64\x00\x01"), Frame(0x200, b"\x01")]
        decoding.add(channel, frames_to_array(frames), 0)
    assert {(track.name, *track.values) for track in tracks.filled} == {
        ("can0 Engine.Speed", 800.0),
        ("can1 Engine.Speed", 400.0),
        ("can1 Pedal.Pressed", 1.0),
    }
    assert main(["plot", "drive.log", *CHANNELS, "Speed", "-o", "speed.html"]) == 0
    assert "2 samples of 2 signals" in capsys.readouterr().err


@pytest.mark.parametrize("databases", [CHANNELS, ("--db", "other.dbc", "--db", "can0=one.dbc")])
def test_queries_by_databases_of_channels(
    databases: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("duckdb")
    sql = "select channel, value from {} order by time_ns, row"
    words = (*databases, "--csv")
    expected = ["channel,value", "can0,800.0", "can1,400.0"]
    assert (
        said(capsys, "query", "drive.log", sql.format("signals where signal = 'Speed'"), *words) == expected
    )
    assert (
        said(capsys, "query", "drive.log", sql.replace("value", "Speed as value").format("Engine"), *words)
        == expected
    )


def test_signals_as_a_parquet_table(capsys: pytest.CaptureFixture[str]) -> None:
    """By a database for each channel; a mistake leaves the file as it was."""
    parquet = pytest.importorskip("pyarrow.parquet")
    words = ("decode", "drive.log", "--db", "can0=one.dbc", "--db", "can1=other.dbc", "-o", "signals.parquet")
    assert said(capsys, *words) == ["4 values to signals.parquet"]
    rows = parquet.read_table("signals.parquet").to_pylist()
    assert [(row["time_ns"], row["channel"], row["signal"], row["value"], row["text"]) for row in rows] == [
        (1_000_000_000, "can0", "Speed", 800.0, None), (1_000_000_000, "can0", "Hot", 1.0, "yes"),
        (2_000_000_000, "can1", "Speed", 400.0, None), (2_000_000_000, "can1", "Hot", 1.0, "yes"),
    ]  # fmt: skip
    assert (rows[0]["time_s"], rows[0]["message"], rows[0]["unit"]) == (1.0, "Engine", "rpm")
    assert main([*words[:-1], "signals.csv"]) == 2
    assert "a .parquet file" in capsys.readouterr().err
    Path("drive.log").write_bytes(b"no log at all")
    assert main(list(words)) == 2
    assert "no log that canwire knows" in capsys.readouterr().err
    assert parquet.read_table("signals.parquet").num_rows == 4
