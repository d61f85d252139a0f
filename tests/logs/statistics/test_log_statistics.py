"""`log_statistics` against the same numbers made entry by entry, with the standard library."""

from __future__ import annotations

import statistics
from collections import Counter, defaultdict
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from canwire import (
    BadValue,
    BitLayout,
    BusEvent,
    ErrorKind,
    EventKind,
    Frame,
    LinErrorKind,
    LinEvent,
    LinEventKind,
    LinFrame,
    LogEntry,
    LogMark,
    LogStatistics,
    MarkKind,
    create_log,
    log_statistics,
    open_log,
)
from canwire.logs.batch import batch_of
from canwire.logs.statistics import busy, periods
from canwire.logs.statistics.collecting import Collector
from tests.logs.contents import START_NS, entries

quick = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def counted(log: list[LogEntry], pieces: int = 1, bit_rate: int | None = None) -> LogStatistics:
    """By batches of so many entries."""
    collector = Collector({"": bit_rate} if bit_rate else {}, {})
    names: list[str] = []
    for at in range(0, len(log), pieces):
        collector.add(batch_of(log[at : at + pieces], names))
    return collector.result()


def frames_of(log: list[LogEntry]) -> dict[tuple[str, bool, bool, int], list[LogEntry]]:
    found = defaultdict(list)
    for entry in log:
        content = entry.content
        if isinstance(content, Frame | LinFrame):
            lin = isinstance(content, LinFrame)
            found[entry.channel, lin, not lin and content.extended, content.id].append(entry)
    return found


def at(time_ns: int, content: object, channel: str = "can0", direction: str | None = "R") -> LogEntry:
    return LogEntry(time_ns, channel, content, direction)  # type: ignore[arg-type]


def every(period_ns: int, count: int, id: int = 0x100, start_ns: int = START_NS) -> list[LogEntry]:
    return [
        at(start_ns + n * period_ns, Frame(id, bytes(8), timestamp_ns=start_ns + n * period_ns))
        for n in range(count)
    ]


@quick
@given(log=entries(), pieces=st.integers(1, 40))
def test_of_any_log(log: list[LogEntry], pieces: int) -> None:
    found = counted(log, pieces)
    wanted = frames_of(log)
    assert [(one.channel, one.lin, one.extended, one.id) for one in found.identifiers] == sorted(wanted)
    for one in found.identifiers:
        mine = wanted[one.channel, one.lin, one.extended, one.id]
        times = [entry.timestamp_ns for entry in mine]
        assert (one.count, one.first_ns, one.last_ns) == (len(mine), times[0], times[-1])
        directions = Counter(entry.direction for entry in mine)
        assert (one.received, one.transmitted) == (directions["R"], directions["T"])
        contents = [entry.content for entry in mine]
        if not one.lin:
            assert set(one.dlcs) == {frame.dlc for frame in contents}  # type: ignore[union-attr]
            assert one.remote == sum(frame.remote for frame in contents)  # type: ignore[union-attr]
        steps = [(b - a) / 1e9 for a, b in pairwise(times)]
        if not steps:
            assert (one.mean_s, one.jitter_s, one.usual_s) == (None, None, None)
            continue
        assert one.mean_s == pytest.approx(statistics.fmean(steps))
        assert one.jitter_s == pytest.approx(statistics.pstdev(steps), abs=1e-9)
        assert (one.least_s, one.most_s) == (pytest.approx(min(steps)), pytest.approx(max(steps)))
        assert one.usual_s == pytest.approx(statistics.median(steps))
        assert one.most_at_ns == times[1 + steps.index(max(steps))]
    errors = Counter(
        (entry.channel, entry.content.error.name)
        for entry in log
        if isinstance(entry.content, BusEvent | LinEvent)
        and entry.content.kind in (EventKind.ERROR, LinEventKind.ERROR)
    )
    told = {(one.name, kind): n for one in found.channels for kind, n in one.errors.items()}
    assert told == errors
    assert found.entries == len(log)
    assert found.marks == sum(isinstance(entry.content, LogMark) for entry in log)


@quick
@given(pieces=st.integers(1, 200), extra=st.integers(1, 5))
def test_gaps_are_more_than_three_usual_periods(pieces: int, extra: int) -> None:
    """Wherever the batches end, and whether the usual period is known already."""
    first = every(10_000_000, 20)
    second = every(10_000_000, 60, start_ns=first[-1].timestamp_ns + 31_000_000)
    third = every(10_000_000, extra, start_ns=second[-1].timestamp_ns + 30_000_000)
    one = counted(first + second + third, pieces).identifiers[0]
    assert (one.gaps, one.usual_s) == (1, pytest.approx(0.01))
    assert one.most_at_ns == second[0].timestamp_ns


def test_stamps_that_go_back_are_in_no_period() -> None:
    log = [*every(10_000_000, 3), *every(10_000_000, 3, start_ns=START_NS + 5_000_000)]
    one = counted(log, 2).identifiers[0]
    assert (one.count, one.backwards, one.mean_s) == (6, 1, pytest.approx(0.01))


@pytest.mark.conforms("PC-08", "PF-10")
def test_load_by_the_log_s_own_bit_rate() -> None:
    frame = Frame(0x100, bytes(8))
    log = [at(START_NS, LogMark(MarkKind.BIT_RATE, START_NS, bit_rate=500_000)), *every(10_000_000, 101)]
    channel = counted(log, 7, bit_rate=1).channels[0]
    bits = len(BitLayout(frame).levels) + 3
    assert channel.bit_rate == 500_000
    assert channel.load == pytest.approx(100 * 101 * bits / 500_000 / 1.0)
    assert len(channel.loads) == 10
    assert channel.load_step_s == pytest.approx(0.1)


def test_a_rate_that_changes_holds_from_its_mark_on() -> None:
    middle_ns = START_NS + 999_999_999
    log = [
        at(START_NS, LogMark(MarkKind.BIT_RATE, START_NS, bit_rate=250_000)),
        *every(10_000_000, 100),
        at(middle_ns, LogMark(MarkKind.BIT_RATE, middle_ns, bit_rate=500_000)),
        *every(10_000_000, 100, start_ns=START_NS + 1_000_000_000),
    ]
    channel = counted(log, 1000).channels[0]
    assert channel.loads[0] == pytest.approx(2 * channel.loads[-2], rel=0.01)


def test_no_rate_no_load_and_a_lin_channel_has_not_can_s() -> None:
    log = [*every(1_000_000, 3), at(START_NS + 10**9, LinFrame(3, b"\1"), "lin0")]
    assert [(one.name, one.load is None) for one in counted(log).channels] == [("can0", True), ("lin0", True)]
    assert [(one.name, one.load is None) for one in counted(log, bit_rate=500_000).channels] == [
        ("can0", False),
        ("lin0", True),
    ]
    lin = log_of(log, bit_rate={"lin0": 19_200})
    assert lin.load == pytest.approx(100 * (34 + 20) / 19_200 / 1.0)


def log_of(log: list[LogEntry], bit_rate: dict[str, int]) -> object:
    collector = Collector(bit_rate, {})
    collector.add(batch_of(log, []))
    return collector.result().channels[1]


def test_brs_without_its_rate_is_no_load() -> None:
    log = [at(START_NS, Frame(1, bytes(8), fd=True, bit_rate_switch=True)), *every(10**6, 3)]
    assert counted(log, bit_rate=500_000).channels[0].load is None


def test_steps_double_when_the_log_outgrows_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(busy, "_STEPS", 8)
    channel = counted(every(10_000_000, 1001), 50, bit_rate=500_000).channels[0]
    assert channel.load_step_s == pytest.approx(1.6)
    assert len(channel.loads) == 7
    assert channel.loads == pytest.approx([channel.load] * 7, rel=0.03)


def test_identifiers_beyond_the_most_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(periods, "MOST", 300)
    log = [at(START_NS + n, Frame(n % 500, timestamp_ns=START_NS + n)) for n in range(1000)]
    found = counted(log, 64)
    assert (len(found.identifiers), found.unlisted) == (300, 400)
    assert sum(one.count for one in found.identifiers) == 600


@pytest.mark.conforms("PF-10")
def test_losses_gaps_errors_and_directions_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "drive.blf"
    with create_log(path) as writer:
        writer.write_many(
            [
                at(START_NS, LogMark(MarkKind.LOST, START_NS, count=7), direction=None),
                at(START_NS, LogMark(MarkKind.GAP, START_NS, count=2_000_000_000), direction=None),
                at(START_NS, BusEvent(EventKind.ERROR, START_NS, error=ErrorKind.STUFF, transmitting=True)),
                at(START_NS, BusEvent(EventKind.STATE, START_NS)),
                at(START_NS, LinEvent(LinEventKind.ERROR, START_NS, error=LinErrorKind.SLNORE), "lin0"),
                *every(10_000_000, 3),
                at(START_NS + 10**9, Frame(0x200, timestamp_ns=START_NS + 10**9), direction="T"),
            ]
        )
    found = log_statistics(path)
    can, lin = found.channels
    assert (can.frames, can.received, can.transmitted, can.lost, can.gap_ns) == (4, 3, 1, 7, 2_000_000_000)
    assert (can.errors, can.errors_sending, can.events) == ({"STUFF": 1}, 1, {"STATE": 1})
    assert lin.errors == {"SLNORE": 1}
    assert (found.dated, found.span_s) == (True, 1.0)


@pytest.mark.conforms("PC-09")
def test_files_of_a_rotated_recording_are_one_log(tmp_path: Path) -> None:
    log = every(10_000_000, 100)
    for name, part in (("a.log", log[:40]), ("b.log", log[40:])):
        with create_log(tmp_path / name) as writer:
            writer.write_many(part)
    with open_log(tmp_path / "b.log") as second:
        found = log_statistics(tmp_path / "a.log", second)
    one = found.identifiers[0]
    assert (one.count, one.gaps, one.most_s) == (100, 0, pytest.approx(0.01))


def test_mistakes() -> None:
    with pytest.raises(BadValue, match="a log, or several"):
        log_statistics()
    with pytest.raises(BadValue, match="bit_rate 0"):
        log_statistics("examples/car-candump.log", bit_rate=0)


def test_records_of_a_damaged_journal(tmp_path: Path) -> None:
    """Kinds, channels and times that none has are no reason to fail."""
    import random

    path = tmp_path / "drive.journal"
    with create_log(path) as writer:
        writer.write_many(every(10**6, 200))
    whole, numbers = path.read_bytes(), random.Random(4)
    for _ in range(20):
        spoilt = bytearray(whole)
        for _ in range(40):
            spoilt[numbers.randrange(200, len(whole))] = numbers.randrange(256)
        path.write_bytes(spoilt)
        with open_log(path) as log:
            found = log_statistics(log, bit_rate=500_000)
            assert found.entries + found.unlisted <= 201
            assert found.entries
