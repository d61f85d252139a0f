"""Several lines in one recording, several logs in one file: everything is there, by its time."""

from __future__ import annotations

import itertools
import os
import random
from contextlib import ExitStack
from pathlib import Path

import pytest

import canwire
from canwire import (
    BadValue,
    Frame,
    Lab,
    LinFrame,
    LogEntry,
    LogMark,
    MarkKind,
    create_log,
    merge_logs,
    open_log,
)
from canwire.hub.handles.event import Event
from canwire.logs.batch import LogBatch, batch_of
from canwire.logs.recording import shared
from canwire.logs.recording.several import SeveralShared
from tests.hubs import LONG_S, served_here

pytestmark = pytest.mark.conforms("N-57")
CAN_AND_LIN = """
[[bus]]
name = "can0"
[[bus]]
name = "can1"
[[bus]]
name = "lin0"
type = "lin"
[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"
buses = ["can0", "can1"]
[[board]]
kind = "usb-to-can-fd"
serial = "HW000002"
buses = ["can0", "can1"]
"""


@pytest.mark.parametrize("suffix", ["blf", "mf4", "trace", "csv"])
def test_buses_of_the_lab_go_into_one_log(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"drive.{suffix}"
    with Lab() as lab:
        cans = [lab.can_bus(f"can{number}", bit_rate=500_000) for number in range(2)]
        lin = lab.lin_bus("lin0")
        lin.master(schedule=[0x10])
        lin.slave("door", responses={0x10: b"\x01"})
        nodes = [bus.node("node") for bus in cans]
        for bus in cans:
            bus.node("acknowledges")
        with canwire.record([*cans, lin], path) as recorder:
            for number in range(20):
                nodes[number % 2].send(Frame(0x100 + number))
                lab.run_for(0.003)
        assert recorder.lost == 0
    with open_log(path) as log:
        entries = list(log)
    frames = [(entry.channel, entry.frame.id) for entry in entries if entry.frame]
    assert frames == [(f"can{number % 2}", 0x100 + number) for number in range(20)]
    assert {entry.channel for entry in entries if isinstance(entry.content, LinFrame)} == {
        "lin2" if suffix == "mf4" else "lin0"  # it has numbers only
    }
    times = [entry.timestamp_ns for entry in entries if not isinstance(entry.content, LogMark)]
    assert times == sorted(times)


def test_what_cannot_be_one_log_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "drive.trc"
    with Lab() as lab:
        bus, lin = lab.can_bus("can0", bit_rate=500_000), lab.lin_bus("lin0")
        for lines, why in (
            ([], "no line"),
            ([bus, lin], "trc holds no LIN"),
            ([bus.node("a"), "can0"], "no line that can be recorded"),
        ):
            with pytest.raises(BadValue, match=why):
                canwire.record(lines, path)  # type: ignore[arg-type]
        node = bus.node("b")
        with pytest.raises(BadValue, match="the same line twice"):
            canwire.record([node, node], path)
        with pytest.raises(BadValue, match="for one line"):
            canwire.record([node, bus], path, channel="x")
    assert os.listdir(tmp_path) == []


def test_two_nodes_of_one_bus_have_names_of_their_own(tmp_path: Path) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        a, b = bus.node("a"), bus.node("b")
        with canwire.record([a, b], tmp_path / "drive.csv"):
            bus.node("c").send(Frame(0x123))
            lab.run_for(0.01)
    with open_log(tmp_path / "drive.csv") as log:
        assert [entry.channel for entry in log if entry.frame] == ["can0.a", "can0.b"]


def test_lines_of_one_hub_have_one_clock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is measured: measured for each line, it put frames of two lines a millisecond out of their order."""
    clocks = itertools.count(10**18, 10**6)
    monkeypatch.setattr(shared, "epoch_ns", lambda hub: next(clocks))
    with served_here(tmp_path, CAN_AND_LIN) as address, ExitStack() as closing:
        sources = shared.shared_sources(["any"], address, canwire.WantedMode(None, None), None, closing)
        assert len(sources) == 3
        assert {source.epoch_ns for source in sources} == {10**18}


@pytest.mark.realtime
def test_shared_lines_go_into_one_log(tmp_path: Path) -> None:
    """Named, and any; the last frame waits for what may still be older until the recorder ends."""
    with served_here(tmp_path, CAN_AND_LIN, time="real") as address, canwire.connect(address) as hub:
        with (
            canwire.record(["can0", "can1"], tmp_path / "named.blf", hub=address) as named,
            canwire.record("any", tmp_path / "any.mf4", hub=address) as every,
            hub.open_channel(hub.boards()[1].id, 0) as first,
            hub.open_channel(hub.boards()[1].id, 1) as second,
        ):
            for line, channel in enumerate((first, second)):
                channel.set_up(canwire.ChannelMode(receive=1, transmit=64, frames=False))
                canwire.bring_up(
                    hub,
                    canwire.find_lines(hub, f"HW000002:{line}")[0],
                    lambda status: canwire.WantedMode(None, None).mode(hub.boards()[1].lines[0].capabilities),
                    lambda status: None,
                )
                channel.activate()
            for number in range(50):
                (first, second)[number % 2].send(Frame(number), timeout=LONG_S)
            while min(named.count, every.count) < 50:
                assert not named.wait(0.01)
        assert named.lost == every.lost == 0
    found = []
    for name in ("named.blf", "any.mf4"):
        with open_log(tmp_path / name) as log:
            entries = [entry for entry in log if entry.frame]
        found.append([(entry.channel, entry.frame.id) for entry in entries if entry.frame])
        times = [entry.timestamp_ns for entry in entries]
        assert times == sorted(times)
        for channel, first_id in (("can0", 0), ("can1", 1)):
            assert [id for bus, id in found[-1] if bus == channel] == list(range(first_id, 50, 2))
    assert found[0] == found[1]


class Queue:
    """A line's queue, filled by the test."""

    def __init__(self, name: str) -> None:
        self.channels = [name]
        self.address = name
        self.reading = self
        self.lease = self
        self.waiting: list[int] = []
        self.looked: list[object] = []

    def assign(self, event: Event | None) -> None:
        self.event = event

    def check(self) -> None:
        self.looked.append("checked")

    def take(self, timeout_s: float) -> object:
        assert timeout_s == 0
        entries = [LogEntry(time, self.channels[0], Frame(1, timestamp_ns=time)) for time in self.waiting]
        self.waiting = []
        return batch_of(entries, self.channels).records

    def close(self) -> None:
        self.looked.append("closed")


def test_an_entry_waits_for_older_ones_of_other_lines() -> None:
    """What is newer than all that was seen before the look began may have older ones behind it."""
    a, b = Queue("a"), Queue("b")
    several = SeveralShared([a, b])  # type: ignore[list-item]

    def taken(*new: tuple[Queue, int]) -> list[int]:
        for queue, time in new:
            queue.waiting.append(time)
        return [int(time) for time in several.take(0.01)["time_ns"]]

    assert taken((a, 10), (b, 20)) == []
    assert taken((a, 15), (b, 30)) == [10, 15, 20]  # 15 came into its queue after that was looked into
    assert taken() == [30]
    assert taken() == []
    assert a.looked == ["checked"]
    a.waiting, b.waiting = [50], [40]
    assert [int(time) for time in several.take(0.0)["time_ns"]] == [40, 50]
    several.close()
    assert (a.event, a.looked[-1]) == (None, "closed")


def test_entries_of_one_instant_are_in_the_order_of_the_lines() -> None:
    """Whichever of them was seen first, so that two recorders of the same lines write the same log."""
    a, b = Queue("a"), Queue("b")
    several = SeveralShared([a, b])  # type: ignore[list-item]
    b.waiting = [20]
    assert len(several.take(0.01)) == 0
    a.waiting = [20]  # of the same instant, but its queue had been looked into before it came
    assert several.take(0.01)[["time_ns", "channel"]].tolist() == [(20, 0), (20, 1)]
    several.close()


def _log(path: Path, channel: str, times_ns: list[int], **facts: object) -> Path:
    with create_log(path, **facts) as log:  # type: ignore[arg-type]
        log.write_many(LogEntry(time, channel, Frame(1, timestamp_ns=time), "R") for time in times_ns)
    return path


def _merged(target: Path, *paths: Path, **options: object) -> list[tuple[int, str]]:
    with ExitStack() as closing:
        logs = [closing.enter_context(open_log(path)) for path in paths]
        merge_logs(logs, target, **options)  # type: ignore[arg-type]
    with open_log(target) as log:
        return [(entry.timestamp_ns, entry.channel) for entry in log if entry.frame]


def test_logs_are_merged_by_their_times(tmp_path: Path) -> None:
    """However long each is, and whatever its format."""
    rng = random.Random(5)
    day = 1_700_000_000 * 10**9
    times = [
        sorted(day + rng.randrange(10**12) * 1000 for _ in range(count)) for count in (30_000, 5, 20_000)
    ]
    paths = [
        _log(tmp_path / name, f"can{number}", times[number])
        for number, name in enumerate(("a.log", "b.blf", "c.csv"))
    ]
    expected = sorted((time, f"can{number}") for number in range(3) for time in times[number])
    assert _merged(tmp_path / "all.csv", *paths) == expected
    some = _merged(
        tmp_path / "some.csv",
        *paths,
        channels=[{}, {"can1": "x"}],
        only=lambda batch: LogBatch(batch.records[batch.records["time_ns"] < times[0][9]], batch.channels),
    )
    assert {channel for _, channel in some} <= {"can0", "x", "can2"}
    assert len(some) == sum(time < times[0][9] for part in times for time in part)


def test_a_date_in_the_head_puts_logs_on_one_clock(tmp_path: Path) -> None:
    day = 1_700_000_000 * 10**9
    relative = _log(tmp_path / "a.db", "can0", [1_000_000, 2_000_000], dated=False, start_ns=day)
    dated = _log(tmp_path / "b.log", "can1", [day + 1_500_000])
    assert _merged(tmp_path / "all.csv", relative, dated) == [
        (day + 1_000_000, "can0"), (day + 1_500_000, "can1"), (day + 2_000_000, "can0")]  # fmt: skip


def test_logs_without_a_date_are_merged_with_their_like_only(tmp_path: Path) -> None:
    a = _log(tmp_path / "a.log", "can0", [1_000_000], dated=False)
    b = _log(tmp_path / "b.log", "can1", [500_000], dated=False)
    dated = _log(tmp_path / "c.log", "can1", [1_700_000_000 * 10**9])
    assert _merged(tmp_path / "all.csv", a, b) == [(500_000, "can1"), (1_000_000, "can0")]
    with pytest.raises(BadValue, match=r"a\.log: no date"):
        _merged(tmp_path / "new.csv", a, dated)
    with pytest.raises(BadValue, match="the same file twice"):
        _merged(a, a, b)
    with pytest.raises(TypeError, match="sources"):
        merge_logs([str(a)], tmp_path / "new.csv")  # type: ignore[list-item]
    assert not (tmp_path / "new.csv").exists()


def test_marks_keep_their_channels(tmp_path: Path) -> None:
    with Lab() as lab:
        fast, slow = lab.can_bus("fast", bit_rate=1_000_000), lab.can_bus("slow", bit_rate=125_000)
        canwire.record([fast, slow], tmp_path / "x.csv").close()
    with open_log(tmp_path / "x.csv") as log:
        rates = [
            (entry.channel, entry.content.bit_rate)
            for entry in log
            if isinstance(entry.content, LogMark) and entry.content.kind is MarkKind.BIT_RATE
        ]
    assert rates == [("fast", 1_000_000), ("slow", 125_000)]
