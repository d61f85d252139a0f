"""`open_trace`: the tables, signals that are cantools' own and decoded for those who ask, and what goes wrong."""

from __future__ import annotations

import random
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pyarrow.parquet
import pytest

import canwire
from canwire import (
    BadLog,
    BadValue,
    BusEvent,
    Closed,
    ErrorKind,
    EventKind,
    ExtraMissing,
    Frame,
    LinEvent,
    LinEventKind,
    LinFrame,
    LogEntry,
    LogMark,
    MarkKind,
    convert_log,
    create_log,
    open_trace,
)
from canwire.logs.queries import decoding
from canwire.logs.trace import packing, writing
from tests.logs.contents import stamped

duckdb = pytest.importorskip("duckdb")

ROOT = Path(__file__).parents[3]
ENGINE = ROOT / "examples" / "engine.dbc"
VEHICLE = ROOT / "tests" / "databases" / "data" / "vehicle.dbc"
CAR = ROOT / "examples" / "car-candump.log"
START_NS = 1_700_000_000_123_456_789


def entry(number: int, content: object, channel: str = "can0") -> LogEntry:
    """One every millisecond."""
    time_ns = START_NS + 1_000_000 * number
    return LogEntry(time_ns, channel, stamped(content, time_ns), "R")  # type: ignore[arg-type]


def trace_of(folder: Path, contents: list[object]) -> Path:
    with create_log(folder / "log.trace") as writer:
        writer.write_many(entry(number, content) for number, content in enumerate(contents))
    return folder / "log.trace"


@pytest.fixture
def everything(tmp_path: Path) -> Path:
    """One of each kind."""
    error = BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, bit=12, transmitting=True, tec=8)
    return trace_of(
        tmp_path,
        [
            LogMark(MarkKind.CLOCK, text="hub"),
            LogMark(MarkKind.BIT_RATE, bit_rate=500_000, data_bit_rate=2_000_000),
            Frame(0x123, b"\x11\x22"),
            Frame(0x123, extended=True, remote=True, dlc=4),
            Frame(0x40, bytes(12), fd=True, bit_rate_switch=True),
            error,
            BusEvent(EventKind.STATE, tec=128),
            LinFrame(0x10, b"\x01\x02"),
            LinEvent(LinEventKind.SLEEP),
            LogMark(MarkKind.LOST, count=7),
            Frame(0x123, b"\x33"),
        ],
    )


@pytest.mark.conforms("PF-08", "PF-10")
def test_each_kind_has_its_table(everything: Path) -> None:
    with open_trace(everything) as trace:

        def rows(query: str) -> list[tuple[object, ...]]:
            found: list[tuple[object, ...]] = trace.sql(query).fetchall()
            return found

        assert trace.tables == ["entries", "frames", "events", "errors", "lin", "marks"]
        assert rows("select count(*) from entries") == [(11,)]
        wanted = "time_ns, id, extended, remote, fd, brs, dlc, data, direction"
        assert rows(f"select {wanted} from frames order by time_ns") == [
            (START_NS + 2_000_000, 0x123, False, False, False, False, 2, b"\x11\x22", "R"),
            (START_NS + 3_000_000, 0x123, True, True, False, False, 4, b"", "R"),
            (START_NS + 4_000_000, 0x40, False, False, True, True, 9, bytes(12), "R"),
            (START_NS + 10_000_000, 0x123, False, False, False, False, 1, b"\x33", "R"),
        ]
        assert rows("select bus, error, bit, transmitting, tec, rec from errors") == [
            ("CAN", "STUFF", 12, True, 8, 0)
        ]
        assert rows("select bus, kind from events order by time_ns") == [
            ("CAN", "ERROR"), ("CAN", "STATE"), ("LIN", "SLEEP")]  # fmt: skip
        assert rows("select id, length, data, header_only from lin") == [(0x10, 2, b"\x01\x02", False)]
        assert rows("select kind, count, bit_rate, data_bit_rate, text from marks order by time_ns") == [
            ("CLOCK", 0, 0, 0, "hub"), ("BIT_RATE", 0, 500_000, 2_000_000, ""), ("LOST", 7, 0, 0, "")]  # fmt: skip
        assert rows("select count(*) from frames where id = '0x123' and not extended") == [(2,)]


def test_time_is_a_time_where_the_log_has_one(tmp_path: Path, everything: Path) -> None:
    with open_trace(everything) as trace:
        assert trace.dated
        (found,) = trace.sql("select min(time)::varchar, typeof(min(time)) from frames").fetchall()
        assert found == ("2023-11-14 22:13:20.125456789", "TIMESTAMP_NS")
        since = "select count(*) from frames where time >= '2023-11-14 22:13:20.127'"
        assert trace.sql(since).fetchall() == [(2,)]
    with create_log(tmp_path / "zero.trace", dated=False) as writer:
        writer.write(LogEntry(1_500_000_000, "can0", Frame(1, timestamp_ns=1_500_000_000)))
    with open_trace(tmp_path / "zero.trace") as trace:
        assert not trace.dated
        assert trace.sql("select time from frames").fetchall() == [(1.5,)]


def some_frames(database: canwire.Database, count: int) -> list[Frame]:
    """Random data of all lengths, J1939 messages from several senders, and strangers."""
    numbers, found = random.Random(3), []
    messages = [one for one in database.messages.values() if one.length <= 8]
    for _ in range(count):
        message = numbers.choice(messages)
        id = message.id & ~0xFF | numbers.randrange(256) if message.j1939 else message.id
        length = numbers.choice((message.length, 8, 8, numbers.randrange(9)))
        found.append(Frame(id, numbers.randbytes(length), extended=message.extended))
    found += [Frame(0x7FE, bytes(8)), Frame(messages[0].id, extended=messages[0].extended, remote=True)]
    return found


@pytest.mark.conforms("PF-08", "PF-12")
@pytest.mark.parametrize("file", [ENGINE, VEHICLE], ids=lambda path: path.stem)
def test_signals_are_what_decoding_one_by_one_gives(tmp_path: Path, file: Path) -> None:
    database = canwire.load_database(file)
    frames = some_frames(database, 800)
    wanted = set()
    for number, frame in enumerate(frames):
        decoded = database.decode(frame)
        for name, value in (decoded.numbers if decoded else {}).items():
            assert decoded is not None
            text = decoded.signals[name] if isinstance(decoded.signals[name], str) else None
            unit = decoded.description.signals[name].unit
            wanted.add((START_NS + number * 1_000_000, decoded.name, name, float(value), text, unit))  # type: ignore[arg-type]
    with open_trace(trace_of(tmp_path, list(frames)), database=database) as trace:
        query = "select time_ns, message, signal, value, text, unit from signals"
        assert set(trace.sql(query).fetchall()) == wanted
        names = [
            (message.name, signal) for message in database.messages.values() for signal in message.signals
        ]
        for message, signal in names[:: max(1, len(names) // 20)]:
            query = f'select time_ns, "{signal}" from "{message}" where "{signal}" is not null'
            told = {(row[0], row[3]) for row in wanted if row[1:3] == (message, signal)}
            assert set(trace.sql(query).fetchall()) == told


@contextmanager
def counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """How many frames each call decodes."""
    found: list[int] = []
    decode = decoding.decode_signal

    def counting(records: object, *arguments: object) -> object:
        found.append(len(records))  # type: ignore[arg-type]
        return decode(records, *arguments)  # type: ignore[arg-type]

    with monkeypatch.context() as patch:
        patch.setattr(decoding, "decode_signal", counting)
        yield found


@pytest.fixture
def traffic(tmp_path: Path) -> Path:
    """300 frames of EngineData among 2,700 others."""
    frames = [Frame(0x100 if number % 10 == 0 else 0x300 + number % 7, bytes(8)) for number in range(3000)]
    return trace_of(tmp_path, list(frames))


@pytest.mark.parametrize(
    ("query", "decoded"),
    [
        ("select avg(value) from signals where signal = 'EngineSpeed'", 300),
        ("select avg(value) from signals where signal = 'EngineSpeed' and value < 100", 300),
        ("select value, text from signals where signal = 'EngineSpeed' and time_ns < {}", 20),
        ("select avg(EngineSpeed) from EngineData", 300),
        ("select avg(value) from signals where message = 'EngineData'", 1500),
        ("select avg(value) from signals where signal = 'EngSpeed'", 0),
        ("select count(*) from frames", 0),
    ],
)
def test_only_what_is_asked_for_is_decoded(
    monkeypatch: pytest.MonkeyPatch, traffic: Path, query: str, decoded: int
) -> None:
    with counted(monkeypatch) as calls, open_trace(traffic, database=ENGINE) as trace:
        trace.sql(query.format(START_NS + 100 * 1_000_000)).fetchall()
    assert sum(calls) == decoded


def test_one_identifier_needs_its_row_groups_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The data of all others are overwritten: who reads them notices."""
    monkeypatch.setattr(packing, "ROW_GROUP", 100)
    frames = [Frame(0x100 + 0x50 * (number % 10), bytes((number % 256,) * 8)) for number in range(2000)]
    folder = trace_of(tmp_path, list(frames))
    file = folder / "00001.parquet"
    data = bytearray(file.read_bytes())
    metadata = pyarrow.parquet.ParquetFile(file).metadata
    place = metadata.schema.names.index("data")
    for group in range(2, metadata.num_row_groups):
        column = metadata.row_group(group).column(place)
        begin = column.data_page_offset
        data[begin : begin + column.total_compressed_size] = bytes(column.total_compressed_size)
    file.write_bytes(data)
    with open_trace(folder, database=ENGINE) as trace:
        query = "select count(*), max(value) from signals where signal = 'EngineSpeed'"
        assert trace.sql(query).fetchall() == [(200, 0xFEFE / 4)]
        with pytest.raises(duckdb.Error):
            trace.sql("select max(data) from frames").fetchall()


@pytest.mark.conforms("PF-11")
def test_a_trace_that_grows_is_asked_meanwhile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writing, "ENTRIES", 100)
    writer = create_log(tmp_path / "log.trace")
    writer.write_many(entry(number, Frame(0x100)) for number in range(250))
    writer.flush()
    with open_trace(tmp_path / "log.trace") as trace:
        assert trace.sql("select count(*) from frames").fetchall() == [(250,)]
        home = Path(trace.connection.execute("select current_setting('temp_directory')").fetchone()[0]).parent
        assert home.exists()
    assert not home.exists()
    writer.close()


@pytest.mark.conforms("PF-09")
@pytest.mark.parametrize("name", ["drive.parquet", "drive.blf", "drive.trace/00001.parquet", "drive.log"])
def test_any_log_can_be_asked(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    convert_log(CAR, path.parent if path.parent != tmp_path else path)
    with open_trace(path) as trace:
        assert trace.sql("select count(*), count(distinct id) from frames").fetchall() == [(12974, 180)]


@pytest.mark.parametrize("damage", ["cut", "foreign"])
def test_a_damaged_file_is_told_and_the_others_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    monkeypatch.setattr(writing, "ENTRIES", 5000)
    convert_log(CAR, tmp_path / "log.trace")
    victim = tmp_path / "log.trace" / "00002.parquet"
    if damage == "cut":
        victim.write_bytes(victim.read_bytes()[:-100])
    else:
        pyarrow.parquet.write_table(pyarrow.table({"a": [1]}), victim)
    with open_trace(tmp_path / "log.trace") as trace:
        assert trace.sql("select count(*) from frames").fetchall() == [(7974,)]
        (fault,) = trace.faults
    assert fault.where == "00002.parquet"


def test_what_is_no_trace_is_one_clear_error(tmp_path: Path) -> None:
    with pytest.raises(BadLog, match="a folder without Parquet files, so no trace"):
        open_trace(tmp_path)
    (tmp_path / "a.parquet").write_bytes(b"PAR1")
    with pytest.raises(BadLog, match=r"nothing of it can be read; a\.parquet: no whole Parquet file"):
        open_trace(tmp_path)
    with pytest.raises(FileNotFoundError):
        open_trace(tmp_path / "nothing")
    with pytest.raises(BadValue, match="memory_bytes"):
        open_trace(tmp_path, memory_bytes=1)


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("selec 1", "SQL, line 1, column 1: syntax error at or near selec"),
        ("select *\nfrom frams", "SQL, line 2, column 6: no table frams; did you mean frames?"),
        ("select * from EngineDta", "column 15: no table EngineDta; did you mean EngineData?"),
        ("select idd from frames", "column 8: Referenced column idd not found .* Candidate bindings: .*id"),
        ("select 1 from frames where id = 0x1A0", "SQL has no 0x1A0: write 416 or '0x1A0'"),
        ("select * from frames where " + "id = 1 and " * 40 + "bar", "column 468: Referenced column bar"),
        ("select 1 from signals where signal = 'EngineSped'", "no signal 'EngineSped'; did you mean EngineSpeed?"),
        ("select 1 from signals where Message='Engine'", "no message 'Engine'; did you mean EngineData"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_with_its_place(everything: Path, query: str, said: str) -> None:
    with open_trace(everything, database=ENGINE) as trace:
        with pytest.raises(BadValue, match=said) as raised:
            trace.sql(query)
        assert "\n" not in str(raised.value)
        assert trace.sql("select count(*) from frames").fetchall() == [(4,)]


def test_signals_need_a_database(everything: Path) -> None:
    with (
        open_trace(everything) as trace,
        pytest.raises(BadValue, match="no table signals without a database"),
    ):
        trace.sql("select * from signals")
    with pytest.raises(BadValue, match="signals of LIN frames are no table of a query yet"):
        open_trace(everything, database=ROOT / "examples" / "door.ldf")


def test_closed(everything: Path) -> None:
    trace = open_trace(everything)
    trace.close()
    trace.close()
    assert repr(trace) == f"<Trace {str(everything)!r}, closed>"
    with pytest.raises(Closed):
        trace.sql("select 1")


def test_without_duckdb_one_line_names_the_extra(everything: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "duckdb", None)
    with pytest.raises(ExtraMissing, match=r"duckdb is not installed; run: pip install 'canwire\[query\]'"):
        open_trace(everything)


@pytest.mark.parametrize("column", ["data", "time_ns"])
def test_damage_inside_a_file_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, column: str) -> None:
    """Not before somebody reads it; `open_log` tells the place and gives the rest."""
    monkeypatch.setattr(writing, "ENTRIES", 5000)
    convert_log(CAR, tmp_path / "log.trace")
    file = tmp_path / "log.trace" / "00002.parquet"
    metadata = pyarrow.parquet.ParquetFile(file).metadata
    page = metadata.row_group(0).column(metadata.schema.names.index(column)).data_page_offset
    data = bytearray(file.read_bytes())
    data[page : page + 400] = bytes(400)
    file.write_bytes(data)
    with open_trace(tmp_path / "log.trace") as trace:
        assert trace.sql("select count(*) from frames").fetchall() == [(12974,)]
        with pytest.raises(duckdb.Error) as raised:
            trace.sql(f"select max({column}) from frames where id <> 1").fetchall()
        assert "a file of the log is damaged" in str(trace.mistake(raised.value, ""))
    with canwire.open_log(tmp_path / "log.trace") as log:
        assert sum(map(len, log.batches())) == 7974
        assert [fault.where for fault in log.faults] == ["00002.parquet, row 0"]


def test_a_bit_that_flipped_is_noticed(tmp_path: Path) -> None:
    """Not all of them make nonsense: pages have checksums."""
    convert_log(CAR, tmp_path / "log.trace")
    file = tmp_path / "log.trace" / "00001.parquet"
    metadata = pyarrow.parquet.ParquetFile(file).metadata
    whole = file.read_bytes()
    numbers = random.Random(1)
    for name in ("data", "time_ns", "id"):
        column = metadata.row_group(0).column(metadata.schema.names.index(name))
        data = bytearray(whole)
        data[column.data_page_offset + numbers.randrange(60, column.total_compressed_size - 60)] ^= 0x10
        file.write_bytes(data)
        with canwire.open_log(file) as log, pytest.raises(BadLog, match="nothing of it can be read"):
            list(log.batches())


def test_too_little_memory_is_said(everything: Path) -> None:
    with open_trace(everything, memory_bytes=64 << 20) as trace:
        with pytest.raises(duckdb.Error) as raised:
            trace.sql("select list(range) from range(100000000)").fetchall()
        told = str(trace.mistake(raised.value, ""))
    assert told.startswith("Out of Memory Error: ")
    assert "--memory" in told
    assert "\n" not in told


ALIKE = """VERSION ""
BU_: ECU
BO_ 256 State: 8 ECU
 SG_ Time : 0|8@1+ (1,0) [0|255] "" ECU
 SG_ Speed : 8|8@1+ (1,0) [0|255] "" ECU
 SG_ SPEED : 16|8@1+ (1,0) [0|255] "" ECU
BO_ 257 STATE: 8 ECU
 SG_ Level : 0|8@1+ (1,0) [0|255] "" ECU
BO_ 258 Frames: 8 ECU
 SG_ Count : 0|8@1+ (1,0) [0|255] "" ECU
"""


def test_names_that_sql_takes_for_the_same(tmp_path: Path) -> None:
    """`signals` has all of them; a message whose table would be one of ours is found there only."""
    (tmp_path / "alike.dbc").write_text(ALIKE)
    frames = [Frame(id, bytes((id & 0xFF, 20, 30))) for id in (256, 257, 258)]
    with open_trace(trace_of(tmp_path, list(frames)), database=tmp_path / "alike.dbc") as trace:
        rows = trace.sql("select message, signal, value from signals order by message, signal")
        assert rows.fetchall() == [
            ("Frames", "Count", 2), ("STATE", "Level", 1), ("State", "SPEED", 30), ("State", "Speed", 20),
            ("State", "Time", 0)]  # fmt: skip
        assert trace.sql("select count(*) from frames").fetchall() == [(3,)]
        assert trace.sql("select * exclude (time_ns, time, channel, row) from State").fetchall() == [
            (0, 20, 30)
        ]
