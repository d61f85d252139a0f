"""`canwire play`: a real car's log on the wire, and every kind of log that is not quite right."""

from __future__ import annotations

import io
import json
import os
import sys
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import pytest

from canwire import Frame, LabBus, LogLine, parse_log_line
from canwire.commands import main, play
from canwire.commands.lab import senders
from canwire.commands.shell import progress

CAR = Path(__file__).parents[2] / "examples" / "car-candump.log"
CAR_FRAMES = 12_974
INTERMISSION_NS = 3 * 2000


def lines_of(path: Path) -> list[LogLine]:
    return [parse_log_line(line) for line in path.read_text().splitlines()]


def frames_of(path: Path) -> list[Frame]:
    return [line.content for line in lines_of(path) if isinstance(line.content, Frame)]


def log_of(folder: Path, *lines: str) -> str:
    path = folder / "in.log"
    path.write_text("".join(f"{line}\n" for line in lines))
    return str(path)


def played(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    assert main(["play", *words, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The car's log, played twice."""
    folder = tmp_path_factory.mktemp("drives")
    paths = [folder / "first.log", folder / "second.log"]
    for path in paths:
        assert main(["play", str(CAR), "--log", str(path)]) == 0
    return paths


@pytest.mark.conforms("G-01")
def test_car_arrives_complete_and_unchanged(drives: list[Path]) -> None:
    sent, received = frames_of(CAR), frames_of(drives[0])
    assert len(sent) == len(received) == CAR_FRAMES
    assert Counter(sent) == Counter(received)
    for_id: dict[int, list[list[Frame]]] = defaultdict(lambda: [[], []])
    for side, frames in enumerate((sent, received)):
        for frame in frames:
            for_id[frame.id][side].append(frame)
    assert len(for_id) == 180
    assert all(before == after for before, after in for_id.values())


@pytest.mark.conforms("G-04")
def test_car_arrives_in_order_of_arbitration(drives: list[Path]) -> None:
    """Whenever a frame starts, nobody who has a frame ready has a lower identifier."""
    begin_ns = lines_of(CAR)[0].timestamp_ns
    due_ns: dict[int, list[int]] = defaultdict(list)
    for line in reversed(lines_of(CAR)):
        assert isinstance(line.content, Frame)
        due_ns[line.content.id].append(line.timestamp_ns - begin_ns)
    free_ns = 0
    for frame in frames_of(drives[0]):
        start_ns = max(free_ns, due_ns[frame.id].pop())
        waiting = [id for id, stamps in due_ns.items() if stamps and stamps[-1] <= start_ns]
        assert frame.id <= min(waiting, default=0x7FF)
        free_ns = frame.timestamp_ns - begin_ns + INTERMISSION_NS


@pytest.mark.conforms("G-17")
def test_twice_gives_identical_logs(drives: list[Path]) -> None:
    assert drives[0].read_bytes() == drives[1].read_bytes()


def test_summary_of_the_car(capsys: pytest.CaptureFixture[str]) -> None:
    found = played(capsys, str(CAR))
    assert (found["frames"], found["lost"]) == (CAR_FRAMES, 0)
    assert (found["error_frames"], found["broken_lines"]) == (0, 0)
    assert 8.0 < found["bus_time_s"] < 9.0  # nine whole seconds, the last one's frames in a burst
    assert 30 < found["bus_load"] < 40
    assert found["peak_load"] == 100.0  # each second begins with 1500 frames that are due at once
    assert found["speed_factor"] == pytest.approx(found["bus_time_s"] / found["wall_time_s"], abs=0.001)


def test_times_are_the_logs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = log_of(tmp_path, "(100.5) vcan7 123#1122", "(100.6) vcan7 12345678#R")
    out = tmp_path / "out.log"
    played(capsys, log, "--log", str(out), "--bus", "engine")
    assert out.read_text().splitlines() == [
        "(0000000100.500124) engine 123#1122",  # C04: 62 bits of 2 us
        "(0000000100.600132) engine 12345678#R",  # C20: 66 bits
    ]


def test_lines_for_people(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = log_of(tmp_path, "(0.0) can0 123#1122", "(0.999876) can0 123#1122", "nonsense")
    assert main(["play", log]) == 0
    captured = capsys.readouterr()
    lines = captured.out.splitlines()
    assert lines[0].startswith("private bus   can0, heard by no other program")
    assert lines[1:6] == [
        "frames        2",
        "lost          0",
        "bus load      0.03 % mean, 0.13 % in the busiest 100 ms",  # 65 and 62 bits of 2 us
        "error frames  0",
        "bus time      1.000000 s",
    ]
    assert [line.split()[0] for line in lines[6:]] == ["wall", "speed", "skipped"]
    assert lines[-1] == "skipped       1 broken lines"
    assert captured.err.startswith(f"canwire: {log}:3: 'nonsense' is no log line")


@pytest.mark.parametrize(("strict", "status"), [([], 0), (["--strict"], 1)])
def test_broken_lines_are_told_and_skipped(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, strict: list[str], status: int
) -> None:
    path = tmp_path / "in.log"
    path.write_bytes(
        b"(1.0) can0 123#11\r\n\n(1.1) can0 999#11\n\xff\xfe\n(1.2) can0 123#22\n"
        b"(9999999999.0) can0 123#33\n(1.3) can0 1"
    )
    assert main(["play", str(path), "--json", *strict]) == status
    captured = capsys.readouterr()
    found = json.loads(captured.out)
    assert (found["frames"], found["broken_lines"]) == (2, 4)
    assert [line.split(":")[2] for line in captured.err.splitlines()] == ["3", "4", "6", "7"]
    assert "999" in captured.err
    assert "more than a century" in captured.err


def test_strict_is_content_with_a_whole_log(tmp_path: Path) -> None:
    assert main(["play", log_of(tmp_path, "(1.0) can0 123#11"), "--strict"]) == 0


def test_time_that_goes_back_is_now(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    frames = [("5.0", "300"), ("6.0", "200"), ("4.0", "100"), ("5.5", "400"), ("7.0", "500")]
    log = log_of(tmp_path, *(f"({stamp}) can0 {id}#" for stamp, id in frames))
    out = tmp_path / "out.log"
    found = played(capsys, log, "--log", str(out))
    assert (found["frames"], found["stamps_going_back"], found["broken_lines"]) == (5, 2, 0)
    received = frames_of(out)
    assert [frame.id for frame in received] == [0x300, 0x100, 0x200, 0x400, 0x500]  # three due at once
    assert [frame.timestamp_ns // 10**9 for frame in received] == [5, 6, 6, 6, 7]


def test_error_frames_are_skipped_and_counted(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = log_of(tmp_path, "(1.0) can0 20000080#0000000000000000", "(1.0) can0 123#11")
    found = played(capsys, log)
    assert (found["frames"], found["error_frames_skipped"], found["error_frames"]) == (1, 1, 0)


def test_an_empty_log_is_no_frame(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    found = played(capsys, log_of(tmp_path))
    assert (found["frames"], found["bus_time_s"], found["bus_load"], found["speed_factor"]) == (0, 0, 0, 0)


def test_fd_needs_a_data_bit_rate(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = log_of(tmp_path, "(1.0) can0 123#11", "(1.0) can0 123##1AABB")
    assert main(["play", log]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == f"canwire: {log}:2: a CAN FD frame; add --data-bit-rate, 2000000 perhaps\n"
    out = tmp_path / "out.log"
    played(capsys, log, "--data-bit-rate", "2000000", "--log", str(out))
    assert [frame.bit_rate_switch for frame in frames_of(out)] == [False, True]


def test_one_sender_keeps_the_logs_order(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = log_of(tmp_path, "(1.0) can0 300#", "(1.0) can0 00000100#", "(1.0) can0 100#", "(1.0) can0 200#")
    orders = {}
    for one in ("each", "one"):
        out = tmp_path / f"{one}.log"
        played(capsys, log, "--senders", one, "--log", str(out))
        orders[one] = [(frame.extended, frame.id) for frame in frames_of(out)]
    assert orders["one"] == [(False, 0x300), (True, 0x100), (False, 0x100), (False, 0x200)]
    assert orders["each"] == [(True, 0x100), (False, 0x100), (False, 0x200), (False, 0x300)]


@pytest.mark.finding("linux 3")
@pytest.mark.parametrize("most", [3, 120])  # 120: one for each identifier, just so
def test_many_identifiers_take_turns_at_few_nodes(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    """What a bus does for a frame grows with its nodes: thousands of identifiers made it slower than real time."""
    monkeypatch.setattr(senders, "MOST", most)
    made: list[str] = []
    new_node = LabBus.node

    def counted(bus: LabBus, name: str, **settings: Any) -> Any:
        made.append(name)
        return new_node(bus, name, **settings)

    monkeypatch.setattr(LabBus, "node", counted)
    rounds = [f"({k}.0) can0 {0x100 + 5 * k + at:03X}#{k:02X}" for k in range(40) for at in (4, 2, 0)]
    out = tmp_path / "out.log"
    found = played(capsys, log_of(tmp_path, *rounds), "--log", str(out))
    assert (found["frames"], found["lost"]) == (120, 0)
    assert [frame.id for frame in frames_of(out)] == sorted(frame.id for frame in frames_of(out))
    assert len(made) - 1 == min(most, 120)


@pytest.mark.finding("linux 3")
def test_more_at_once_than_there_are_nodes_wait(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(senders, "MOST", 4)
    out = tmp_path / "out.log"
    burst = [f"(1.0) can0 {0x100 + k:03X}#" for k in range(50)]
    found = played(capsys, log_of(tmp_path, *burst), "--log", str(out))
    assert (found["frames"], found["lost"]) == (50, 0)
    assert sorted(frame.id for frame in frames_of(out)) == [0x100 + k for k in range(50)]


def test_a_log_beyond_every_queue_waits_for_the_bus(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(play, "_IN_FLIGHT", 64)
    monkeypatch.setattr(senders, "_QUEUE", 8)
    burst = [f"(1.0) can0 {0x100 + k % 3:03X}#{k:04X}" for k in range(300)]
    out = tmp_path / "out.log"
    found = played(capsys, log_of(tmp_path, *burst), "--log", str(out))
    assert (found["frames"], found["lost"]) == (300, 0)
    assert Counter(frames_of(out)) == Counter(frames_of(tmp_path / "in.log"))


def test_standard_input_need_not_be_a_file(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    reading, writing = os.pipe()
    os.write(writing, b"(1.0) can0 123#11\n(1.0) can0 124#\n")
    os.close(writing)
    with open(reading, "rb") as pipe, io.TextIOWrapper(pipe) as text:
        monkeypatch.setattr(sys, "stdin", text)
        assert played(capsys, "-")["frames"] == 2


def test_vcd_has_the_level(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    vcd = tmp_path / "out.vcd"
    played(capsys, log_of(tmp_path, "(1.0) can0 123#1122"), "--vcd", str(vcd))
    edges = "".join(line for line in vcd.read_text().splitlines() if line[0] in "#01")
    assert "#00!#60001!#80000!#120001!#140000!#200001!" in edges  # 123#1122 begins 000 1 00 1 000 11


@pytest.mark.realtime
def test_real_time_takes_its_time(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = log_of(tmp_path, "(1.0) can0 123#11", "(1.05) can0 123#22")
    out = tmp_path / "out.log"
    found = played(capsys, log, "--time", "real", "--log", str(out))
    assert found["frames"] == 2
    assert found["wall_time_s"] >= 0.05
    assert found["speed_factor"] <= 1.0
    first, second = lines_of(out)
    assert first.timestamp_ns > 1_000_000_000
    assert second.timestamp_ns > 1_050_000_000


@pytest.mark.finding("wire 9")
def test_a_file_that_is_no_log_is_one_error(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    log = log_of(tmp_path, *["\x1b[2J;nonsense"] * 1000)
    assert main(["play", log]) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err.count("\n")) == ("", 1)
    assert captured.err.startswith(f"canwire: {log} is no candump log; line 1: ")
    assert "\x1b" not in captured.err


def test_of_many_broken_lines_ten_are_shown_and_the_rest_counted(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log = log_of(tmp_path, "(1.0) can0 123#11", *["nonsense"] * 25)
    assert main(["play", log]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 11
    assert lines[-1] == f"canwire: {log}: 15 more broken lines"


@pytest.mark.parametrize("where", ["LOG", "--log", "--vcd"])
def test_files_that_do_not_open_are_told_in_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, where: str
) -> None:
    missing = str(tmp_path / "nowhere" / "file")
    words = [missing] if where == "LOG" else [log_of(tmp_path, "(1.0) can0 123#11"), where, missing]
    assert main(["play", *words]) == 2
    assert capsys.readouterr().err == f"canwire: {missing}: No such file or directory\n"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--bus", "can 0"], "--bus 'can 0'"),
        (["--bus", ""], "--bus ''"),
        (["--bit-rate", "0"], "0"),
        (["--bit-rate", "12345678"], "12345678"),
    ],
)
def test_mistakes_are_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, words: list[str], why: str
) -> None:
    assert main(["play", log_of(tmp_path, "(1.0) can0 123#11"), *words]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("canwire: ")
    assert (captured.out, captured.err.count("\n")) == ("", 1)
    assert why in captured.err


@pytest.mark.parametrize("option", ["--log", "--vcd"])
def test_the_log_is_not_overwritten(capsys: pytest.CaptureFixture[str], tmp_path: Path, option: str) -> None:
    log = log_of(tmp_path, "(1.0) can0 123#11")
    again = tmp_path / "again.log"
    again.symlink_to(log)
    assert main(["play", log, option, str(again)]) == 2
    assert "the same file twice" in capsys.readouterr().err
    assert Path(log).read_text() == "(1.0) can0 123#11\n"


class FakeTerminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_shows_on_a_terminal_once_it_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    terminal = FakeTerminal()
    monkeypatch.setattr("canwire.commands.shell.progress.time.monotonic", lambda: now[0])
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.Progress(200, "playing") as bar:
        now[0] += 0.9
        bar.show(10)
        assert terminal.getvalue() == ""
        now[0] += 0.2
        bar.show(50)
        bar.show(60)  # too soon after the last one
        assert terminal.getvalue() == "\rplaying [" + "#" * 10 + "." * 30 + "]  25%\x1b[K"
    assert terminal.getvalue().endswith("\r\x1b[K")


def test_progress_leaves_files_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr("canwire.commands.shell.progress.time.monotonic", lambda: now[0])
    file = io.StringIO()
    monkeypatch.setattr(sys, "stderr", file)
    with progress.Progress(200, "playing") as bar:
        now[0] += 10
        bar.show(50)
    assert file.getvalue() == ""


@pytest.mark.finding("newcomer F13")
def test_four_frames_are_no_full_bus(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """They follow each other, so the bus is never free; but it is a hundredth of 100 ms that they take."""
    log = log_of(tmp_path, *(f"(1.0) can0 12{k}#1122334455667788" for k in range(4)))
    facts = played(capsys, log)
    assert facts["bus_time_s"] < 0.002
    assert facts["bus_load"] == pytest.approx(facts["peak_load"], abs=0.02)
    assert 0.5 < facts["bus_load"] < 1.5


@pytest.mark.finding("newcomer F10")
def test_a_trace_is_told_of_beforehand(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    vcd = tmp_path / "out.vcd"
    log = log_of(tmp_path, *(f"({k}.0) can0 {k % 9 + 0x100:03X}#1122334455667788" for k in range(2000)))
    assert main(["play", log, "--vcd", str(vcd)]) == 0
    said = capsys.readouterr().err
    assert said.startswith("canwire: the trace will have about 1 MB and take about ")
    assert "; with --senders each (9 nodes that arbitrate) " in said
    assert 0.5e6 < vcd.stat().st_size < 2e6
    assert main(["play", log_of(tmp_path, "(1.0) can0 123#"), "--vcd", str(vcd), "--senders", "each"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (bytes(range(256)) * 40, " is no candump log; line 1: "),
        (b"LOGG" + bytes(2000), ": nothing of it can be read as blf; byte 144: "),
        (b"[section]\nname = value\n", " is no candump log; line 1: "),
    ],
)
@pytest.mark.finding("newcomer F13")
def test_binary_and_other_formats_are_one_error(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, content: bytes, why: str
) -> None:
    log = tmp_path / "drive.blf"
    log.write_bytes(content)
    assert main(["play", str(log)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"canwire: {log}{why}")
    assert said.count("\n") == 1
    assert said.isprintable() or said.strip().isprintable()
