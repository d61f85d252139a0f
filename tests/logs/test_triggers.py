"""Recordings of parts: what starts and stops them, what came before, and what is said of the gaps."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import canwire
from canwire import (
    BadValue,
    BusEvent,
    ErrorState,
    Frame,
    Lab,
    LogBatch,
    LogEntry,
    LogMark,
    RecordTriggers,
    open_log,
)
from canwire.logs.batch import batch_of
from canwire.logs.recording.triggers import Condition, Gate
from tests.effort import examples

S = 1_000_000_000
CHANNELS = ["can0"]
GO, END = 0x100, 0x200


def of(id: int) -> Condition:
    return lambda entry: entry.frame is not None and entry.frame.id == id


def shown(entry: LogEntry) -> str:
    """`3:100`, or how long a gap was."""
    if isinstance(entry.content, LogMark):
        return f"gap {entry.content.count // S}"
    assert entry.frame is not None
    return f"{entry.timestamp_ns // S}:{entry.frame.id:X}"


def through(gate: Gate, *heard: tuple[int, int]) -> list[str]:
    """What passes of frames at these seconds with these identifiers."""
    entries = [LogEntry(at * S, "can0", Frame(id, timestamp_ns=at * S)) for at, id in heard]
    pieces = gate.passed(batch_of(entries, list(CHANNELS)).records)
    return [shown(entry) for piece in pieces for entry in LogBatch(piece, CHANNELS)]


def test_from_a_start_to_a_stop_again_and_again() -> None:
    gate = Gate(RecordTriggers(of(GO), of(END)), CHANNELS)
    assert through(gate, (0, 1), (1, GO), (2, 2), (3, END), (4, 3)) == ["1:100", "2:2", "3:200"]
    assert through(gate, (5, 4), (9, GO), (10, 5)) == ["gap 6", "9:100", "10:5"]
    assert through(gate, (11, 6)) == ["11:6"]
    assert (gate.starts, gate.over) == (2, False)


def test_what_came_before_a_start_and_comes_after_a_stop() -> None:
    gate = Gate(RecordTriggers(of(GO), of(END), before_s=2, after_s=3), CHANNELS)
    assert through(gate, (0, 1), (5, 2)) == []
    assert through(gate, (6, 3)) == []
    assert through(gate, (7, GO), (8, END), (11, 4), (12, 5)) == ["5:2", "6:3", "7:100", "8:200", "11:4"]
    assert through(gate, (13, GO)) == ["gap 1", "12:5", "13:100"]


def test_a_start_before_the_end_goes_on() -> None:
    gate = Gate(RecordTriggers(of(GO), of(END), after_s=5), CHANNELS)
    assert through(gate, (0, GO), (1, END), (3, GO), (9, 1)) == ["0:100", "1:200", "3:100", "9:1"]
    assert gate.starts == 1


def test_a_start_right_at_the_end_leaves_no_gap() -> None:
    gate = Gate(RecordTriggers(of(GO), of(END)), CHANNELS)
    assert through(gate, (0, GO), (1, END), (3, GO)) == ["0:100", "1:200", "3:100"]
    assert gate.starts == 2


def test_once() -> None:
    gate = Gate(RecordTriggers(of(GO), of(END), once=True), CHANNELS)
    assert through(gate, (0, GO), (1, END), (2, GO), (3, 1)) == ["0:100", "1:200"]
    assert gate.over
    assert through(gate, (4, GO)) == []


def test_only_a_stop_and_only_a_start() -> None:
    gate = Gate(RecordTriggers(stop=of(END)), CHANNELS)
    assert through(gate, (0, 1), (1, END)) == ["0:1", "1:200"]
    assert (gate.over, gate.ending_s) == (False, 0.0)
    assert through(gate, (2, 1)) == []
    assert (gate.over, gate.ending_s) == (True, None)
    gate = Gate(RecordTriggers(start=of(GO)), CHANNELS)
    assert through(gate, (0, 1), (1, GO), (2, END), (3, GO)) == ["1:100", "2:200", "3:100"]


@examples(100)
@given(st.lists(st.tuples(st.integers(0, 3), st.sampled_from([1, 2, GO, END])), max_size=40), st.data())
def test_batches_make_no_difference(steps: list[tuple[int, int]], data: st.DataObject) -> None:
    at, heard = 0, []
    for step, id in steps:
        at += step
        heard.append((at, id))
    triggers = RecordTriggers(
        of(GO), of(END), before_s=data.draw(st.integers(0, 4)), after_s=data.draw(st.integers(0, 4))
    )
    whole = Gate(triggers, CHANNELS)
    expected = through(whole, *heard)
    parts, found, begin = Gate(triggers, CHANNELS), [], 0
    while begin < len(heard):
        size = data.draw(st.integers(1, 5))
        found += through(parts, *heard[begin : begin + size])
        begin += size
    assert found == expected
    assert parts.starts == whole.starts


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"before_s": 1.0}, "before_s 1.0: needs a condition to start"),
        ({"start": of(GO), "after_s": 1.0}, "after_s 1.0: needs a condition to stop"),
        ({"start": of(GO), "once": True}, "once True: needs a condition to stop"),
        ({"start": of(GO), "before_s": -1.0}, "before_s"),
    ],
)
def test_what_makes_no_sense(wrong: dict[str, object], why: str) -> None:
    with pytest.raises(BadValue, match=why):
        RecordTriggers(**wrong)  # type: ignore[arg-type]


@pytest.mark.conforms("PG-08")
def test_before_a_bus_off_in_the_lab(tmp_path: Path) -> None:
    def bus_off(entry: LogEntry) -> bool:
        return isinstance(entry.content, BusEvent) and entry.content.state is ErrorState.BUS_OFF

    path = tmp_path / "fault.log"
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        engine, _ = bus.node("engine", self_reception=True), bus.node("tester")
        with canwire.record(engine, path, triggers=RecordTriggers(bus_off, before_s=1.0)) as recorder:
            for number in range(5):
                engine.send(Frame(number))
                lab.run_for(0.4)
            assert recorder.starts == 0
            bus.faults.flip(frame_id=0x7FF, bit=30, times=None, seen_by="sender")
            engine.send(Frame(0x7FF))
            lab.run_for(0.1)
        assert recorder.starts == 1
    with open_log(path) as log:
        frames = [entry.frame.id for entry in log if entry.frame]
    assert frames == [3, 4]  # of the last second: those at 1.2 and 1.6 s
