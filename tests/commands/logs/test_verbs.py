"""`canwire convert`, `canwire record`, and `canwire play` of any log onto shared lines."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

import canwire
from canwire import ChannelMode, Frame, convert_log, open_log
from canwire.commands import main
from tests import warm
from tests.hubs import LONG_S, Served, serving

LOG = "(1.000000) can0 123#1122 R\n(1.010000) can1 7FF#R T\n(1.020000) can0 12345678#33 R\n"


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(tmp_path_factory.mktemp("hub"), time="real") as found:
        yield found


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "in.log"
    path.write_text(LOG)
    return path


def lines_of(path: Path) -> list[str]:
    with open_log(path) as found:
        return [f"{entry.channel} {canwire.format_frame(entry.frame)}" for entry in found if entry.frame]


@pytest.mark.smoke
@pytest.mark.conforms("PC-09", "PF-09")
def test_convert(capsys: pytest.CaptureFixture[str], tmp_path: Path, log: Path) -> None:
    out = tmp_path / "out.blf"
    assert main(["convert", str(log), str(out)]) == 0
    assert capsys.readouterr().out == "3 entries from candump to blf\n"
    assert lines_of(out) == ["can0 123#1122", "can1 7FF#R", "can0 12345678#33"]
    assert main(["convert", str(out), "-", "--to", "candump", "--filter", "123:7FF", "--map", "can0=x"]) == 0
    captured = capsys.readouterr()
    assert captured.out == "(0000000001.000000) x 123#1122 R\n"


@pytest.mark.conforms("PC-11", "PF-09")
def test_convert_names_what_is_left_out(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, log: Path
) -> None:
    log.write_text(LOG + "(1.03) lin0 10#01\n(1.04) lin0 11#02\nrubbish\n")
    out = str(tmp_path / "out.trc")
    assert main(["convert", str(log), out]) == 1
    captured = capsys.readouterr()
    assert "canwire: trc: 2 LIN frames left out\n" in captured.err
    assert f"canwire: {log}: line 6: " in captured.err
    assert main(["convert", str(log), out, "--json"]) == 1
    facts = json.loads(capsys.readouterr().out)
    assert (facts["from"], facts["to"], facts["entries"], facts["faults"]) == ("candump", "trc", 3, 1)
    assert facts["left_out"]["LIN frames"] == 2


def test_strict_minds_what_is_left_out(tmp_path: Path, log: Path) -> None:
    log.write_text(LOG + "(1.03) lin0 10#01\n")
    assert main(["convert", str(log), str(tmp_path / "out.trc")]) == 0
    assert main(["convert", str(log), str(tmp_path / "out.trc"), "--strict"]) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["in.log", "in.log"], "the same file twice"),
        (["in.log", "out.bfl"], "did you mean .blf"),
        (["nothing.log", "out.blf"], "No such file"),
        (["in.log", "out.blf", "--map", "can0"], "--map 'can0'"),
        (["in.log", "out.blf", "--from", "cvs"], "did you mean csv"),
    ],
)
def test_mistakes(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch,
    words: list[str], said: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["convert", *words]) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.err.count("\n") == 1
    assert log.read_text() == LOG


@pytest.mark.conforms("N-57")
def test_convert_merges_logs(capsys: pytest.CaptureFixture[str], tmp_path: Path, log: Path) -> None:
    other, out = tmp_path / "other.blf", tmp_path / "out.log"
    convert_log(log, other)
    assert main(["convert", str(log), str(other), str(out)]) == 2
    assert "2 logs into" in capsys.readouterr().err
    words = ["convert", str(log), "--merge", str(other), "--map", "2:can0=can7,2:can1=can8", str(out)]
    assert main(words) == 0
    assert capsys.readouterr().out == "6 entries from candump, blf to candump\n"
    assert lines_of(out) == [
        "can0 123#1122", "can7 123#1122", "can1 7FF#R", "can8 7FF#R", "can0 12345678#33", "can7 12345678#33",
    ]  # fmt: skip
    assert main([*words[:-2], "3:can0=x", str(out)]) == 2
    assert "there are the logs 1 to 2" in capsys.readouterr().err


@pytest.mark.realtime
@pytest.mark.conforms("N-57")
@pytest.mark.parametrize(
    ("lines", "channels"),
    [(["can0", "HW000002:0", "lin0"], {"HW000001:0", "HW000002:0", "lin0"}), (["any"], {"can0", "lin0"})],
)
def test_record_several_lines(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, served: Served, lines: list[str], channels: set[str]
) -> None:
    """Marks alone tell which channels there are; lines on one bus have their addresses."""
    out = tmp_path / "drive.csv"
    assert main(["record", *lines, "--for", "0.05", str(out), "--hub", served.address]) == 0
    assert f"recording {', '.join(lines)} to {out}" in capsys.readouterr().err
    with open_log(out) as found:
        assert {entry.channel for entry in found} == channels


@pytest.mark.realtime
@pytest.mark.conforms("PC-09", "PC-10")
def test_record_until_ctrl_c(tmp_path: Path, served: Served) -> None:
    out = tmp_path / "drive.blf"
    words = [sys.executable, "-m", "canwire", "record", "can0", str(out), "--hub", served.address]
    with warm.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert "recording can0 to" in process.stderr.readline()
        send = [
            sys.executable,
            "-m",
            "canwire",
            "send",
            "can0",
            "123#1122",
            "-n",
            "5",
            "--hub",
            served.address,
        ]
        warm.run(send, check=True, timeout=LONG_S, capture_output=True)
        process.send_signal(2)
        said = process.stderr.read()
        assert process.wait(LONG_S) == 0
    assert f"in {out}; 0 lost" in said
    assert lines_of(out) == ["can0 123#1122"] * 5


@pytest.mark.parametrize("words", [["--rotate-size", "10x"], ["--rotate-time", "0"], ["--for", "soon"]])
def test_record_refuses_impossible_sizes(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    assert main(["record", "can0", "x.blf", *words]) == 2
    assert f"{words[0]} {words[1]}: a number above 0 and a unit" in capsys.readouterr().err


@pytest.mark.conforms("PC-06")
@pytest.mark.parametrize("suffix", ["blf", "asc", "csv", "pcapng", "mf4", "parquet", "trace"])
def test_every_format_is_played_onto_a_shared_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, served: Served, log: Path, suffix: str
) -> None:
    path = tmp_path / f"in.{suffix}"
    convert_log(log, path)
    with heard(served) as channel:
        assert main(["play", str(path), "HW000001:0", "-t", "--loop", "2", "--hub", served.address]) == 0
        found = [frame for _ in range(6) if (frame := channel.receive(LONG_S))]
    assert "6 of 6 frames delivered" in capsys.readouterr().out
    once = [Frame(0x123, b"\x11\x22"), Frame(0x7FF, remote=True), Frame(0x12345678, b"\x33", extended=True)]
    assert found == once * 2


@pytest.mark.conforms("PC-06")
@pytest.mark.parametrize("words", [["--map", "can0=HW000001:0"], ["HW000001:0=can0"]])
def test_channels_go_onto_the_lines_they_are_mapped_to(
    capsys: pytest.CaptureFixture[str], served: Served, log: Path, words: list[str]
) -> None:
    with heard(served):
        assert main(["play", str(log), *words, "-t", "--hub", served.address]) == 0
    captured = capsys.readouterr()
    assert "2 frames onto HW000001:0; 1 of other channels left out" in captured.err
    assert "2 of 2 frames delivered" in captured.out
    assert main(["play", str(log), "--map", "vcan7=can0", "--hub", served.address]) == 2
    assert "the log has no channel vcan7; it has can0, can1" in capsys.readouterr().err


def test_filters_choose_what_is_played(capsys: pytest.CaptureFixture[str], log: Path) -> None:
    assert main(["play", str(log), "--filter", "123:7FF", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 1


class heard:  # noqa: N801  (a context manager that reads like a verb)
    """Another program's channel, on another controller of can0, which acknowledges."""

    def __init__(self, served: Served) -> None:
        self._served = served
        self._closing = ExitStack()

    def __enter__(self) -> canwire.HubChannel:
        hub = self._closing.enter_context(canwire.connect(self._served.address, name="listener"))
        place = canwire.find_lines(hub, "can0")[1]
        channel = self._closing.enter_context(hub.open_channel(place.board.id, place.line))
        channel.set_up(ChannelMode(receive=1000, transmit=0))
        control = canwire.bring_up(
            hub, place, lambda status: canwire.WantedMode().mode(place.info.capabilities), lambda status: None
        )
        if control is not None:
            self._closing.enter_context(control)
        channel.activate()
        return channel

    def __exit__(self, *_: object) -> None:
        self._closing.close()
