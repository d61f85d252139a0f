"""The rows of `canwire view`: what they count and mark, in words and as CSV."""

from __future__ import annotations

import csv
import io
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import BusEvent, EventKind, Frame
from canwire.commands.live.decoding import decoder
from canwire.commands.live.listening import RECORD, Record
from canwire.commands.view.columns import Wanted, format_csv, format_row, texts_of
from canwire.commands.view.table import Row, Table

CAR = str(Path(__file__).parents[1] / "car.dbc")
MS = 1_000_000


def record_of(frame: Frame, time_ms: float) -> Record:
    packed: Record = RECORD.unpack(canwire.frames_to_array([frame]).tobytes())
    return round(time_ms * MS), packed[1], packed[2], packed[3]


def table_of(*frames: tuple[float, Frame]) -> Table:
    table = Table()
    table.take("can0", [record_of(frame, time_ms) for time_ms, frame in frames])
    return table


@pytest.mark.conforms("PC-13")
def test_periods_and_counts() -> None:
    table = table_of(*[(at, Frame(0x123, b"\x01")) for at in (0, 10, 19, 31)], (5, Frame(0x100)))
    first, second = table.rows
    assert (first.key.id, second.key.id) == (0x100, 0x123)
    assert (first.gap_ns, first.least_ns, first.most_ns) == (None, None, None)
    assert (second.count, second.gap_ns, second.least_ns, second.most_ns) == (4, 12 * MS, 9 * MS, 12 * MS)
    assert table.frames == 5


def test_rows_are_in_order_and_kinds_apart() -> None:
    table = table_of((0, Frame(0x200)), (1, Frame(1, extended=True)), (2, Frame(1)))
    table.take("body", [record_of(Frame(0x700), 3)])
    assert [tuple(row.key) for row in table.rows] == [
        ("body", False, 0x700),
        ("can0", False, 1),
        ("can0", False, 0x200),
        ("can0", True, 1),
    ]


@pytest.mark.conforms("PC-07", "PC-13")
def test_changed_bytes_are_marked_for_a_second() -> None:
    table = table_of((0, Frame(1, b"\x00\x00\x00")))
    (row,) = table.rows
    assert row.changed == frozenset()
    table.take("can0", [record_of(Frame(1, b"\x00\x05\x00"), 100)])
    assert row.changed == {1}
    table.take("can0", [record_of(Frame(1, b"\x07\x05\x00"), 900)])
    assert row.changed == {0, 1}
    table.take("can0", [record_of(Frame(1, b"\x07\x05\x00"), 1100)])
    assert row.changed == {0}
    held = row.copy()
    table.take("can0", [record_of(Frame(1, b"\x07\x05\x01"), 1200)])
    assert (row.changed, held.changed, held.count) == ({0, 2}, {0}, 4)


def test_errors_are_no_rows() -> None:
    table = Table()
    for kind in (EventKind.ERROR, EventKind.STATE):
        table.take("can0", [RECORD.unpack(BusEvent(kind).to_record())])
    assert (len(table), table.errors, table.frames) == (0, 1, 0)
    table.clear()
    assert table.errors == 0


@given(st.lists(st.tuples(st.integers(0, 3), st.binary(max_size=3), st.integers(0, 50)), max_size=60))
def test_every_frame_is_in_one_row(heard: list[tuple[int, bytes, int]]) -> None:
    time_ms, frames = 0, []
    for id, data, gap_ms in heard:
        time_ms += gap_ms
        frames.append((float(time_ms), Frame(id, data)))
    table = table_of(*frames)
    assert sum(row.count for row in table.rows) == table.frames == len(heard)
    for row in table.rows:
        times = [time_ms for time_ms, frame in frames if frame.id == row.key.id]
        gaps = [round((after - before) * MS) for before, after in pairwise(times)]
        assert (row.least_ns, row.most_ns) == ((min(gaps), max(gaps)) if gaps else (None, None))
        assert row.frame == [frame for _, frame in frames if frame.id == row.key.id][-1]


def only(*frames: tuple[float, Frame]) -> Row:
    (row,) = table_of(*frames).rows
    return row


def test_words() -> None:
    row = only((0, Frame(0x123, b"\x11\x22")), (10.25, Frame(0x123, b"\x11\x23")))
    assert (
        format_row(texts_of(row, None))
        == "can0          123  2        2      10.2 (   10.2 ..     10.2)  11 23"
    )
    assert texts_of(only((0, Frame(1, remote=True, dlc=4))), None)[1:4] == ("001", "4", "remote request")
    assert texts_of(only((0, Frame(1, bytes(12), fd=True, extended=True))), None)[1:3] == ("00000001", "12")


@pytest.mark.conforms("PC-13")
def test_signals_and_filters_by_name() -> None:
    pytest.importorskip("cantools")
    decode = decoder(CAR)
    engine, other = only((0, Frame(0x100, bytes.fromhex("401F0A00")))), only((0, Frame(0x3A0)))
    assert texts_of(engine, decode).decoded == "Engine(Speed: 2000 rpm, Torque: 10 Nm)"
    assert "  :: Engine(" in format_row(texts_of(engine, decode))
    assert texts_of(other, decode).decoded == ""
    for text, shown in [("", (True, True)), ("eng", (True, False)), ("100", (True, False)), ("~100", (False, True)),
                        ("100-3FF", (True, True)), ("3a0:7ff", (False, True)), ("x", (False, False)),
                        ("100, 3A0", (True, True))]:  # fmt: skip
        wanted = Wanted(text, decode)
        assert (wanted.accepts(engine), wanted.accepts(other)) == shown, text
    assert not Wanted("eng", None).accepts(engine)


def test_csv() -> None:
    row = only((0, Frame(0x123, b"\x11\x22")), (10, Frame(0x123, b"\x11\x23")))
    (read,) = csv.DictReader(io.StringIO(format_csv([texts_of(row, None)])))
    assert read == {
        "line": "can0", "id": "123", "len": "2", "data": "11 23", "count": "2", "period ms": "10.0", "min": "10.0",
        "max": "10.0", "decoded": "",
    }  # fmt: skip
