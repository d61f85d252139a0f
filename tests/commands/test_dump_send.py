"""`canwire dump` and `canwire send`: which line they mean, how they start it, what they print and count."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import pytest

from canwire import (
    BadTiming,
    BadValue,
    BitTiming,
    BoardInfo,
    BusEvent,
    CanwireError,
    ChannelMode,
    ErrorState,
    EventKind,
    Frame,
    Hub,
    HubChannel,
    InUse,
    LineMode,
    LineStatus,
    NoSuchBoard,
    WantedMode,
    connect,
    parse_log_line,
)
from canwire.boards import catalogue
from canwire.boards.config.configuration import Config
from canwire.commands import main
from canwire.commands import send as send_module
from canwire.commands.can_line import bring_up, line_mode, open_sender
from canwire.commands.dump import verb as dump_module
from canwire.commands.dump.filters import Capture
from canwire.commands.live.listening import Listening
from canwire.commands.send import Sending, format_text
from canwire.commands.shared_hub import find_line
from tests import warm
from tests.cases import each
from tests.hubs import serving

COUNTERS = dict.fromkeys(
    ("tec", "rec", "last_error", "frames_sent", "frames_received", "errors", "arbitration_losses", "refused",
     "lost", "channels", "time_ns"), 0
)  # fmt: skip
IDLE = LineStatus(
    initialised=False,
    running=False,
    mode=None,
    state=int(ErrorState.STOPPED),
    load=0.0,
    transmitting=False,
    coupling_fault=False,
    control_holder="",
    scheduler_holder="",
    exclusive=False,
    **COUNTERS,
)
MODE = LineMode(BitTiming.for_bit_rate(500_000), BitTiming.for_bit_rate(2_000_000), long_data=True)
RUNNING = replace(
    IDLE, initialised=True, running=True, mode=MODE, state=0, control_holder="engine (1)", set_by="engine (1)"
)
STOPPED = replace(IDLE, initialised=True, mode=MODE)
ANY = WantedMode(None, None)


class FakeControl:
    """Notes what is asked of it."""

    def __init__(self) -> None:
        self.done: list[object] = []

    def initialise(self, mode: LineMode) -> None:
        self.done.append(mode)

    def start(self) -> None:
        self.done.append("start")

    def __enter__(self) -> FakeControl:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self.done.append("close")


BOARDS = (
    catalogue.kind("usb-to-can-fd").info(1, "HW000001", ("can0", "can0", "lin0")),
    catalogue.kind("usb-to-can").info(2, "HW-2:b", ("body", "can0")),
    catalogue.kind("usb-to-can").info(3, "HW000003", ("can3", "can4")),
)


class FakeChannel(ExitStack):
    """Of a program that only sends."""

    def set_up(self, mode: ChannelMode) -> None:
        assert mode.transmit

    def activate(self) -> None:
        """It takes part."""


class FakeHub:
    """Two boards; `states` of their lines, one after the other where there are several."""

    def __init__(self) -> None:
        self.control = FakeControl()
        self.held = False
        self.time_s = 0.0
        self.states: dict[tuple[int, int], list[LineStatus]] = {}
        self.asked_for_boards = 0
        self.asked_for_status: list[tuple[int, int]] = []

    def clock_s(self) -> float:
        return self.time_s

    def sleep(self, seconds: float) -> None:
        self.time_s += seconds

    def boards(self) -> tuple[BoardInfo, ...]:
        self.asked_for_boards += 1
        return BOARDS

    def line_status(self, board: int, line: int) -> LineStatus:
        self.asked_for_status.append((board, line))
        states = self.states.get((board, line), [IDLE])
        return states.pop(0) if len(states) > 1 else states[0]

    def line_statuses(self, boards: Iterable[int]) -> dict[tuple[int, int], LineStatus]:
        lines = {
            board.id: [at for at, line in enumerate(board.lines) if line.lin is None] for board in BOARDS
        }
        return {(board, line): self.line_status(board, line) for board in boards for line in lines[board]}

    def open_control(self, board: int, line: int) -> FakeControl:
        if self.held:
            raise InUse(f"line {line}: its control is held by engine (1)")
        return self.control

    def open_channel(self, board: int, line: int) -> FakeChannel:
        return FakeChannel()

    @property
    def as_hub(self) -> Hub:
        return cast(Any, self)

    def place(self, name: str, *, to_send: bool = False) -> str:
        return find_line(self.as_hub, name, to_send=to_send).address

    def bring_up(self, rates: WantedMode = ANY, line: str = "HW000001:0") -> list[object]:
        bring_up(self.as_hub, find_line(self.as_hub, line), rates)
        return [done for done in self.control.done if done != "close"]


@pytest.fixture
def hub() -> FakeHub:
    return FakeHub()


@pytest.mark.parametrize(
    ("name", "address"),
    [
        ("HW000001:0", "HW000001:0"),
        ("HW000001:1", "HW000001:1"),
        ("usb-to-can-fd:1", "HW000001:1"),
        ("HW-2:b:1", "HW-2:b:1"),
        ("usb-to-can:0", "HW-2:b:0"),
        ("can0", "HW000001:0"),
        ("body", "HW-2:b:0"),
    ],
)
def test_names_of_lines(hub: FakeHub, name: str, address: str) -> None:
    assert hub.place(name) == address
    assert hub.place(name, to_send=True) == address


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("HW000001:3", "HW000001:3: HW000001 has the lines 0 to 2"),
        ("HW9:0", "no board 'HW9'; plugged in: HW000001 (usb-to-can-fd), HW-2:b (usb-to-can), HW000003"),
        (
            "can7",
            "no line or bus 'can7'; there are HW000001:0 (on can0), HW000001:1 (on can0), HW000001:2 (on lin0), "
            "HW-2:b:0 (on body), HW-2:b:1 (on can0), HW000003:0 (on can3), HW000003:1 (on can4)",
        ),
        ("HW000001", "no line or bus 'HW000001'; there are HW000001:0 (on can0)"),
        (":0", "no line or bus ':0'"),
        ("", "no line or bus ''"),
    ],
)
def test_names_of_no_lines(hub: FakeHub, name: str, why: str) -> None:
    with pytest.raises(NoSuchBoard, match=re.escape(why)):
        hub.place(name)


@pytest.mark.parametrize("name", ["lin0", "HW000001:2"])
def test_a_lin_line_is_for_other_verbs(hub: FakeHub, name: str) -> None:
    for to_send in (False, True):
        with pytest.raises(BadValue) as raised:
            hub.place(name, to_send=to_send)
        told = f"{name}: HW000001:2 is a LIN line; use `canwire lin dump` or `canwire lin send`"
        assert str(raised.value) == told


def test_a_bus_is_sent_to_from_a_line_that_nobody_configures(hub: FakeHub) -> None:
    hub.states[1, 0] = [RUNNING]
    assert hub.place("can0") == "HW000001:0"
    assert hub.place("can0", to_send=True) == "HW000001:1"
    hub.states[1, 1] = [RUNNING]
    assert hub.place("can0", to_send=True) == "HW-2:b:1"
    hub.states[2, 1] = [RUNNING]
    assert hub.place("can0", to_send=True) == "HW000001:0"


@pytest.mark.parametrize("name", ["can0", "HW000001:0"])
def test_the_boards_are_asked_for_once(hub: FakeHub, name: str) -> None:
    """By whoever finds a line, starts it, and looks whether others on its bus run at other rates."""
    with ExitStack() as closing:
        place, _ = open_sender(hub.as_hub, name, ANY, 16, closing)
    assert place.address == "HW000001:0"
    assert hub.control.done[1] == "start"
    assert hub.asked_for_boards == 1


def test_only_boards_of_the_same_bus_are_asked_for_their_rates(hub: FakeHub) -> None:
    hub.states[1, 0] = hub.states[2, 1] = [RUNNING]
    hub.bring_up()
    assert {board for board, _ in hub.asked_for_status} == {1, 2}


def test_a_new_line_is_set_up(hub: FakeHub) -> None:
    mode, start = hub.bring_up()
    assert start == "start"
    assert isinstance(mode, LineMode)
    assert mode.timing is not None
    assert mode.data_timing is not None
    assert (mode.timing.bit_rate, mode.data_timing.bit_rate) == (500_000, 2_000_000)
    assert mode.long_data
    assert mode.error_frames
    assert hub.control.done[2:] == ["close"]


def test_a_running_line_is_left_alone(hub: FakeHub) -> None:
    hub.states[1, 0] = [RUNNING]
    for rates in (ANY, WantedMode(500_000, None), WantedMode(500_000, 2_000_000)):
        assert hub.bring_up(rates) == []


@pytest.mark.parametrize(
    ("rates", "asked"),
    [
        (WantedMode(250_000, None), "250000 bit/s"),
        (WantedMode(None, 4_000_000), "500000 bit/s, 4000000 after BRS"),
    ],
)
def test_whoever_comes_second_must_agree(hub: FakeHub, rates: WantedMode, asked: str) -> None:
    hub.states[1, 0] = [RUNNING]
    with pytest.raises(BadValue) as raised:
        hub.bring_up(rates)
    assert str(raised.value) == (
        f"HW000001:0 runs at 500000 bit/s, 2000000 after BRS, set by engine (1), not at {asked}; "
        "leave --bit-rate and --data-bit-rate out"
    )


def test_a_line_that_somebody_set_up_and_left_is_started_as_it_is(hub: FakeHub) -> None:
    hub.states[1, 0] = [STOPPED]
    assert hub.bring_up() == ["start"]


def test_a_line_that_somebody_set_up_and_left_can_get_other_rates(hub: FakeHub) -> None:
    hub.states[1, 0] = [STOPPED]
    mode, start = hub.bring_up(WantedMode(250_000, None))
    assert isinstance(mode, LineMode)
    assert mode.timing is not None
    assert (mode.timing.bit_rate, start) == (250_000, "start")


def test_a_line_in_somebody_elses_hands_is_not_ours_to_start(hub: FakeHub) -> None:
    hub.held = True
    with pytest.raises(InUse, match="held by engine"):
        hub.bring_up()


def test_somebody_else_was_quicker(hub: FakeHub) -> None:
    hub.held = True
    hub.states[1, 0] = [IDLE, RUNNING]
    assert hub.bring_up() == []


def test_somebody_else_is_just_starting_it(hub: FakeHub) -> None:
    """As `gen` and `dump` do that are begun together, and mean the same line."""
    hub.held = True
    hub.states[1, 0] = [IDLE] * 20 + [RUNNING]
    assert hub.bring_up() == []
    assert 0 < hub.time_s < 2


@each("bit_rate", [5_000, 10_000, 125_000, 250_000, 500_000, 800_000, 1_000_000])
@each("kind", ["usb-to-can-fd", "usb-to-can"])
def test_usual_rates_fit_every_board(kind: str, bit_rate: int) -> None:
    capabilities = catalogue.kind(kind).connectors[0].capabilities
    mode = line_mode(capabilities, WantedMode(bit_rate, None))
    timing, registers = mode.timing, capabilities.nominal
    assert timing is not None
    assert (timing.bit_rate, timing.clock_hz) == (bit_rate, capabilities.clock_hz)
    for value, (low, high) in (
        (timing.prescaler, registers.prescaler),
        (timing.tseg1, registers.tseg1),
        (timing.tseg2, registers.tseg2),
        (timing.sjw, registers.sjw),
    ):
        assert low <= value <= high
    assert (mode.data_timing is not None) == mode.long_data == (kind == "usb-to-can-fd")


@each(
    ("kind", "rates", "error", "why"),
    [
        (
            "usb-to-can",
            WantedMode(None, 2_000_000),
            BadValue,
            "--data-bit-rate 2000000: this line knows classic CAN only",
        ),
        ("usb-to-can", WantedMode(499_999, None), BadTiming, "499999 bit/s cannot be made from 36000000 Hz"),
        (
            "usb-to-can-fd",
            WantedMode(500_000, 17_000_000),
            BadTiming,
            "17000000 bit/s cannot be made from 80000000 Hz",
        ),
        ("usb-to-can-fd", WantedMode(-1, None), BadTiming, "bit_rate -1: a whole number above 0"),
    ],
)
def test_rates_that_a_board_cannot_make(
    kind: str, rates: WantedMode, error: type[CanwireError], why: str
) -> None:
    with pytest.raises(error, match=re.escape(why)):
        line_mode(catalogue.kind(kind).connectors[0].capabilities, rates)


@each(
    ("mode", "text"),
    [
        (MODE, "CAN FD with 11-bit and 29-bit identifiers"),
        (replace(MODE, long_data=False), "CAN FD of up to 8 bytes with 11-bit and 29-bit identifiers"),
        (replace(MODE, data_timing=None), "CAN FD without BRS with 11-bit and 29-bit identifiers"),
        (
            replace(MODE, data_timing=None, long_data=False, extended=False),
            "classic CAN with 11-bit identifiers",
        ),
        (None, "nothing"),
    ],
)
def test_what_a_line_can_send(mode: LineMode | None, text: str) -> None:
    assert format_text(replace(RUNNING, mode=mode)) == text


# with a real hub


class Served:
    """A hub behind a socket; `run` is the command line on it."""

    def __init__(self, address: str) -> None:
        self.address = address

    def run(self, *words: str) -> int:
        return main([*words, "--hub", self.address])


class Dump:
    """`canwire dump` in a process of its own, listening."""

    def __init__(self, hub: Served, *words: str) -> None:
        self.process = warm.Popen(
            [sys.executable, "-m", "canwire", "dump", *words, "--hub", hub.address],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stderr is not None
        self.told = self.process.stderr.readline().removeprefix("canwire: ").rstrip()

    def line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().rstrip()

    def end(self) -> tuple[int, list[str], str]:
        """Exit status, the lines left, and what it said at the end."""
        out, err = self.process.communicate(timeout=30)
        return (
            self.process.returncode,
            [line.rstrip() for line in out.splitlines()],
            err.removeprefix("canwire: ").rstrip(),
        )

    def kill(self) -> None:
        self.process.kill()
        self.process.communicate(timeout=30)


@pytest.fixture
def served(hub_address: str) -> Served:
    return Served(hub_address)


@pytest.fixture
def dump(served: Served) -> Iterator[Callable[..., Dump]]:
    dumps: list[Dump] = []

    def start(*words: str) -> Dump:
        dumps.append(Dump(served, *words))
        return dumps[-1]

    yield start
    for one in dumps:
        one.kill()


StartDump = Callable[..., Dump]


@pytest.mark.conforms("G-19")
def test_one_process_sends_two_others_see_it(served: Served, dump: StartDump) -> None:
    first, second = dump("can0", "-n", "3"), dump("HW000002:0", "-n", "4", "-i")
    assert first.told == "HW000001:0 on can0: 500000 bit/s, 2000000 after BRS; listening"
    assert second.told == "HW000002:0 on can0: 500000 bit/s; listening"
    assert served.run("send", "can0", "123#1122", "12345678#R") == 0
    assert served.run("send", "HW000002:1", "7FF#") == 0
    seen = ["123   [2]  11 22", "12345678   [0]  remote request", "7FF   [0]"]
    assert first.end() == (0, [f"  can0  {text}" for text in seen], "3 shown, 0 lost")
    assert served.run("send", "HW000002:1", "700#") == 0  # the others go on without the first
    seen.append("700   [0]")
    assert second.end() == (0, [f"  can0  {text}" for text in seen], "4 shown, 0 lost")


@pytest.mark.conforms("G-19")
def test_python_can_reads_the_log(served: Served, dump: StartDump) -> None:
    """A program that knows nothing of canwire reads what comes out of the pipe."""
    pytest.importorskip("can")
    reader = (
        "import can, sys\n"
        "for m in can.CanutilsLogReader(sys.stdin):\n"
        "    print(m.channel, hex(m.arbitration_id), m.is_extended_id, m.is_remote_frame, m.is_fd,"
        " m.bitrate_switch, m.data.hex(), m.timestamp > 1e9)\n"
    )
    writing = dump("can0", "-l", "-n", "4")
    reading = warm.Popen(
        [sys.executable, "-c", reader], stdin=writing.process.stdout, stdout=subprocess.PIPE, text=True
    )
    assert served.run("send", "can0", "123#1122", "12345678#R", "7FF#", "123##1AABB") == 0
    out, _ = reading.communicate(timeout=30)
    assert out.splitlines() == [
        "can0 0x123 False False False False 1122 True",
        "can0 0x12345678 True True False False  True",
        "can0 0x7ff False False False False  True",
        "can0 0x123 False False True True aabb True",
    ]


def test_a_line_shows_what_it_sends_itself(served: Served, dump: StartDump) -> None:
    own, _ = dump("HW000001:0", "-n", "1"), dump("HW000001:1")
    assert served.run("send", "HW000001:0", "123#") == 0
    assert own.end() == (0, ["  HW000001:0  123   [0]"], "1 shown, 0 lost")


def test_errors_are_shown_when_asked_for(served: Served, dump: StartDump) -> None:
    plain, full = dump("can0"), dump("can0", "-e", "-n", "1", "-l")
    assert served.run("send", "can0", "123#", "--bit-rate", "250000", "--timeout", "0.05") == 1
    status, [line], _ = full.end()
    event = parse_log_line(line).content
    assert status == 0
    assert isinstance(event, BusEvent)
    assert event.kind == EventKind.ERROR
    plain.process.send_signal(signal.SIGINT)
    status, lines, told = plain.end()
    assert (status, lines) == (130, [])
    assert re.fullmatch(r"0 shown, 0 lost, \d+ errors? seen", told)


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_the_end_has_the_numbers(served: Served, dump: StartDump, end: signal.Signals) -> None:
    listening = dump("can0")
    assert served.run("send", "can0", "123#", "-n", "5") == 0
    lines = [listening.line() for _ in range(5)]
    listening.process.send_signal(end)
    assert lines == ["  can0  123   [0]"] * 5
    assert listening.end() == (128 + end, [], "5 shown, 0 lost")


def test_silence_ends_it(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    assert served.run("dump", "can0", "-T", "0.01") == 0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines()[-1] == "canwire: 0 shown, 0 lost"


@pytest.mark.conforms("X3-02")
def test_a_pulled_board_ends_it(served: Served, dump: StartDump, capsys: pytest.CaptureFixture[str]) -> None:
    listening = dump("HW000001:1")
    assert served.run("unplug", "HW000001") == 0
    status, lines, told = listening.end()
    assert (status, lines) == (2, [])
    assert told.startswith("0 shown, lost unknown: board HW000001 (usb-to-can-fd) was unplugged")
    assert capsys.readouterr().out == "HW000001  usb-to-can-fd  USB-to-CAN FD (simulated)  can0 can0 lin0\n"


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
def test_the_hubs_end_ends_it(tmp_path: Path, end: signal.Signals) -> None:
    with serving(tmp_path, time="real") as (address, hub):
        listening = Dump(Served(address), "can0", "--no-reconnect")
        hub.send_signal(end)
        status, lines, told = listening.end()
    assert (status, lines) == (2, [])
    assert told.startswith("0 shown, lost unknown: ")
    assert "the hub is gone" in told


def test_more_frames_than_the_queue_holds(served: Served, dump: StartDump) -> None:
    listening = dump("can0", "-n", "1000")
    assert served.run("send", "can0", *(f"{id:03X}#" for id in range(500)), "-n", "2") == 0
    status, lines, told = listening.end()
    assert (status, told) == (0, "1000 shown, 0 lost")
    assert [line.split()[1] for line in lines] == [f"{id:03X}" for id in range(500)] * 2


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (
            ("can0", "123#", "124#"),
            "HW000001:0: 2 of 2 frames not delivered: nobody acknowledges; no other controller runs on can0 "
            "(error passive, TEC 128)",
        ),
        (
            ("usb-to-can:1", "123##0", "123#"),
            "HW000002:1: 2 of 2 frames not delivered: the line cannot send them, it is set up for classic CAN "
            "with 11-bit and 29-bit identifiers",
        ),
    ],
)
def test_what_is_not_delivered_is_told(
    served: Served, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    assert served.run("send", *words, "--timeout", "0.1") == 1
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", f"canwire: {why}\n")


@pytest.mark.conforms("PL-13")
def test_what_other_programs_do_with_a_line_is_told(
    served: Served, capsys: pytest.CaptureFixture[str]
) -> None:
    with connect(served.address, name="owner") as other:
        control = other.open_control(other.board("HW000001").id, 0)
        assert served.run("send", "HW000001:0", "123#") == 2
        assert "held by owner" in capsys.readouterr().err
        control.initialise(replace(MODE, listen_only=True))
        control.start()
        assert served.run("send", "HW000001:0", "123#", "--timeout", "0.05") == 1
        assert capsys.readouterr().err.endswith("1 of 1 frames not delivered: the line only listens\n")
        assert served.run("dump", "HW000001:0", "--bit-rate", "250000", "-T", "0") == 2
        assert "runs at 500000 bit/s, 2000000 after BRS, set by owner" in capsys.readouterr().err
        control.stop()
        assert served.run("dump", "HW000001:0", "-T", "0") == 0
        assert "does not run yet" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("dump", "can7"), "no CAN line or bus 'can7'"),
        (("dump", "can0", "-n", "0"), "-n 0: 1 or more"),
        (("dump", "can0", "-T", "nan"), "-T nan: seconds from 0 up"),
        (("dump", "can0", "-T", "-1"), "-T -1.0: seconds from 0 up"),
        (("dump", "can0", "--bit-rate", "7"), "7 bit/s cannot be made"),
        (("send", "can0", "123"), "'123' has no #"),
        (("send", "can0", "20000080#0000000000000000"), "is an error frame"),
        (("send", "can0", "123#", "-n", "0"), "--count 0: 1 or more"),
        (("send", "can0", "123#", "--gap", "-1"), "--gap -1.0: 0 or more"),
        (("send", "usb-to-can:0", "123#", "--data-bit-rate", "2000000"), "classic CAN only"),
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


@pytest.mark.parametrize("words", [("dump", "can0"), ("send", "can0", "123#"), ("plug", "usb-to-can")])
def test_without_a_hub_there_is_nobody_to_share_with(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    assert main([*words]) == 2
    assert capsys.readouterr().err == (
        f"canwire: no hub is running that `{words[0]}` could share; `canwire serve` starts one\n"
    )


# in virtual time, where nothing happens while nobody waits


@pytest.fixture
def virtual() -> Iterator[Hub]:
    with connect(time="virtual", config=Config.default()) as hub:
        yield hub


def channel_on(hub: Hub, address: str, closing: ExitStack, mode: ChannelMode) -> tuple[HubChannel, Any]:
    place = find_line(hub, address)
    channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
    channel.set_up(mode)
    bring_up(hub, place, ANY)
    channel.activate()
    return channel, place


@pytest.mark.conforms("PL-17")
def test_frames_that_dump_did_not_read_in_time_are_counted(
    virtual: Hub, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = Namespace(
        log=False, count=4, timeout=None, seconds=None, stamps=None, json=False, db=None, pcapng=None, ascii=False,
        extra=False, raw_dlc=False, colour=0, swap=False, silent=0, room=None,
    )  # fmt: skip
    with ExitStack() as closing:
        place = find_line(virtual, "HW000001:0")
        listening = closing.enter_context(Listening(virtual, [("can0", place)], ANY, queue=4))
        sending, _ = channel_on(virtual, "HW000001:1", closing, ChannelMode(receive=1, transmit=16))
        for id in range(10):
            sending.send(Frame(id))
        virtual.run_for(0.1)
        showing = dump_module.Dump(arguments, virtual, listening, Capture())
        showing.run()
        assert showing.summary() == ["4 shown, 6 lost"]
    assert capsys.readouterr().out.count("\n") == 4


def test_sending_in_virtual_time_takes_none(virtual: Hub) -> None:
    with ExitStack() as closing:
        receiving, _ = channel_on(virtual, "HW000001:0", closing, ChannelMode(receive=16, transmit=0))
        channel, place = channel_on(virtual, "HW000001:1", closing, ChannelMode(receive=1, transmit=16))
        sending = Sending(virtual, place, channel, timeout_s=1.0)
        sending.send([Frame(1), Frame(2)], count=2, gap_s=100.0)
        assert sending.result() == 0
        frames = receiving.receive_many(16)
    assert [frame.id for frame in frames] == [1, 2, 1, 2]
    gaps_ns = [after.timestamp_ns - before.timestamp_ns for before, after in pairwise(frames)]
    assert (
        gaps_ns == [100_000_000_000 - 22_000] + [100_000_000_000] * 2
    )  # the line joined the bus first: 11 bits


def test_gaps_are_counted_from_the_first_frame(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    """However long a frame takes to be queued, the next one is due at its own time."""
    pauses: list[float] = []
    clock = Namespace(monotonic=lambda: 100.0, sleep=pauses.append)
    monkeypatch.setattr(send_module, "time", clock)
    with connect(served.address) as hub, ExitStack() as closing:
        channel_on(hub, "HW000001:0", closing, ChannelMode(receive=1, transmit=0))
        channel, place = channel_on(hub, "HW000001:1", closing, ChannelMode(receive=1, transmit=16))
        sending = Sending(hub, place, channel, timeout_s=1.0)
        sending.send([Frame(1)], count=4, gap_s=0.5)
        assert pauses == [0.5, 1.0, 1.5]
        assert sending.result() == 0


def test_a_full_queue_that_does_not_move_ends_sending(
    virtual: Hub, capsys: pytest.CaptureFixture[str]
) -> None:
    with ExitStack() as closing:
        channel, place = channel_on(virtual, "HW000001:1", closing, ChannelMode(receive=1, transmit=4))
        sending = Sending(virtual, place, channel, timeout_s=0.5)
        sending.send([Frame(1)], count=100, gap_s=0.0)
        assert sending.result() == 1
        assert channel.status().pending == 0
    assert "100 of 100 frames not delivered: nobody acknowledges" in capsys.readouterr().err
