"""Logs of text read by blocks are what the same readers make of each line by itself: entries, channels, faults."""

from __future__ import annotations

import io
import random
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from canwire import Frame, LogBatch, LogEntry, create_log
from canwire.logs import asc, trc
from canwire.logs.asc import reading as asc_reading
from canwire.logs.blocks import reading
from canwire.logs.limits import USUAL
from canwire.logs.lines import read_lines
from canwire.logs.source import Source
from canwire.logs.tables import csv
from canwire.logs.tables.csv import reading as csv_reading
from canwire.logs.tables.csv.named import dialect_of
from canwire.logs.tables.csv.rows import HEADER, row_of_ours
from canwire.logs.trc import reading as trc_reading
from tests.logs.contents import START_NS, entries, frames

LONGEST = USUAL.line_bytes
FORMATS = ("asc", "trc", "csv")
SPOILT = (b'"', b"\n", b"\r", b"\r\n", b"\0", b",", b" ", b"\t", b"\xff", b";", b"-", b"x", b"9", b"F", b".", b"\x0b",
          b"base dec  timestamps absolute\n", b"base hex  timestamps relative\n", b"// canwire channel 1 two\n",
          b";$FILEVERSION=1.1\n", b";$COLUMNS=N,O,T,I,d,l,D\n", b"Rx", b" Rx d 8", b"ErrorFrame", b"RTR",
          b"\xc2\xa0;$COLUMNS=O,I,L,D\n", b"\n\xc2\xa0;")  # fmt: skip
quick = settings(
    max_examples=40, deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip


def written(path: Path, log: list[LogEntry]) -> bytes:
    with create_log(path) as writer:
        writer.write_many(log)
    return path.read_bytes()


def by_lines(form: str, source: Source) -> Iterator[LogBatch]:
    if form == "csv":
        return csv_reading._read_rows(source, [source.file.read()], row_of_ours, 0)
    parser: Any = (asc_reading if form == "asc" else trc_reading)._Parser(source)
    return read_lines(source, parser.entry)


def by_blocks(form: str, source: Source) -> Iterator[LogBatch]:
    return {"asc": asc, "trc": trc, "csv": csv}[form].read(source)


def told(read: Any, form: str, text: bytes) -> tuple[object, ...]:
    """All that a reader says of a file."""
    source = Source("log", io.BytesIO(text))
    records = b"".join(batch.records.tobytes() for batch in read(form, source))
    faults = [(fault.where, fault.what[:200]) for fault in source.faults]
    return records, source.channels, faults, source.start_ns, source.clock, form == "csv" or source.dated


@st.composite
def spoilt(draw: st.DrawFn, text: bytes) -> bytes:
    """The same with a few pieces put in, or put over, or taken away."""
    for _ in range(draw(st.integers(0, 4))):
        at = draw(st.integers(0, len(text)))
        piece = draw(st.sampled_from(SPOILT) | st.binary(max_size=3))
        over = draw(st.integers(0, 3))
        text = text[:at] + piece + text[at + over :]
    return text


@pytest.mark.conforms("PF-02", "PF-04", "PF-06")
@pytest.mark.parametrize("form", FORMATS)
@quick
@given(data=st.data(), chunk=st.sampled_from((100, 333, 1 << 20)))
def test_whatever_stands_there(tmp_path: Path, form: str, data: st.DataObject, chunk: int) -> None:
    log = data.draw(st.one_of(entries(), entries(frames(), step_ns=1000)))
    text = data.draw(spoilt(written(tmp_path / f"log.{form}", log)))
    # a header so damaged that it could be another program's is read by its columns' names
    assume(
        form != "csv"
        or text.startswith(HEADER.encode())
        or dialect_of(text.partition(b"\n")[0].decode("utf-8-sig", "replace")) is None
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reading, "_CHUNK", chunk)
        assert told(by_blocks, form, text) == told(by_lines, form, text)


@pytest.mark.parametrize("form", FORMATS)
def test_lines_that_change_others_among_many(tmp_path: Path, form: str) -> None:
    """More such lines than parts that a block may have, and fewer."""
    log = [LogEntry(START_NS + n * 10**6, "can0", Frame(n, bytes(n % 9), timestamp_ns=START_NS + n * 10**6), "R")
           for n in range(500)]  # fmt: skip
    lines = written(tmp_path / f"log.{form}", log).splitlines(keepends=True)
    for step in (5, 100):
        text = b"".join(line + SPOILT[16 + at % 4] * (at % step == step - 1) for at, line in enumerate(lines))
        assert told(by_blocks, form, text) == told(by_lines, form, text)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("size", [LONGEST - 1, LONGEST, LONGEST + 1, 3 * LONGEST + 7])
def test_lines_that_are_too_long(
    tmp_path: Path, form: str, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They count as several, as they do by `readline`; of a CSV file they are one row, as the csv module has it."""
    head = written(
        tmp_path / f"log.{form}", [LogEntry(START_NS, "can0", Frame(1, timestamp_ns=START_NS), "R")]
    )
    text = head + b"1" * size + b"\n" + head.splitlines(keepends=True)[-1] + b"2" * size
    monkeypatch.setattr(reading, "_CHUNK", 1 << 17)
    assert told(by_blocks, form, text) == told(by_lines, form, text)


@pytest.mark.parametrize("form", FORMATS)
def test_usual_lines_are_plain(tmp_path: Path, form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else all of the above would hold and nothing be quicker: no more than a handful are read by themselves."""
    numbers = random.Random(5)
    log = []
    for n in range(2000):
        time_ns, extended = START_NS + n * 10**6, n % 3 == 0
        frame = Frame(
            numbers.randrange(1 << 29 if extended else 1 << 11),
            numbers.randbytes(n % 9),
            extended=extended,
            timestamp_ns=time_ns,
        )
        log.append(LogEntry(time_ns, f"can{n % 2}", frame, "RT"[n % 2]))
    text = written(tmp_path / f"log.{form}", log)
    alone = 0
    real = reading.parsed_line

    def counted(*words: Any) -> LogEntry | None:
        nonlocal alone
        alone += 1
        return real(*words)

    monkeypatch.setattr(reading, "parsed_line", counted)
    source = Source("log", io.BytesIO(text))
    found = [entry for batch in by_blocks(form, source) for entry in batch]
    assert [entry.content for entry in found] == [entry.content for entry in log]
    assert alone <= 20


@pytest.mark.parametrize(
    ("form", "begin"), [("asc", b"start 1700000000123000000"), ("trc", b"STARTTIME=45244.9")]
)
@pytest.mark.parametrize("much", [b"9" * 4, b"9" * 30, b"-9" + b"9" * 17])
def test_a_beginning_past_all_clocks(tmp_path: Path, form: str, begin: bytes, much: bytes) -> None:
    log = [LogEntry(START_NS, "can0", Frame(1, timestamp_ns=START_NS), "R")] * 3
    text = written(tmp_path / f"log.{form}", log)
    assert begin in text
    text = text.replace(begin, begin.split(b"1")[0].split(b"4")[0] + much)
    assert told(by_blocks, form, text) == told(by_lines, form, text)


def test_rows_over_several_lines(tmp_path: Path) -> None:
    """A channel's name with an end of line in it, far behind rows that are lines."""
    log = [
        LogEntry(START_NS + n, "two\nlines" if n == 300 else "can0", Frame(n, timestamp_ns=START_NS + n), "R")
        for n in range(600)
    ]
    path = tmp_path / "log.csv"
    text = written(path, log)
    assert told(by_blocks, "csv", text) == told(by_lines, "csv", text)
    with closing(io.BytesIO(text)) as file:
        source = Source("log", file)
        found = [entry for batch in csv.read(source) for entry in batch]
    assert found == log
