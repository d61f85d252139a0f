"""Recordings of LIN: of the lab, of shared lines; formats that hold none are refused before anything is written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import canwire
from canwire import BadValue, Lab, LinEvent, LinFrame, LinMode, LinMonitorMode, LogMark, MarkKind, open_log
from canwire.commands import main
from canwire.commands.shared_hub import find_line
from tests.hubs import LONG_S, serving

FORMATS = ["log", "asc", "blf", "csv", "mf4", "parquet", "pcapng", "db"]
pytestmark = pytest.mark.conforms("PF-10", "PC-09")


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_bus_of_the_lab(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"lin.{suffix}"
    with Lab() as lab:
        bus = lab.lin_bus("lin0")
        master = bus.master(schedule=[0x10, 0x11])
        bus.slave("door", responses={0x10: b"\x01\x02", 0x11: b"\x03"})
        with canwire.record(bus, path) as recorder:
            lab.run_for(0.2)
            assert recorder.count > 10
        heard = master.receive_many(1000)
    with open_log(path) as log:
        frames = [entry for entry in log if isinstance(entry.content, LinFrame)]
    assert {entry.channel for entry in frames} == {"lin0"}
    assert [entry.content for entry in frames] == heard
    assert {entry.direction for entry in frames} == {"R"}


def test_what_goes_wrong_is_recorded_in_the_lab_s_own_time(tmp_path: Path) -> None:
    """A header that nobody answers, and no frame at all: events come by themselves."""
    path = tmp_path / "lin.blf"
    with Lab() as lab:
        bus = lab.lin_bus("lin0", bit_rate=9600)
        master = bus.master()
        with canwire.record(master, path, channel="door") as recorder:
            master.ask(0x10, 2)
            lab.run_for(0.1)
            assert recorder.count == 3
    with open_log(path) as log:
        contents = [(entry.channel, entry.content) for entry in log]
    marks = [content for _, content in contents if isinstance(content, LogMark)]
    assert [(mark.kind, mark.bit_rate) for mark in marks] == [(MarkKind.CLOCK, 0), (MarkKind.BIT_RATE, 9600)]
    errors = [content.error.name for channel, content in contents if isinstance(content, LinEvent)]
    assert errors == ["SLNORE"]


def test_lost_frames_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "lin.csv"
    with Lab() as lab:
        bus = lab.lin_bus("lin0")
        bus.master(schedule=[0x10], responses={0x10: b"\x01"})
        small = bus.slave("small", receive_queue=4)
        lab.run_for(0.5)
        with canwire.record(small, path) as recorder:
            lab.run_for(0.1)
        lost = small.lost
    assert recorder.lost == lost > 0
    with open_log(path) as log:
        marks = [entry.content for entry in log if isinstance(entry.content, LogMark)]
    assert sum(mark.count for mark in marks if mark.kind is MarkKind.LOST) == lost


def test_formats_without_lin_are_refused(tmp_path: Path) -> None:
    with Lab() as lab:
        bus = lab.lin_bus("lin0")
        with pytest.raises(
            BadValue, match=r"drive\.trc: trc holds no LIN frames; these do: candump, csv, asc"
        ):
            canwire.record(bus, tmp_path / "drive.trc")
    assert os.listdir(tmp_path) == []


@pytest.mark.realtime
def test_a_shared_line_by_verb_and_by_monitor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, second = tmp_path / "lin.blf", tmp_path / "second.csv"
    with serving(tmp_path, time="real") as served, canwire.connect(served.address) as hub:
        place = find_line(hub, "lin0", bus_type="LIN")
        monitor = hub.open_monitor(place.board.id, place.line)
        monitor.set_up(LinMonitorMode(receive=64))
        monitor.activate()
        words = [sys.executable, "-m", "canwire", "record", "lin0", str(out), "--hub", served.address]
        with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            assert "recording lin0 to" in process.stderr.readline()
            assert hub.lin_status(place.board.id, place.line).status.running
            with hub.open_lin_control(place.board.id, place.line) as control:
                control.initialise(LinMode(True, 19_200, errors=True))
                control.start()
                control.send(LinFrame(0x10, b"\x11\x22"))
                with canwire.record(monitor, second, epoch_ns=canwire.epoch_ns(hub)) as recorder:
                    while not recorder.count:
                        assert not recorder.wait(0.01)
                process.send_signal(signal.SIGINT)
                said = process.stderr.read()
                assert (process.wait(LONG_S), "0 lost" in said) == (0, True), said
        assert main(["record", "lin0", str(tmp_path / "x.trc"), "--hub", served.address]) == 2
        assert "trc holds no LIN frames" in capsys.readouterr().err
        assert main(["record", "lin0", str(out), "--data-bit-rate", "1000000", "--hub", served.address]) == 2
        assert "is a LIN line" in capsys.readouterr().err
    with open_log(out) as log:
        found = [(entry.channel, entry.content) for entry in log if isinstance(entry.content, LinFrame)]
        assert log.dated
        assert log.clock == "hub"
    assert found == [("lin0", LinFrame(0x10, b"\x11\x22"))]
    assert second.stat().st_size > 100
