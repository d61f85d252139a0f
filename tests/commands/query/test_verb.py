"""`canwire query`: its forms, its mistakes, how it ends, and the examples of its help."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet
import pytest

import canwire
from canwire import Frame, LogEntry, convert_log, create_log
from canwire.commands import main
from canwire.commands.query import verb

pytest.importorskip("duckdb")

EXAMPLES = Path(__file__).parents[3] / "examples"
CAR = EXAMPLES / "car-candump.log"
START_NS = 1_700_000_000_123_456_789


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the examples name: trace/, drive.blf, engine.dbc."""
    folder = tmp_path_factory.mktemp("home")
    with create_log(folder / "trace", format="trace") as writer:
        for number in range(3):
            time_ns = START_NS + number * 10_000_000
            frame = Frame(0x100, bytes((number, 1, 2, 3)), timestamp_ns=time_ns)
            writer.write(LogEntry(time_ns, "can0", frame, "R"))
    convert_log(CAR, folder / "drive.blf")
    (folder / "empty").mkdir()
    shutil.copy(EXAMPLES / "engine.dbc", folder)
    return folder


EXAMPLE_LINES = re.findall(r"^canwire (query .*?)(?:  .*)?$", verb.__doc__ or "", re.MULTILINE)


@pytest.mark.conforms("PC-09")
@pytest.mark.parametrize("line", EXAMPLE_LINES)
def test_the_help_s_examples(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], line: str
) -> None:
    monkeypatch.chdir(home)
    assert len(EXAMPLE_LINES) >= 5
    assert main(shlex.split(line)) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.smoke
@pytest.mark.conforms("PC-11", "PF-08")
def test_forms(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    query = "select time, id, data, null as nothing, fd, 'a,b' as text, 1.5 as x from frames order by time limit 1"
    words = ["query", str(home / "trace"), query]
    assert main(words) == 0
    assert capsys.readouterr().out == (
        "time                            id  data      nothing  fd     text    x\n"
        "2023-11-14T22:13:20.123456789  256  00010203           false  a,b   1.5\n"
    )
    assert main([*words, "--csv"]) == 0
    assert list(csv.reader(io.StringIO(capsys.readouterr().out))) == [
        ["time", "id", "data", "nothing", "fd", "text", "x"],
        ["2023-11-14T22:13:20.123456789", "256", "00010203", "", "false", "a,b", "1.5"],
    ]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "time": "2023-11-14T22:13:20.123456789", "id": 256, "data": "00010203", "nothing": None, "fd": False,
        "text": "a,b", "x": 1.5,
    }  # fmt: skip


@pytest.mark.parametrize("rows", [0, 1, 5000])
def test_files(tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str], rows: int) -> None:
    words = ["query", str(home / "trace"), f"select range as number, 'x' as text from range({rows})", "-o"]
    for suffix in ("csv", "json", "parquet"):
        assert main([*words, str(tmp_path / f"out.{suffix}")]) == 0
    assert capsys.readouterr().out == ""
    assert len((tmp_path / "out.csv").read_text().splitlines()) == rows + 1
    assert len((tmp_path / "out.json").read_text().splitlines()) == rows
    assert pyarrow.parquet.read_table(tmp_path / "out.parquet").column("number").to_pylist() == [*range(rows)]
    assert main([*words, str(tmp_path / "out.xls")]) == 2
    assert "a file that ends with .csv, .json, .parquet" in capsys.readouterr().err
    assert main([*words, str(tmp_path / "nothing" / "out.parquet")]) == 2
    assert "No such file" in capsys.readouterr().err


def test_a_file_is_written_whole_or_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, out = tmp_path / "log.parquet", tmp_path / "out.csv"
    convert_log(CAR, log)
    out.write_text("before")
    wrong = "select cast(case when range < 5000 then '1' else 'corrupt' end as int) from range(6000)"
    assert main(["query", str(log), wrong, "-o", str(out)]) == 2
    assert "Could not convert string 'corrupt'" in capsys.readouterr().err
    assert out.read_text() == "before"
    before = log.read_bytes()
    convert_log(log, tmp_path / "log.trace")
    for trace, place in ((log, log), (tmp_path / "log.trace", tmp_path / "log.trace" / "out.parquet")):
        assert main(["query", str(trace), "select 1", "-o", str(place)]) == 2
        assert "it is what is read; write the result elsewhere" in capsys.readouterr().err
    assert log.read_bytes() == before
    assert sorted(os.listdir(tmp_path)) == ["log.parquet", "log.trace", "out.csv"]


@pytest.mark.conforms("PF-09")
def test_what_it_finds_is_a_log_again(tmp_path: Path, home: Path) -> None:
    part = tmp_path / "part.parquet"
    query = "select * from entries where id = 258 order by time_ns, row"
    assert main(["query", str(home / "drive.blf"), query, "-o", str(part)]) == 0
    with canwire.open_log(part) as found, canwire.open_log(CAR) as log:
        wanted = [entry.frame for entry in log if entry.frame and entry.frame.id == 258]
        assert [entry.frame for entry in found] == wanted
        assert not found.faults
    assert main(["query", str(home / "trace"), "select * from entries", "-o", str(part)]) == 0
    with canwire.open_log(part) as found:
        assert next(iter(found)).timestamp_ns == START_NS
        assert found.dated
    with canwire.open_trace(part) as trace:
        assert trace.dated


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["trace", "selec 1"], "SQL, line 1, column 1: syntax error at or near selec"),
        (["trace", "select * from frams"], "no table frams; did you mean frames?"),
        (["trace", "select cast('x' as int)"], "Could not convert string 'x' to INT32"),
        (["trace", "select 1", "--memory", "much"], "--memory much: a number and M or G"),
        (["trace", "select 1", "--db", "nothing.dbc"], "nothing.dbc: No such file"),
        (["empty", "select 1"], "a folder without Parquet files, so no trace"),
        (["engine.dbc", "select 1"], "is no log that canwire knows"),
    ],
)
def test_mistakes_are_one_line_and_status_2(
    home: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    said: str,
) -> None:
    monkeypatch.chdir(home)
    assert main(["query", *words]) == 2
    told = capsys.readouterr()
    assert said in told.err
    assert (told.out, told.err.count("\n")) == ("", 1)


def test_a_damaged_file_is_said_and_status_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    convert_log(CAR, tmp_path / "log.trace")
    (tmp_path / "log.trace" / "00002.parquet").write_bytes(b"PAR1")
    assert main(["query", str(tmp_path / "log.trace"), "select count(*) as n from frames"]) == 1
    told = capsys.readouterr()
    assert told.out == "    n\n12974\n"
    assert f"{tmp_path}/log.trace: 00002.parquet: no whole Parquet file" in told.err


LONG = "select sum(a.range * b.range) from range(100000000) a, range(100000) b"


@pytest.mark.realtime
@pytest.mark.conforms("PC-10")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
def test_signals_end_a_query(home: Path, number: signal.Signals) -> None:
    words = [sys.executable, "-m", "canwire", "query", str(home / "trace"), LONG]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    children = Path(f"/proc/{process.pid}/task")
    while process.poll() is None and not any("spilled" in name for name in opened(process.pid)):
        if len(list(children.iterdir())) > 1:  # DuckDB's threads are at work
            break
    process.send_signal(number)
    shown, told = process.communicate(timeout=60)
    assert (process.returncode, shown) == (128 + number, "")
    assert "Traceback" not in told
    assert "leaked" not in told


def opened(process: int) -> list[str]:
    try:
        return [os.readlink(one) for one in Path(f"/proc/{process}/fd").iterdir()]
    except OSError:
        return []


@pytest.mark.conforms("PC-10")
@pytest.mark.parametrize("query", ["select * from range(1000000)", "selec"])
def test_nothing_is_said_at_the_interpreter_s_end(home: Path, query: str) -> None:
    """DuckDB's binding complains of connections that are left open."""
    command = f'{shlex.quote(sys.executable)} -m canwire query trace "{query}" | head -1'
    ended = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command}"], capture_output=True, text=True, cwd=home, timeout=60
    )
    assert ended.returncode == (2 if query == "selec" else 141)
    assert ended.stdout == ("" if query == "selec" else "range\n")
    assert ended.stderr.count("\n") == (query == "selec")
