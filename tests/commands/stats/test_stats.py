"""`canwire stats`, and the examples of its help."""

from __future__ import annotations

import io
import json
import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest

from canwire import Frame, LogEntry, convert_log, create_log
from canwire.commands import VERBS, main

CAR = Path(__file__).parents[3] / "examples" / "car-candump.log"
DATABASE = Path(__file__).parents[1] / "car.dbc"
ENGINE = Path(__file__).parents[3] / "examples" / "engine.dbc"


def examples() -> list[str]:
    import importlib

    text = importlib.import_module(VERBS["stats"].module).__doc__ or ""
    return re.findall(r"^canwire (stats\b.*?)(?:  .*)?$", text, re.MULTILINE)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """300 frames, 10 ms from one to the next."""
    path = tmp_path_factory.mktemp("log") / "drive.log"
    with create_log(path, dated=False) as writer:
        for number in range(300):
            time_ns = 10**9 + number * 10_000_000
            frame = Frame(0x123, bytes(8), timestamp_ns=time_ns)
            writer.write(LogEntry(time_ns, "can0", frame, "RT"[number % 2]))
    return path


@pytest.fixture
def drive(log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """drive.log and two parts of a day, as the help has them."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATABASE, tmp_path)
    for name in ("drive.log", "day-0001.log", "day-0002.log"):
        shutil.copy(log, name)
    return tmp_path / "drive.log"


@pytest.mark.usefixtures("drive")
@pytest.mark.parametrize("example", examples())
def test_the_help_s_examples(example: str, capsys: pytest.CaptureFixture[str]) -> None:
    if "--db" in example:
        pytest.importorskip("cantools")
    assert main(shlex.split(example)) == 0
    told = capsys.readouterr()
    assert told.err == ""
    assert "can0" in told.out


def test_there_are_some() -> None:
    assert len(examples()) >= 6


@pytest.mark.smoke
@pytest.mark.conforms("PC-10")
def test_what_people_read(drive: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stats", str(drive), "--bit-rate", "can0=500000"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{drive}: candump, 300 entries, 2.990 s"
    assert lines[1].startswith("can0: 300 frames, 150 received, 150 transmitted, 0 errors, 0 lost, load 2.")
    assert lines[3].split() == [
        "channel",
        "id",
        "count",
        "period",
        "least",
        "most",
        "jitter",
        "gaps",
        "dlc",
        "dir",
    ]
    assert lines[4].split() == ["can0", "123", "300", "10.000", "10.000", "10.000", "0.000", "0", "8", "RT"]
    assert lines[6] == "load of can0, in steps of 0.2 s"
    assert re.fullmatch(r" +0\.0 s +2\.\d %  #", lines[7])


def test_beside_a_database(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cantools")
    from canwire import load_database

    database = load_database(ENGINE)
    messages = [one for one in database.messages.values() if one.cycle_s]
    there, missing = messages[0], messages[1:]
    log = tmp_path / "engine.log"
    step_ns = round((there.cycle_s or 0) * 1.1e9)
    with create_log(log, dated=False) as writer:
        for number in range(50):
            frame = Frame(
                there.id, bytes(there.length), extended=there.extended, timestamp_ns=number * step_ns
            )
            writer.write(LogEntry(number * step_ns, "can0", frame))
    assert main(["stats", str(log), "--db", str(ENGINE)]) == 0
    out = capsys.readouterr().out
    assert re.search(rf"\+10\.0 % +{there.name}$", out, re.MULTILINE)
    for one in missing:
        assert f"{one.name} (" in out
    assert main(["stats", str(log), "--db", str(ENGINE), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["identifiers"][0]["message"] == there.name
    assert facts["identifiers"][0]["deviation_percent"] == pytest.approx(10)
    assert [one["message"] for one in facts["missing"]] == [one.name for one in missing]


@pytest.mark.conforms("PC-11")
def test_json_of_every_log(drive: Path, capsys: pytest.CaptureFixture[str]) -> None:
    blf = drive.with_name("drive.blf")
    convert_log(drive, blf)
    assert main(["stats", str(drive), str(blf), "--json", "--bit-rate", "500000"]) == 0
    one, other = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert (one["format"], other["format"], one["logs"]) == ("candump", "blf", [str(drive)])
    assert one["identifiers"] == other["identifiers"]
    assert one["channels"][0]["peak"] == max(one["channels"][0]["loads"])


def test_from_standard_input(
    drive: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with drive.open("rb") as file:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(file))
        assert main(["stats", "-"]) == 0
    assert "300 entries" in capsys.readouterr().out


def test_faults_are_told_and_are_the_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "cut.blf"
    convert_log(CAR, log)
    log.write_bytes(log.read_bytes()[:-5000])
    assert main(["stats", str(log)]) == 1
    told = capsys.readouterr()
    assert re.search(rf"canwire: {re.escape(str(log))}: byte \d+: ", told.err)
    assert re.search(r"vcan0|can0: \d+ frames", told.out)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing.log"], "No such file"),
        (["no.log"], "no.log is no log that canwire knows"),
        (["drive.log", "--bit-rate", "fast"], "--bit-rate fast: bits a second"),
        (["drive.log", "--bit-rate", "=5"], "--bit-rate =5: bits a second"),
        (["drive.log", "--from", "cvs"], "did you mean csv"),
        (["drive.log", "--db", "no.log"], "no.log"),
    ],
)
@pytest.mark.usefixtures("drive")
def test_mistakes_are_one_line(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    if "--db" in words:
        pytest.importorskip("cantools")
    Path("no.log").write_text("nothing of a log\n" * 1000)
    assert main(["stats", *words]) == 2
    told = capsys.readouterr()
    assert said in told.err
    assert (told.out, told.err.count("\n")) == ("", 1)
