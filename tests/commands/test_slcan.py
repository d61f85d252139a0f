"""`canwire slcan` in a process of its own, with clients as they are: pyserial, and python-can's `slcan` in others."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import serial

from canwire import BitTiming, ChannelMode, Frame, HubChannel, LineMode, connect
from canwire.commands import main
from canwire.slcan.dialects import CANABLE
from tests import warm

PATIENCE_S = 60.0
pytestmark = pytest.mark.realtime


class Command:
    """`canwire slcan` with these words on a hub; `places` are where its dongles are."""

    def __init__(self, hub: str, home: Path, *words: str, dongles: int = 1) -> None:
        environment = {**os.environ, "XDG_STATE_HOME": str(home)}
        self.process = warm.Popen(
            [sys.executable, "-m", "canwire", "slcan", *words, *(("--hub", hub) if hub else ())],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        assert self.process.stdout is not None
        self.told = [self.process.stdout.readline().rstrip() for _ in range(dongles)]
        self.places = [line.rpartition(" at ")[2] for line in self.told]

    def end(self, number: int = signal.SIGTERM) -> int:
        self.process.send_signal(number)
        return self.process.wait(PATIENCE_S)


@pytest.fixture
def home(tmp_path: Path) -> Path:
    return tmp_path


@pytest.fixture
def served(hub_address: str, home: Path) -> Iterator[Command]:
    command = Command(hub_address, home, "--pty", str(home / "tty"), "--tcp", "127.0.0.1:0", dongles=2)
    yield command
    if command.process.poll() is None:
        command.end()
    command.process.communicate()


@pytest.fixture
def node(hub_address: str) -> Iterator[HubChannel]:
    """A board's own line on can0 at 125 kbit/s."""
    with node_at(hub_address, 125_000) as channel:
        yield channel


@contextmanager
def node_at(hub_address: str, bit_rate: int) -> Iterator[HubChannel]:
    with connect(hub_address) as hub:
        board = hub.board("usb-to-can-fd").id
        control = hub.open_control(board, 0)
        control.initialise(LineMode(BitTiming.for_bit_rate(bit_rate)))
        control.start()
        channel = hub.open_channel(board, 0)
        channel.set_up(ChannelMode(4096, 4096))
        channel.activate()
        yield channel


def python_can(code: str, *arguments: str) -> subprocess.Popen[str]:
    """A program with python-can in a process of its own, as it stands."""
    quiet = "import warnings; warnings.simplefilter('ignore')"
    return warm.Popen(
        [sys.executable, "-c", f"{quiet}\n{textwrap.dedent(code)}", *arguments],
        stdout=subprocess.PIPE,
        text=True,
    )


ECHO = """
    import sys, can
    with can.Bus(interface="slcan", channel=sys.argv[1], bitrate=125_000, sleep_after_open=0.2) as bus:
        print(*bus.get_version(20), bus.get_serial_number(20), flush=True)
        bus.send(can.Message(arbitration_id=0x100, data=[1, 2], is_extended_id=False))
        bus.send(can.Message(arbitration_id=0x101, data=[3], is_extended_id=True))
        bus.send(can.Message(arbitration_id=0x102, dlc=4, is_remote_frame=True, is_extended_id=False))
        got = []
        while len(got) < 3 and (message := bus.recv(20)) is not None:
            got.append(message)
    for m in got:
        print(f"{m.arbitration_id:X} {m.is_extended_id:d} {m.is_remote_frame:d} {m.dlc} {m.data.hex()}")
"""


@pytest.mark.conforms("CT-01", "CT-02", "CT-09", "CT-14", "CT-17", "CT-21")
@pytest.mark.parametrize("place", [0, 1])
def test_python_can_s_own_slcan(served: Command, node: HubChannel, place: int) -> None:
    program = python_can(ECHO, served.places[place])
    assert program.stdout is not None
    assert program.stdout.readline() == f"10 13 A12{3 + place}\n"
    sent = [node.receive(PATIENCE_S) for _ in range(3)]
    assert sent == [
        Frame(0x100, b"\x01\x02"), Frame(0x101, b"\x03", extended=True), Frame(0x102, remote=True, dlc=4),
    ]  # fmt: skip
    for frame in (Frame(0x7FF, bytes(8)), Frame(5, b"\x11", extended=True), Frame(6, remote=True, dlc=2)):
        node.send(frame)
    assert program.communicate(timeout=PATIENCE_S)[0].splitlines() == [
        "7FF 0 0 8 0000000000000000", "5 1 0 1 11", "6 0 1 2 ",
    ]  # fmt: skip
    assert program.returncode == 0


COUNT = """
    import sys, can
    with can.Bus(interface="slcan", channel=sys.argv[1], bitrate=125_000, sleep_after_open=0.2) as bus:
        bus.get_version(20)
        print("ready", flush=True)
        ids = []
        while len(ids) < 1000 and (message := bus.recv(20)) is not None:
            ids.append((message.arbitration_id, int.from_bytes(message.data)))
    print(ids == [(k & 0x7FF, k) for k in range(1000)])
"""


@pytest.mark.conforms("CT-20", "CT-23")
@pytest.mark.parametrize("place", [0, 1])
def test_a_thousand_frames_to_python_can(served: Command, node: HubChannel, place: int) -> None:
    program = python_can(COUNT, served.places[place])
    assert program.stdout is not None
    assert program.stdout.readline() == "ready\n"
    for k in range(1000):
        node.send(Frame(k & 0x7FF, k.to_bytes(8)), timeout=PATIENCE_S)
    assert program.communicate(timeout=PATIENCE_S)[0] == "True\n"


@pytest.mark.conforms("CT-20", "CT-01", "CT-18")
def test_a_thousand_frames_from_a_terminal(served: Command, node: HubChannel) -> None:
    """As section 1.4 asks: the next command after the reply, a refused one again."""
    with serial.Serial(served.places[0], timeout=PATIENCE_S) as port:
        port.write(b"\r\r\rV\rS4\rO\r")
        assert port.read(11) == b"\r\r\rV1013\r\r\r"
        began = time.monotonic()
        for k in range(1000):
            while True:
                port.write(b"t%03X8%016X\r" % (k, k))
                if port.read(1) == b"z":
                    assert port.read(1) == b"\r"
                    break
                time.sleep(0.001)
        assert time.monotonic() - began > 0.8  # as many bits as that have to be sent
        frames = [node.receive(PATIENCE_S) for _ in range(1000)]
        assert frames == [Frame(k, k.to_bytes(8)) for k in range(1000)]
        port.write(b"C\r")
        assert port.read(1) == b"\r"


def test_what_it_says_and_leaves(hub_address: str, home: Path) -> None:
    command = Command(hub_address, home, "--serial-number", "B009", "--version", "V1011", "--tx-reply", "cr")
    link = home / "canwire" / "ttyCANBUS0"
    assert command.told[0].startswith("canwire: canbus dongle B009 (HW")
    assert command.told[0].endswith(f" on can0) at {link}")
    other = Command(hub_address, home)
    assert other.places == [str(home / "canwire" / "ttyCANBUS1")]
    with connect(hub_address) as hub, serial.Serial(str(link), timeout=PATIENCE_S) as port:
        boards = len(hub.boards())
        port.write(b"Z1\rV\rN\r")
        assert port.read(13) == b"\rV1011\rNB009\r"
        assert command.end() == other.end(signal.SIGINT) == 0
        assert len(hub.boards()) == boards - 2
    assert not link.is_symlink()
    assert (home / "canwire" / "B009.eeprom").read_text() == "Z1\n"
    for one in (command, other):
        one.process.communicate()


def test_without_a_hub_it_has_its_own(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(home))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    command = Command(
        "", home, "--pty", str(home / "tty"), "--pty", str(home / "tta"), "--verbose", dongles=2
    )
    with serial.Serial(command.places[0], timeout=PATIENCE_S) as a, serial.Serial(command.places[1]) as b:
        for port in (a, b):
            port.timeout = PATIENCE_S
            port.write(b"S8\rO\r")
            assert port.read(2) == b"\r\r"
        a.write(b"t10021133\r")
        assert a.read(2) == b"z\r"
        assert b.read(10) == b"t10021133\r"
    assert command.end() == 0
    told = command.process.communicate()[1]
    assert "A123 (" in told
    assert ": open at 1000000 bit/s" in told


def test_canable(hub_address: str, home: Path) -> None:
    command = Command(hub_address, home, "--dialect", "canable", "--pty", str(home / "tty"))
    with serial.Serial(command.places[0], timeout=PATIENCE_S) as port:
        port.write(b"\r\rS6\rO\rN\rV\r")
        assert port.read_until(b"2\r") == b"canwire canable2\r"
    assert command.end() == 0
    command.process.communicate()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--serial-number", "12345"), "serial number '12345': four letters or digits"),
        (("--version", "1013"), "version '1013': V and four digits"),
        (("--bus", "can7"), "no bus 'can7'"),
        (("--tcp", "here"), "'here': HOST:PORT"),
        (("--serial", "/dev/null/none"), "/dev/null/none"),
    ],
)
def test_mistakes(
    hub_address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], why: str
) -> None:
    link = () if words[0] in ("--tcp", "--serial") else ("--pty", str(tmp_path / "tty"))
    with connect(hub_address) as hub:
        before = hub.boards()
        assert main(["slcan", *link, *words, "--hub", hub_address]) == 2
        assert why in capsys.readouterr().err
        assert hub.boards() == before


def test_the_board_is_pulled_out(served: Command, hub_address: str) -> None:
    with connect(hub_address) as hub:
        for line in served.told:
            hub.unplug(line.partition("(")[2].partition(" ")[0])
    assert served.process.wait(PATIENCE_S) == 0
    assert served.process.stderr is not None
    assert served.process.stderr.read().count("was unplugged") == 2


def test_the_hub_goes(home: Path) -> None:
    address = str(home / "hub.sock")
    hub = warm.Popen(
        [sys.executable, "-m", "canwire", "serve", "--socket", address], stdout=subprocess.PIPE, text=True
    )
    assert hub.stdout is not None
    hub.stdout.readline()
    command = Command(address, home, "--pty", str(home / "tty"))
    with serial.Serial(command.places[0], timeout=PATIENCE_S) as port:
        port.write(b"S4\rO\r")
        assert port.read(2) == b"\r\r"
        hub.terminate()
        hub.communicate()
        assert command.process.wait(PATIENCE_S) == 2
    told = command.process.communicate()[1]
    assert told.startswith("canwire: ")
    assert told.count("\n") == 1
    assert not (home / "tty").is_symlink()


FD = """
    import sys, can
    timing = can.BitTimingFd.from_sample_point(
        f_clock=80_000_000, nom_bitrate=500_000, nom_sample_point=80, data_bitrate=2_000_000, data_sample_point=80)
    with can.Bus(interface="slcan", channel=sys.argv[1], timing=timing, sleep_after_open=0.2) as bus:
        bus.send(can.Message(
            arbitration_id=0x100, data=bytes(12), is_fd=True, bitrate_switch=True, is_extended_id=False))
        bus.send(can.Message(arbitration_id=0x101, data=bytes(64), is_fd=True))
        message = bus.recv(20)
        print(message.is_fd, message.bitrate_switch, message.dlc, message.data.hex())
"""


def test_python_can_speaks_fd_to_a_canable(hub_address: str, home: Path) -> None:
    command = Command(hub_address, home, "--dialect", "canable", "--pty", str(home / "tty"))
    with connect(hub_address) as hub:
        board = hub.board("usb-to-can-fd").id
        control = hub.open_control(board, 0)
        timing, data = (
            CANABLE.rates[b"6"],
            CANABLE.data_rates[b"2"],
        )  # others' sample points would not do, as on copper
        control.initialise(LineMode(timing, data, long_data=True))
        control.start()
        channel = hub.open_channel(board, 0)
        channel.set_up(ChannelMode(16, 16))
        channel.activate()
        program = python_can(FD, command.places[0])
        assert channel.receive(PATIENCE_S) == Frame(0x100, bytes(12), fd=True, bit_rate_switch=True)
        assert channel.receive(PATIENCE_S) == Frame(0x101, bytes(64), fd=True, extended=True)
        channel.send(Frame(0x200, bytes(range(16)), fd=True, bit_rate_switch=True))
        assert program.communicate(timeout=PATIENCE_S)[0] == f"True True 16 {bytes(range(16)).hex()}\n"
    assert command.end() == 0
    command.process.communicate()


@pytest.mark.finding("linux 4")
def test_a_killed_one_leaves_no_board_behind(hub_address: str, home: Path) -> None:
    with connect(hub_address) as hub:
        before = [board.hardware_id for board in hub.boards()]
        command = Command(hub_address, home, "--pty", str(home / "tty"))
        assert len(hub.boards()) == len(before) + 1
        assert command.end(signal.SIGKILL) != 0
        deadline = time.monotonic() + PATIENCE_S
        while len(hub.boards()) > len(before) and time.monotonic() < deadline:
            time.sleep(0.01)
        assert [board.hardware_id for board in hub.boards()] == before
    command.process.communicate()


def refused_and_sent(command: Command, count: int, rate: bytes = b"S4") -> tuple[int, int]:
    """BELLs and z's for so many frames in one write, with somebody there who acknowledges."""
    with serial.Serial(command.places[0], timeout=PATIENCE_S) as port:
        port.write(b"\r\r" + rate + b"\rO\r")
        assert port.read(4) == b"\r" * 4
        port.write(b"".join(b"t%03X0\r" % k for k in range(count)))
        replies = b""
        while replies.count(b"z") + replies.count(b"\a") < count:
            replies += port.read(1)
    return replies.count(b"\a"), replies.count(b"z")


@pytest.mark.finding("linux 2")
def test_what_is_refused_is_counted_where_people_look(
    hub_address: str, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = Command(hub_address, home, "--pty", str(home / "tty"), "--verbose")
    with node_at(hub_address, 10_000) as node:  # 4.7 ms a frame: a busy machine's adapter is quicker, too
        refused, sent = refused_and_sent(command, 300, b"S0")
        assert refused > 0
        assert main(["devices", "--hub", hub_address]) == 0
        assert f"refused {refused}" in capsys.readouterr().out
        assert all(node.receive(PATIENCE_S) for _ in range(sent))
        assert command.end() == 0
    said = command.process.communicate()[1]
    assert "frames are refused (BELL): 8 wait already" in said
    assert f"sent {sent}, refused {refused}" in said


@pytest.mark.finding("linux 2")
@pytest.mark.usefixtures("node")
def test_at_a_serial_lines_pace_nothing_is_refused(hub_address: str, home: Path) -> None:
    """Six characters take 6.25 ms at 9600 baud, their frame less than half a millisecond on the bus."""
    command = Command(hub_address, home, "--pty", str(home / "tty"), "--pace", "9600")
    began = time.monotonic()
    assert refused_and_sent(command, 60) == (0, 60)
    assert time.monotonic() - began > 60 * 6 * 10 / 9600 * 0.8
    assert command.end() == 0
    assert command.process.communicate()[1] == ""


def test_a_home_that_takes_no_files(
    hub_address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    assert main(["slcan", "--hub", hub_address]) == 2
    shown = capsys.readouterr().err
    assert (
        "Not a directory, so the terminal's link cannot be made there; name another place by --pty PATH"
        in shown
    )
