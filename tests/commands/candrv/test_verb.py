"""`canwire candrv`: CanTestSuite against `canwire serve`, the registry's commands, a device as a pseudo terminal."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import candrv, connect
from canwire.candrv.constants import CanbusEvent
from canwire.candrv.event_queue import Event
from canwire.commands import main
from canwire.commands.candrv import attach as candrv_attach
from canwire.commands.candrv.programs import Written, shown
from canwire.commands.candrv.suite import PROGRAMS
from canwire.commands.candrv.switches import Usage, parse
from tests import warm
from tests.cases import each

LONG = 60.0  # seconds after which something that should happen never will
CONFIG = """
[[bus]]
name = "can0"

[[board]]
kind = "netdcu"
serial = "HW000001"

[[board]]
kind = "netdcu"
serial = "HW000002"
"""
REGISTRY = """
[candrv.CID1]
Board = "HW000001"

[candrv.CID2]
Board = "HW000002"
AcceptanceMask = 0xFFFFFFFF
EventQueueSize = 20000
"""
USAGE = """\
{name}
  -d <dev> : Device name (CID1:)
  -b <baud>: Set baudrate
  -f <name>: Log file name
"""


class Bench:
    """Two boards on a bus in a hub of its own: CID1: and CID2:. Everything ends with the bench."""

    def __init__(self, home: Path, closing: ExitStack, kind: str = "netdcu") -> None:
        self.home = home
        self._closing = closing
        (home / "hub.toml").write_text(CONFIG.replace("netdcu", kind))
        (home / "registry.toml").write_text(REGISTRY)
        self.address = str(home / "hub.sock")
        self.hub = self.start("serve", "--socket", self.address, "--config", "hub.toml")
        assert self.line(self.hub).startswith("canwire hub on")

    def start(self, *words: str) -> subprocess.Popen[str]:
        """`canwire` with these words."""
        environment = {
            **os.environ,
            "PYTHONPATH": str(Path(canwire.__file__).parent.parent),
            "CANWIRE_HUB": self.address,
            "CANWIRE_CONFIG": str(self.home / "registry.toml"),
        }
        process = warm.Popen(
            [sys.executable, "-m", "canwire", *words],
            cwd=self.home,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._closing.callback(_end, process)
        return process

    def run(self, *words: str) -> tuple[int, str, str]:
        """Until its end: exit status, stdout, stderr."""
        process = self.start("candrv", *words)
        out, err = process.communicate(timeout=LONG)
        return process.returncode, out, err

    def line(self, process: subprocess.Popen[str]) -> str:
        """The next one on its stdout."""
        assert process.stdout is not None
        return process.stdout.readline()

    def until(self, process: subprocess.Popen[str], text: str) -> list[str]:
        """Lines of stdout, up to one that begins with the text."""
        lines = [self.line(process)]
        while lines[-1] and not lines[-1].startswith(text):
            lines.append(self.line(process))
        assert lines[-1], process.stderr.read() if process.stderr else ""
        return lines

    def device(self, name: str = "CID2:", *, everything: bool = True, **access: Any) -> candrv.Handle:
        """Opened by the test itself."""
        os.environ["CANWIRE_CONFIG"] = str(self.home / "registry.toml")
        hub = self._closing.enter_context(connect(self.address))
        handle = self._closing.enter_context(candrv.open(name, hub=hub, **access))
        if everything and handle.readable:
            handle.accept_all()
            timeouts = handle.timeouts
            timeouts.ReadTotalTimeoutConstant = round(LONG * 1000)
            handle.timeouts = timeouts
        return handle

    def interrupt(self, process: subprocess.Popen[str], number: int = signal.SIGINT) -> tuple[int, str, str]:
        """Exit status and what was still to read."""
        process.send_signal(number)
        out, err = process.communicate(timeout=LONG)
        return process.returncode, out, err


def _end(process: subprocess.Popen[str]) -> None:
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(LONG)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait(LONG)
    for stream in (process.stdout, process.stderr):
        if stream is not None:
            stream.close()


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("CANWIRE_CONFIG", "")  # put back at the end
    with ExitStack() as closing:
        yield Bench(tmp_path, closing)


def received(handle: candrv.Handle, count: int) -> list[Event]:
    """The next so many messages, other events left out."""
    found: list[Event] = []
    while len(found) < count:
        event = handle.read_event()
        if event.event == CanbusEvent.RECEIVED:
            found.append(event)
    return found


def collected(handle: candrv.Handle, count: int) -> Callable[[], list[Event]]:
    """Reads them in a thread, so that the event queue does not overflow; call it for the messages."""
    found: list[Event] = []
    thread = threading.Thread(target=lambda: found.extend(received(handle, count)), daemon=True)
    thread.start()

    def wait() -> list[Event]:
        thread.join(LONG)
        return found

    return wait


# switches


@pytest.mark.conforms("FT-02")
@each("program", ["write", "read", "send", "mon"])
@each(
    ("words", "complaint"),
    [
        (["-h"], ""),
        (["-?"], ""),
        (["-d", "CID2:", "-help"], ""),
        (["CID1:"], "Unknown argument 'CID1:'\n"),
        (["-x", "1"], "Unknown option -x\n"),
        (["--", "1"], "Unknown option --\n"),
        (["-b"], "Missing argument to option -b\n"),
        (["-x"], "Missing argument to option -x\n"),
        (["--hub"], "Missing argument to option --hub\n"),
        (["-b", "fast"], "Wrong baudrate 'fast'\n"),
        (["-b", "08"], "Wrong baudrate '08'\n"),
    ],
)
def test_usage(program: str, words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]) -> None:
    name = PROGRAMS[program].name
    assert main(["candrv", program, *words]) == 2
    out, err = capsys.readouterr()
    assert out.startswith(f"{name} V3.0\n{complaint}{USAGE.format(name=name)}")
    assert "  -h       : Show this help\n" in out
    assert err == ""


@pytest.mark.conforms("FT-02")
@each(
    ("text", "rate"),
    [("500000", 500_000), ("0x7A120", 500_000), ("0X7a120", 500_000), ("01720440", 500_000), ("0", 0)],
)
def test_rates(text: str, rate: int) -> None:
    assert parse(PROGRAMS["write"], ["-b", text]).rate == rate


def test_defaults_and_all_switches() -> None:
    found = parse(PROGRAMS["read"], [])
    assert (found.device, found.rate, found.log, found.hub) == ("CID1:", None, None, None)
    words = ["-d", "CID3:", "-b", "125000", "-f", "-log", "--hub", "a", "--hub=b", "-n", "5"]
    found = parse(PROGRAMS["send"], words)
    assert (found.device, found.rate, found.log, found.hub) == ("CID3:", 125_000, "-log", "b")
    assert found.numbers == {"n": 5}


@each("words", [["-c", "0"], ["-t", "101"], ["-n", "10000001"], ["-n", "-1"]])
def test_impossible_counts(words: list[str]) -> None:
    with pytest.raises(Usage, match="Wrong number"):
        parse(PROGRAMS["send"], words)


@pytest.mark.conforms("FT-02")
@pytest.mark.parametrize("program", ["write", "read", "send", "mon"])
def test_no_device(program: str, bench: Bench) -> None:
    status, out, err = bench.run(program, "-d", "CID7:")
    assert (status, out) == (1, f"{PROGRAMS[program].name} V3.0\nCan't open device CID7:, error 2\n")
    assert "registered are CID1:, CID2:" in err
    bench.interrupt(bench.hub, signal.SIGTERM)
    status, out, err = bench.run(program)
    assert (status, out.splitlines()[-1]) == (1, "Can't open device CID1:, error 55")
    assert "canwire serve" in err


def test_an_impossible_rate_sends_nothing(bench: Bench) -> None:
    other = bench.device()
    status, out, err = bench.run("write", "-b", "7")
    assert (status, out) == (1, "CanWrite V3.0\nCan't set baudrate 7, error 87\n")
    assert "SJA1000" in err
    assert other.waiting == 0


# CanWrite, CanRead


@pytest.mark.conforms("FT-01")
def test_can_write(bench: Bench) -> None:
    other = bench.device()
    other.device.change(rate=500_000)
    messages = collected(other, 1000)
    status, out, err = bench.run("write", "-d", "CID1:", "-b", "500000", "-f", "log")
    assert (status, err) == (0, "")
    assert out.splitlines() == [
        "CanWrite V3.0",
        "Using log file 'log'",
        "Start sending 1000 messages to CID1:, baudrate=500000 Hz",
    ]
    lines = b"".join(b"%x 0 8 0 0 0 0 0 0 0 0\n" % number for number in range(1000))
    assert (bench.home / "log").read_bytes() == lines
    assert [(one.identifier, one.rtr, one.dlc, one.data) for one in messages()] == [
        (number, 0, 8, bytes(8)) for number in range(1000)
    ]


def test_can_write_says_that_it_waits(capsys: pytest.CaptureFixture[str]) -> None:
    written = Written("CID1:")
    written.count = 5
    written.look()
    assert capsys.readouterr().err == ""
    written.look()
    written.look()
    assert capsys.readouterr().err == (
        "canwire: CID1:: message 5 of 1000 waits: the bus takes none; does another controller run there? "
        "Ctrl-C ends it\n"
    )


def test_can_write_without_a_log(bench: Bench) -> None:
    messages = collected(bench.device(), 1000)
    status, out, err = bench.run("write", "-f", "missing/log")
    assert status == 0
    assert out.splitlines()[1:] == [
        "Can't open log file 'missing/log', error 3",
        "Start sending 1000 messages to CID1:, baudrate=1000000 Hz",
    ]
    assert "No such file or directory" in err
    assert len(messages()) == 1000


@pytest.mark.conforms("FT-03")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_can_read(bench: Bench, number: int) -> None:
    (bench.home / "log").write_text("old")
    reader = bench.start("candrv", "read", "-d", "CID2:", "-f", "log")
    lines = bench.until(reader, "Start receiving")
    assert lines == [
        "CanRead V3.0\n",
        "Using log file 'log'\n",
        "Start receiving events from CID2:, baudrate=1000000 Hz\n",
    ]
    other = bench.device("CID1:", read=False)
    other.write(b"731 0 4 11 22 33 44\n")
    other.write(b"112 1 0\n")
    text = "".join(bench.line(reader) for _ in range(4))
    first, second = text.replace("0\nrec", "0\n|rec").split("|")
    assert first.split("\t")[2:] == ["00000731", "0", "4\n", "11", "22", "33", "44", "0\n"]
    assert second.split("\t")[2:] == ["00000112", "1", "0\n", "0\n"]
    status, rest, err = bench.interrupt(reader, number)
    assert (status, rest, err) == (0, "", "")
    assert (bench.home / "log").read_bytes() == text.replace("\n\t", "\r\n\t").encode()


@pytest.mark.conforms("FT-02")
@pytest.mark.parametrize("program", ["read", "mon"])
def test_the_hub_goes(bench: Bench, program: str) -> None:
    reader = bench.start("candrv", program)
    bench.until(reader, "Start receiving")
    bench.interrupt(bench.hub, signal.SIGTERM)
    out, _ = reader.communicate(timeout=LONG)
    assert reader.returncode == 1
    assert out.splitlines()[-1] == "Read error 55"


# CanSend


@pytest.mark.smoke
@pytest.mark.conforms("FT-04")
def test_can_send(bench: Bench) -> None:
    other = bench.device()
    messages = collected(other, 1200)
    status, out, err = bench.run("send", "-n", "200", "-c", "3", "-t", "2", "-f", "log")
    assert (status, err) == (0, "")
    lines = [line for line in out.splitlines() if not line.endswith(" of 1200")]
    assert lines[:3] == [
        "CanSend V3.0",
        "Using log file 'log'",
        "Start sending 200 messages x 3 channels x 2 threads = 1200 messages to CID1:, baudrate=1000000 Hz",
    ]
    assert lines[3].startswith("1200 of 1200 messages sent in ")
    assert lines[4:] == ["0 errors"]
    came = messages()
    for sender in range(6):
        own = [one.data for one in came if one.identifier == 0x100 + sender]
        place = bytes([sender // 2, sender % 2, 0, 0])
        assert own == [number.to_bytes(4, "big") + place for number in range(200)]
    logged = (bench.home / "log").read_text().splitlines()
    assert len(logged) == 1200
    assert "105 0 8 0 0 0 c7 2 1 0 0" in logged


@pytest.mark.conforms("FT-04")
def test_can_send_with_more_channels_than_there_are(bench: Bench) -> None:
    status, out, err = bench.run("send", "-c", "4")
    assert (status, out.splitlines()[-1]) == (1, "Can't open device CID1:, error 1450")
    assert "3 send channels" in err
    messages = collected(bench.device(), 9)
    assert bench.run("send", "-c", "3", "-n", "3")[0] == 0  # they were given back
    assert len(messages()) == 9


@pytest.mark.conforms("FT-04")
def test_can_send_to_nobody(bench: Bench) -> None:
    status, out, _ = bench.run("send", "-n", "150")
    assert status == 1
    *_, total, given_up, errors, kind = out.splitlines()
    assert total.startswith("0 of 150 messages sent in ")
    assert given_up == "101 given up: the controller could not send them"
    assert (errors, kind) == ("3 errors", "  3 x ERROR_TIMEOUT (1460), the time ran out")


@pytest.mark.conforms("FT-04")
def test_can_send_ends_with_its_totals(bench: Bench) -> None:
    sender = bench.start("candrv", "send", "-n", "5000", "-c", "2")
    bench.until(sender, "Start sending")
    status, out, err = bench.interrupt(sender)  # nobody acknowledges
    assert (status, err) == (130, "")
    assert "0 of 10000 messages sent in " in out
    assert "given up: " in out


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_can_write_is_interrupted(bench: Bench, number: int) -> None:
    writer = bench.start("candrv", "write")
    bench.until(writer, "Start sending")
    assert bench.interrupt(writer, number) == (128 + number, "", "")  # nobody acknowledges


@pytest.mark.conforms("FT-01", "FT-04")
def test_on_an_mcp2515(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CANWIRE_CONFIG", "")
    with ExitStack() as closing:
        bench = Bench(tmp_path, closing, "picocom1")
        messages = collected(bench.device(), 1300)
        assert bench.run("write")[::2] == (0, "")
        status, out, err = bench.run("send", "-n", "100", "-c", "3")
        assert (status, err) == (0, "")
        assert "300 of 300 messages sent in " in out
        came = messages()
        assert [event.identifier for event in came[:1000]] == list(range(1000))
        assert {event.identifier for event in came[1000:]} == {0x100, 0x101, 0x102}


@pytest.mark.finding("candrv A2")
@pytest.mark.conforms("FT-04")
@pytest.mark.parametrize("words", ["-n 1", "-n 5", "-n 20 -c 3 -t 2"])
def test_can_send_to_nobody_on_an_mcp2515(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str
) -> None:
    """What nobody acknowledged was not sent, also where it was on the wire to the end."""
    monkeypatch.setenv("CANWIRE_CONFIG", "")
    with ExitStack() as closing:
        bench = Bench(tmp_path, closing, "picocom1")
        status, out, _ = bench.run("send", *words.split())
        assert status == 1
        assert re.search(r"^0 of \d+ messages sent in ", out, re.MULTILINE)


# CanMon


@pytest.mark.conforms("FT-05")
def test_can_mon(bench: Bench) -> None:
    monitor = bench.start("candrv", "mon", "-d", "CID2:", "-b", "0x7A120", "-f", "log")
    assert bench.until(monitor, "Start receiving")[-1].endswith("baudrate=500000 Hz\n")
    other = bench.device("CID1:", read=False)
    other.device.change(rate=500_000)
    other.write_message(0x731, b"\x11\x22\x33\x44")
    other.write_message(0x112, rtr=True, dlc=15)
    lines = [bench.line(monitor) for _ in range(3)]
    assert [line.rstrip("\n").partition(" ")[2] for line in lines] == [
        "DEVICE_CHANGED 0",
        "RECEIVED 0 STD 00000731 0 4 11 22 33 44",
        "RECEIVED 0 STD 00000112 1 F",
    ]
    assert all(line.partition(" ")[0].isdecimal() for line in lines)
    assert bench.interrupt(monitor) == (0, "", "")
    assert (bench.home / "log").read_text() == "".join(lines)


@pytest.mark.conforms("FT-05")
@each("kind", list(CanbusEvent))
def test_every_event_has_its_line(kind: CanbusEvent) -> None:
    event = Event(int(kind), 12568, 5, 2, 0x025E0235, 0, 10, bytes(range(8)))
    message = " EXT 025E0235 0 A 00 01 02 03 04 05 06 07" if event.has_message else ""
    assert shown(event) == f"12568 {kind.name} 5{message}"


@each(("number", "name"), [(0x800, "UNKNOWN_800"), (0x14, "UNKNOWN_14"), (0, "UNKNOWN_0")])
def test_an_unknown_event(number: int, name: str) -> None:
    assert shown(Event(number, 1)) == f"1 {name} 0"


# the registry


def registry(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """stdout of a command that succeeds."""
    assert main(["candrv", *words]) == 0
    return capsys.readouterr().out


@pytest.mark.conforms("FS-10")
def test_install_and_remove(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CANWIRE_CONFIG", raising=False)
    assert registry(capsys, "install") == "CID1: installed in canwire.toml\n"
    assert registry(capsys, "registry", "get", "CID1:", "Baudrate") == "1000000\n"
    registry(capsys, "install", "CID2:")
    registry(capsys, "remove", "CID1:")
    assert registry(capsys, "registry", "list").startswith("[candrv.CID2]\n")
    registry(capsys, "remove", "CID2:")
    assert registry(capsys, "registry", "list") == ""
    assert main(["candrv", "remove"]) == 2
    assert "registered are none" in capsys.readouterr().err
    assert main(["candrv", "install", "can1:"]) == 2
    registry(capsys, "install")
    assert "[candrv.CID1]" in (tmp_path / "canwire.toml").read_text()


@pytest.mark.finding("candrv C4")
def test_a_list_names_nothing_of_the_source(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(tmp_path / "r.toml")
    assert main(["candrv", "install", "CID1:", "--config", file]) == 0
    capsys.readouterr()
    listed = registry(capsys, "registry", "list", "CID1:", "--config", file)
    assert "AcceptanceMask" in listed
    assert ".py" not in listed


@pytest.mark.conforms("FS-04")
def test_entries(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(tmp_path / "r.toml")
    for entry, value in (("baudrate", "500000"), ("AcceptanceMask", "0xFFFFFFFF"), ("SPIDevice", "SPI1:")):
        assert main(["candrv", "registry", "set", "CID1:", entry, value, "--config", file]) == 0
        out, err = capsys.readouterr()
        assert out == ""
        assert "loaded the next time" in err
    assert registry(capsys, "registry", "get", "CID1:", "Baudrate", "--config", file) == "500000\n"
    listed = registry(capsys, "registry", "list", "CID1:", "--config", file).splitlines()
    assert listed[0] == "[candrv.CID1]"
    shown = [line.partition(" # ")[0].rstrip() for line in listed]
    assert {"Baudrate = 500000", "AcceptanceMask = 0xFFFFFFFF", 'SPIDevice = "SPI1:"'} < set(shown)
    assert {"# TxMode = 7", "# AcceptanceCode = 0x00000000", '# Prefix = "CID"', "# UseTxIRQ ="} < set(shown)
    registry(capsys, "registry", "delete", "CID1:", "Baudrate", "--config", file)
    assert registry(capsys, "registry", "get", "CID1:", "Baudrate", "--config", file) == "1000000\n"
    registry(capsys, "registry", "defaults", "CID1", "--config", file)
    assert (tmp_path / "r.toml").read_text().strip() == "[candrv.CID1]"


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["get", "CID9:", "Baudrate"], "registered are CID1"),
        (["get", "CID1:", "Bitrate"], "there are Dll, "),
        (["set", "CID1:", "Baudrate", "fast"], "a number"),
        (["set", "CID1:", "Align", "4"], "0 to 3"),
    ],
)
def test_what_the_registry_refuses(
    words: list[str], complaint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["candrv", "registry", *words, "--config", str(tmp_path / "r.toml")]) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "r.toml").exists()


@pytest.mark.conforms("FS-04")
def test_settings_count_after_a_restart(bench: Bench) -> None:
    collecting = collected(bench.device(), 1)
    assert bench.run("send", "-n", "1")[0] == 0
    assert len(collecting()) == 1
    assert bench.run("registry", "set", "CID1:", "Baudrate", "250000")[0] == 0
    query = bench.device("CID1:", read=False, write=False)
    assert query.device.state().rate == 1_000_000
    query.close()
    status, out, _ = bench.run("restart", "CID1:")
    assert (status, out) == (0, "CID1: is loaded again when it is next opened\n")
    assert bench.device("CID1:", read=False, write=False).device.state().rate == 250_000


@pytest.mark.finding("candrv B16")
def test_a_reg_file_is_imported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = ["--config", str(tmp_path / "r.toml")]
    (tmp_path / "board.reg").write_text(
        "REGEDIT4\n\n[HKEY_LOCAL_MACHINE\\Drivers\\BuiltIn\\CID1]\n"
        '"Dll"="candrv.dll"\n"Baudrate"=dword:0007a120\n"Flags"=dword:00000008\n'
    )
    assert main(["candrv", "registry", "import", str(tmp_path / "board.reg"), *config]) == 0
    shown = capsys.readouterr()
    assert shown.out == "CID1: 2 entries\n"
    assert "skipped: CID1 Flags=dword:00000008\n" in shown.err
    assert main(["candrv", "registry", "get", "CID1:", "Baudrate", *config]) == 0
    assert capsys.readouterr().out == "500000\n"
    assert main(["candrv", "registry", "import", str(tmp_path / "none.reg"), *config]) == 2
    assert "No such file" in capsys.readouterr().err


@pytest.mark.finding("candrv B16")
def test_loaded_drivers_are_shown(bench: Bench) -> None:
    assert bench.run("active") == (0, "no driver is loaded: one is when its device is first opened\n", "")
    handle = bench.device()
    expected = (
        "CID2: Drivers\\BuiltIn\\CID2\n  HW000002 (netdcu), line 0\n  1000000 bit/s, CAN2.0A, {}\n"
        '  Board = "HW000002"\n  AcceptanceMask = 0xFFFFFFFF\n  EventQueueSize = 20000\n'
        '  Prefix = "CID"\n  Index = 2\n'
    )
    assert bench.run("active") == (0, expected.format("open"), "")
    handle.close()
    assert bench.run("active") == (0, expected.format("not open"), "")


# a device as a terminal


@pytest.fixture
def attached(bench: Bench) -> tuple[subprocess.Popen[str], Path]:
    path = bench.home / "can"
    process = bench.start("candrv", "attach", "CID1:", str(path))
    assert bench.line(process).startswith(f"CID1: is {path} (/dev/")
    return process, path


def shell(command: str) -> None:
    subprocess.run(["sh", "-c", command], check=True, timeout=LONG)


@pytest.mark.conforms("FS-23", "FS-24")
def test_echo_sends(bench: Bench, attached: tuple[subprocess.Popen[str], Path]) -> None:
    process, path = attached
    other = bench.device()
    shell(f'echo "731 0 4 11 22 33 44" > {path}')
    shell(f"printf '732 0 1 5\\r\\n733 1 2\\n' > {path}")
    shell(
        f"echo bad > {path}; printf '734 0' > {path}; sleep 0.3; echo ' 1 7' > {path}; echo 735 1 0 > {path}"
    )
    assert [(one.identifier, one.rtr, one.dlc, one.data) for one in received(other, 4)] == [
        (0x731, 0, 4, b"\x11\x22\x33\x44"),
        (0x732, 0, 1, b"\x05"),
        (0x733, 1, 2, b""),
        (0x735, 1, 0, b""),
    ]
    status, out, err = bench.interrupt(process, signal.SIGTERM)
    assert (status, out) == (0, "")
    complaints = err.splitlines()
    assert len(complaints) == 2  # what one opener left unfinished is no beginning of the next one's
    assert "'bad\\n'" in complaints[0]
    assert "' 1 7\\n'" in complaints[1]
    assert not path.is_symlink()


@pytest.mark.conforms("FS-26")
def test_cat_shows_events(bench: Bench, attached: tuple[subprocess.Popen[str], Path]) -> None:
    process, path = attached
    other = bench.device()
    for number in (0x100, 0x200):
        time.sleep(0.5)  # the one before has gone, and that is known
        other.write_message(0x7FF)  # nobody has it open: nobody's
        while other.read_event().event != CanbusEvent.TRANSMITTED:
            pass
        time.sleep(0.2)
        with subprocess.Popen(["cat", str(path)], stdout=subprocess.PIPE, text=True) as cat:
            assert cat.stdout is not None
            sending = Repeated(partial(other.write_message, number, b"\x01\x02"))
            lines = [cat.stdout.readline() for _ in range(2)]
            sending.stop()
            cat.terminate()
            cat.communicate(timeout=LONG)
        assert lines[0].split("\t")[0] == "received"
        assert lines[0].split("\t")[2:] == [f"{number:08x}", "0", "2\r\n"] or lines[0].endswith("\t2\n")
        assert lines[1] == "\t01\t02\t0\n"
    assert bench.interrupt(process, signal.SIGINT)[0] == 0
    assert not path.is_symlink()


class Repeated:
    """Does it every 50 ms until `stop`, in a thread."""

    def __init__(self, call: Callable[[], object]) -> None:
        self._over = threading.Event()
        self._call = call
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.wait(0.05):
            self._call()

    def stop(self) -> None:
        self._over.set()
        self._thread.join(LONG)


def test_a_path_that_is_taken(bench: Bench) -> None:
    path = bench.home / "can"
    path.write_text("mine")
    status, _, err = bench.run("attach", "CID1:", str(path))
    assert status == 2
    assert "something is there already" in err
    assert path.read_text() == "mine"
    path.unlink()
    path.symlink_to("/dev/pts/none")  # what a killed process leaves
    process = bench.start("candrv", "attach", "CID1:", str(path))
    assert bench.line(process).startswith("CID1: is ")
    assert bench.run("attach", "CID2:", str(path))[0] == 2
    bench.interrupt(bench.hub, signal.SIGTERM)
    _, err = process.communicate(timeout=LONG)
    assert process.returncode == 2
    assert "ERROR_DEV_NOT_EXIST" in err
    assert not path.is_symlink()


def test_lines_of_a_terminal() -> None:
    assert candrv_attach._split(b"1 0 0\r\n2") == [b"1 0 0\r", b"\n", b"2"]
    assert candrv_attach._split(b"") == [b""]
