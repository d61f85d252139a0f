"""`canwire lin`: which line it means, how it starts it, what it prints, and what became of what it sent."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import pytest

import canwire
from canwire import (
    BadText,
    BadValue,
    Hub,
    LinControl,
    LinEvent,
    LinFrame,
    LinMode,
    LinSchedule,
    LinSlot,
    connect,
    parse_lin_log_line,
    parse_lin_schedule,
)
from canwire.commands import main
from canwire.commands.lin import schedule
from canwire.commands.lin.line import mode_text
from canwire.commands.lin.slots import with_delays
from tests import warm
from tests.cases import each

MS = 1_000_000
LINE = "HW000001:2"
LDF = """
LIN_description_file;
LIN_protocol_version = "2.1";
LIN_language_version = "2.1";
LIN_speed = 9.6 kbps;
Nodes { Master: Door, 5 ms, 0.1 ms; Slaves: Window; }
Signals { Speed: 8, 5, Door, Window; Position: 8, 0, Window, Door; }
Frames {
  Command: 0x10, Door, 1 { Speed, 0; }
  Status: 0x11, Window, 1 { Position, 0; }
}
Node_attributes { Window { LIN_protocol = "2.1"; configured_NAD = 1; product_id = 1, 2;
  response_error = Position; configurable_frames { Command; Status; } } }
Schedule_tables { Normal { Command delay 20 ms; Status delay 20 ms; } Slow { Command delay 50 ms; } }
"""

# slots


def test_slots() -> None:
    table, frames = parse_lin_schedule(["10", "11:4@10ms", "12#0102@2.5ms", "3f#00_E", "3C@1s", "13@500us"])
    assert [(slot.ids[0], slot.length, slot.delay_ns) for slot in table.slots] == [
        (0x10, 0, 0),
        (0x11, 4, 10 * MS),
        (0x12, 0, 2_500_000),
        (0x3F, 0, 0),
        (0x3C, 0, 1000 * MS),
        (0x13, 0, 500_000),
    ]
    assert frames == [LinFrame(0x12, b"\x01\x02"), LinFrame(0x3F, b"\x00", enhanced=True)]


@each(
    ("text", "error", "why"),
    [
        ("1", BadValue, "slot '1': like 10, 11:4@10ms"),
        ("10:9", BadValue, "slot '10:9': like"),
        ("10@10", BadValue, "slot '10@10': like"),
        ("100", BadValue, "slot '100': like"),
        ("40", BadValue, "slot '40': frame slot: LIN identifier 0x40"),
        ("10@2000000s", BadValue, "slot '10@2000000s': delay_ns"),
        ("10#R4", BadValue, "slot '10#R4': data behind #; write 10:4 to ask for 4 bytes"),
        ("10#0", BadText, "'10#0'"),
    ],
)
def test_no_slots(text: str, error: type[Exception], why: str) -> None:
    with pytest.raises(error, match=re.escape(why)):
        parse_lin_schedule([text])


@each(("bit_rate", "usual_ms"), [(20_000, 10), (19_200, 10), (9_600, 20), (1_000, 175)])
def test_slots_have_room_for_any_frame(bit_rate: int, usual_ms: int) -> None:
    table = with_delays(LinSchedule.of([0x10, LinSlot.frame(0x11, delay_ns=7)]), bit_rate)
    assert [slot.delay_ns for slot in table.slots] == [usual_ms * MS, 7]


# with a hub


class Served:
    """A hub behind a socket; `run` is the command line on it."""

    def __init__(self, address: str) -> None:
        self.address = address

    def run(self, *words: str) -> int:
        return main(["lin", *words, "--hub", self.address])


@pytest.fixture
def served(hub_address: str) -> Served:
    return Served(hub_address)


@pytest.fixture
def hub(hub_address: str) -> Iterator[Hub]:
    with connect(hub_address, name="tester") as client:
        yield client


def window(hub: Hub) -> LinControl:
    """A slave on a board of its own that answers 11."""
    board = hub.plug("usb-to-can-fd", "HW777777")
    control = hub.open_lin_control(board.id, 2)
    control.initialise(LinMode(master=False, bit_rate=19_200))
    control.respond(LinFrame(0x11, b"\x22"))
    control.start()
    return control


class Running:
    """`canwire lin` in a process of its own; `told` is its first line on stderr."""

    def __init__(self, hub: Served, *words: str) -> None:
        self.process = warm.Popen(
            [sys.executable, "-m", "canwire", "lin", *words, "--hub", hub.address],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def told(self) -> str:
        assert self.process.stderr is not None
        return self.process.stderr.readline().removeprefix("canwire: ").rstrip()

    def line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().rstrip()

    def end(self, number: signal.Signals | None = None) -> tuple[int, list[str], str]:
        """Exit status, the lines left, and what it said at the end."""
        if number is not None:
            self.process.send_signal(number)
        out, err = self.process.communicate(timeout=30)
        return self.process.returncode, out.splitlines(), err.removeprefix("canwire: ").rstrip()

    def kill(self) -> None:
        self.process.kill()
        self.process.communicate(timeout=30)


Start = Callable[..., Running]


@pytest.fixture
def start(served: Served) -> Iterator[Start]:
    running: list[Running] = []

    def begin(*words: str) -> Running:
        running.append(Running(served, *words))
        return running[-1]

    yield begin
    for one in running:
        one.kill()


def texts(lines: list[str]) -> list[str]:
    """Log lines without their times."""
    return [line.partition(") ")[2] for line in lines]


def errors(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return [line.removeprefix("canwire: ") for line in capsys.readouterr().err.splitlines()]


def test_a_dump_sees_what_its_own_line_sends_and_others_answer(
    served: Served, hub: Hub, start: Start, capsys: pytest.CaptureFixture[str]
) -> None:
    dump = start("dump", "lin0", "-n", "2")
    assert dump.told() == f"{LINE} on lin0: slave, 19200 bit/s; listening"
    window(hub)
    assert served.run("send", "lin0", "10#0102", "11#R") == 0
    captured = capsys.readouterr()
    assert (texts(captured.out.splitlines()), captured.err) == (["lin0 11#22 R"], "")
    status, lines, told = dump.end()
    assert (status, told) == (0, "2 shown, 0 lost")
    assert texts(lines) == ["lin0 10#0102 T", "lin0 11#22 R"]
    assert all(parse_lin_log_line(line).timestamp_ns > 1_000_000_000 * 10**9 for line in lines)


def test_a_dump_leaves_a_line_as_it_is(served: Served, hub: Hub, start: Start) -> None:
    control = hub.open_lin_control(hub.board("HW000001").id, 2)
    control.initialise(LinMode(master=True, bit_rate=9_600, errors=True))
    control.start()
    dump = start("dump", LINE, "-i", "-e", "-n", "2")
    assert dump.told() == f"{LINE} on lin0: master, 9600 bit/s; listening"
    for frame in (LinFrame(0x10, header_only=True), LinFrame(0x12, b"\x01")):
        with hub.open_monitor(control.board, 2) as monitor:
            monitor.set_up(canwire.LinMonitorMode(16))
            monitor.activate()
            control.send(frame)
            assert monitor.receive(20) is not None
        while control.status().status.transmitting:
            pass
    status, lines, _ = dump.end()
    assert (status, texts(lines)) == (0, ["lin0 ERROR#SLNORE@10 R", "lin0 12#01 T"])


def test_a_dump_waits_for_whoever_is_about_to_start_the_line(served: Served, hub: Hub, start: Start) -> None:
    control = hub.open_lin_control(hub.board("HW000001").id, 2)
    dump = start("dump", "lin0", "-n", "1")
    told = dump.told()
    assert told.startswith(f"{LINE} on lin0 does not run yet ({LINE}: its control is held by tester")
    control.initialise(LinMode(master=True, bit_rate=19_200))
    control.start()
    control.send(LinFrame(0x10, b"\x05"))
    assert texts(dump.end()[1]) == ["lin0 10#05 T"]


@pytest.mark.parametrize(("words", "text"), [((), "slave, 19200 bit/s"), (("--master",), "master, 19200 bit/s"),
                                             (("--bit-rate", "2400"), "slave, 2400 bit/s"),
                                             (("--bit-rate", "0"), "slave, no bit rate yet")])  # fmt: skip
def test_how_a_dump_starts_a_line(
    served: Served, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], text: str
) -> None:
    assert served.run("dump", "lin0", "-T", "0", *words) == 0
    assert errors(capsys) == [f"{LINE} on lin0: {text}; listening", "0 shown, 0 lost"]


@pytest.mark.conforms("X4-49")
def test_three_processes_share_the_three_lines_of_a_board(served: Served, start: Start) -> None:
    lin = start("dump", LINE, "-n", "1")
    lin.told()
    command = [sys.executable, "-m", "canwire", "dump", "HW000001:0", "-n", "1", "--hub", served.address]
    with warm.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as can:
        assert can.stderr is not None
        assert can.stderr.readline().endswith("listening\n")
        words = ["send", "HW000001:1", "123#11", "--hub", served.address]
        assert warm.run([sys.executable, "-m", "canwire", *words], timeout=30).returncode == 0
        assert served.run("send", LINE, "10#0102") == 0
        assert can.communicate(timeout=30)[0] == "  HW000001:0  123   [1]  11\n"
    assert texts(lin.end()[1]) == [f"{LINE} 10#0102 T"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_end_of_a_dump_is_told(served: Served, hub: Hub, start: Start, number: signal.Signals) -> None:
    dump = start("dump", "lin0")
    dump.told()
    assert dump.end(number) == (128 + number, [], "0 shown, 0 lost")
    assert not hub.lin_status(hub.board("HW000001").id, 2).status.initialised


def test_a_pulled_board_ends_a_dump(served: Served, hub: Hub, start: Start) -> None:
    dump = start("dump", "lin0")
    dump.told()
    hub.unplug("HW000001")
    status, lines, told = dump.end()
    assert (status, lines) == (2, [])
    assert told.startswith("0 shown, lost unknown: board HW000001 (usb-to-can-fd) was unplugged")


def test_nobody_answers(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    assert served.run("send", "lin0", "10#R", "12#01") == 1
    assert errors(capsys) == [f"{LINE}: 10#R not delivered: nobody answers on lin0"]


def test_a_shorted_bus(served: Served, hub: Hub, capsys: pytest.CaptureFixture[str]) -> None:
    hub.short("lin0")
    assert served.run("send", "lin0", "10#01", "--timeout", "0.5") == 1
    [line] = errors(capsys)
    assert line.startswith(f"{LINE}: 10#01 not delivered: ")


def test_sending_needs_the_control(served: Served, hub: Hub, capsys: pytest.CaptureFixture[str]) -> None:
    hub.open_lin_control(hub.board("HW000001").id, 2)
    for verb in (("send", "lin0", "10#"), ("schedule", "lin0", "10")):
        assert served.run(*verb) == 2
        [line] = errors(capsys)
        assert line.startswith(
            f"only one at a time can be the master of a line: {LINE}: its control is held by "
        )


def test_sending_prefers_a_line_that_nobody_holds(
    served: Served, hub: Hub, capsys: pytest.CaptureFixture[str]
) -> None:
    board = hub.plug("usb-to-can-fd", "HW777777")
    control = hub.open_lin_control(hub.board("HW000001").id, 2)
    control.initialise(LinMode(master=False, bit_rate=19_200))
    control.respond(LinFrame(0x11, b"\x33"))
    control.start()
    assert served.run("send", "lin0", "11#R", "-n", "3") == 0
    assert texts(capsys.readouterr().out.splitlines()) == ["lin0 11#33 R"] * 3
    assert not hub.lin_status(board.id, 2).status.initialised  # it was given back


def test_a_running_line_keeps_its_bit_rate(
    served: Served, start: Start, capsys: pytest.CaptureFixture[str]
) -> None:
    start("dump", "lin0", "--bit-rate", "9600").told()
    assert served.run("send", "lin0", "10#", "--bit-rate", "19200") == 2
    assert errors(capsys) == [f"{LINE} runs as slave, 9600 bit/s; leave --bit-rate out"]
    assert served.run("send", "lin0", "10#") == 0


@pytest.mark.smoke
def test_a_schedule_runs_while_the_command_does(
    served: Served, hub: Hub, start: Start, capsys: pytest.CaptureFixture[str]
) -> None:
    window(hub)
    assert served.run("schedule", "lin0", "10#AA", "11:1@20ms", "12", "--rounds", "2") == 0
    captured = capsys.readouterr()
    wanted = ["lin0 10#AA T", "lin0 11#22 R", "lin0 ERROR#SLNORE@12 R"] * 2
    assert [text for text in texts(captured.out.splitlines()) if "STATE" not in text] == wanted
    times = [
        line.timestamp_ns
        for line in map(parse_lin_log_line, captured.out.splitlines())
        if not isinstance(line.content, LinEvent) and line.content.id == 0x10
    ]
    assert times[1] - times[0] == pytest.approx(40 * MS, abs=1000)
    endless = start("schedule", "lin0", "10#AA", "11:1")
    for _ in range(10):
        assert endless.line()
    assert endless.end(signal.SIGINT)[0] == 130
    assert not hub.lin_status(hub.board("HW000001").id, 2).status.initialised


@pytest.fixture
def ldf(tmp_path: Path) -> str:
    pytest.importorskip("ldfparser")
    path = tmp_path / "door.ldf"
    path.write_text(LDF, encoding="utf-8")
    return str(path)


@pytest.mark.conforms("PF-14")
def test_a_description_drives_the_master_and_decodes_the_monitor(
    served: Served, hub: Hub, start: Start, ldf: str, capsys: pytest.CaptureFixture[str]
) -> None:
    dump = start("dump", "lin0", "--ldf", ldf, "-n", "2")
    assert dump.told() == f"{LINE} on lin0: slave, 9600 bit/s; listening"
    slave = window(hub)
    slave.initialise(LinMode(master=False, bit_rate=9_600))
    slave.respond(LinFrame(0x11, b"\x22"))
    slave.start()
    assert served.run("schedule", "lin0", "--ldf", ldf, "--table", "Normal", "--rounds", "1") == 0
    wanted = ["lin0 10#05 T  Command: Speed 5", "lin0 11#22 R  Status: Position 34"]
    assert [text for text in texts(capsys.readouterr().out.splitlines()) if "STATE" not in text] == wanted
    assert texts(dump.end()[1]) == wanted


def test_tables_of_a_description(
    served: Served, ldf: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert served.run("schedule", "lin0", "--ldf", ldf, "--table", "Fast") == 2
    assert errors(capsys) == [f"{ldf}: no schedule 'Fast'; there are Normal, Slow"]
    (tmp_path / "bad.ldf").write_text("nonsense")
    assert served.run("dump", "lin0", "--ldf", str(tmp_path / "bad.ldf")) == 2
    assert "bad.ldf" in errors(capsys)[0]


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("dump", "can0"), "can0: HW000001:0 is a CAN line; use `canwire dump` or `canwire send`"),
        (("send", "HW000002:1", "10#"), "HW000002:1: HW000002:1 is a CAN line; use "),
        (("dump", "lin7"), "no line or bus 'lin7'; there are HW000001:0 (on can0)"),
        (("dump", "lin0", "-n", "0"), "--count 0: 1 or more"),
        (("dump", "lin0", "-T", "nan"), "--timeout nan: 0 or more"),
        (("dump", "lin0", "--bit-rate", "500"), "LIN runs at 1000 to 20000 bit/s"),
        (("dump", "lin0", "--bit-rate", "0", "--master"), "only a slave finds the bit rate"),
        (("send", "lin0", "123#"), "'123#'"),
        (("send", "lin0", "10#", "-n", "0"), "--count 0: 1 or more"),
        (("schedule", "lin0"), "give slots, or a description by --ldf"),
        (("schedule", "lin0", "10", "--rounds", "-1"), "--rounds -1: 1 or more, or 0 for no limit"),
        (("schedule", "lin0", "77"), "slot '77': frame slot: LIN identifier 0x77"),
    ],
)
def test_mistakes_are_one_line(
    served: Served, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    assert served.run(*words) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("canwire: ")
    assert (captured.out, captured.err.count("\n")) == ("", 1)
    assert why in captured.err


def test_a_line_that_is_not_initialised(hub: Hub) -> None:
    status = hub.lin_status(hub.board("HW000001").id, 2).status
    assert mode_text(status) == "not initialised"


def test_what_a_late_hub_says_at_the_end_of_a_schedule_is_shown() -> None:
    """A busy machine: the hub is past the end only when it is asked, and its last message comes with that."""
    waiting: list[str] = []
    shown: list[str] = []

    class LateHub:
        def now_ns(self) -> int:
            waiting.append("the last one")
            return 10

    class Waiting:
        def receive(self, timeout: float | None) -> str | None:
            return waiting.pop() if waiting else None

    class Lines:
        def show(self, message: str) -> None:
            shown.append(message)

    schedule._follow(cast("Any", LateHub()), cast("Any", Lines()), cast("Any", Waiting()), 10)
    assert shown == ["the last one"]
