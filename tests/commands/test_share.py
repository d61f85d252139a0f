"""`canwire share`: real adapters on a running hub, and on one of its own in a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire import BadValue, ChannelMode, ErrorState, Frame
from canwire.commands import main
from canwire.commands.share import parse_spec
from tests import warm
from tests.drivers.slcan_dongle.fake_dongle import FakeDongle


@pytest.fixture
def dongle(tmp_path: Path) -> Iterator[FakeDongle]:
    made = FakeDongle(tmp_path / "ttyCANBUS0")
    yield made
    made.vanish()


@pytest.mark.smoke
@pytest.mark.realtime
@pytest.mark.conforms("CT-14", "PL-02", "PL-13")
def test_adapters_come_to_a_running_hub(
    hub_address: str, dongle: FakeDongle, capsys: pytest.CaptureFixture[str]
) -> None:
    specs = [str(dongle.link), "python-can:virtual/canwire-test-share"]
    assert main(["share", *specs, "--hub", hub_address]) == 0

    first, second = capsys.readouterr().out.splitlines()
    assert f"slcan  Port {dongle.link}, Version V1013, Serial number A123, Dialect CANBUS" in first
    assert "python-can  Port virtual/canwire-test-share" in second
    with canwire.connect(hub_address) as hub:
        assert [board.kind for board in hub.boards()][-2:] == ["slcan", "python-can"]
        assert not hub.line_status(hub.board("slcan").id, 0).running
    assert main(["devices", "--hub", hub_address]) == 0
    assert "V1013" in capsys.readouterr().out


@pytest.mark.realtime
def test_a_line_may_be_started_for_good(
    hub_address: str, dongle: FakeDongle, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["share", str(dongle.link), "--bit-rate", "125000", "--hub", hub_address]) == 0

    assert "125000 bit/s" in capsys.readouterr().out
    assert any(line[:1] in (b"S", b"s") for line in dongle.lines)
    with canwire.connect(hub_address) as hub:
        board = hub.board("slcan")
        assert hub.line_status(board.id, 0).state == ErrorState.ERROR_ACTIVE
        channel = hub.open_channel(board.id, 0)
        channel.set_up(ChannelMode(64, 64))
        channel.activate()
        channel.send(Frame(0x123))
        dongle.wait_for(b"t1230")
    assert main(["send", "slcan:0", "321#AB", "--hub", hub_address]) == 0
    dongle.wait_for(b"t3211AB")


@pytest.mark.realtime
def test_listen_only_is_one_argument(hub_address: str, dongle: FakeDongle) -> None:
    assert main(["share", str(dongle.link), "--listen-only", "--hub", hub_address]) == 0
    dongle.wait_for(b"L")
    assert b"O" not in dongle.lines


def test_all_or_none(hub_address: str, dongle: FakeDongle, capsys: pytest.CaptureFixture[str]) -> None:
    with canwire.connect(hub_address) as hub:
        before = hub.boards()
        assert main(["share", str(dongle.link), "/dev/no such port", "--hub", hub_address]) == 2
        assert "no port /dev/no such port" in capsys.readouterr().err
        assert hub.boards() == before


@pytest.mark.realtime
def test_a_silent_adapter_is_waited_for(
    hub_address: str, dongle: FakeDongle, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("canwire.commands.share.PATIENCE_S", 0.1)
    dongle.answer = lambda line: None
    assert main(["share", str(dongle.link), "--wait", "--hub", hub_address]) == 0
    assert "the hub waits for it" in capsys.readouterr().out
    with canwire.connect(hub_address) as hub:
        hub.unplug(hub.board("slcan").hardware_id)
    assert main(["share", str(dongle.link), "--hub", hub_address]) == 1
    assert "no adapter answers at" in capsys.readouterr().err


@pytest.mark.realtime
@pytest.mark.conforms("PL-02")
def test_a_hub_of_its_own_where_none_runs(tmp_path: Path, dongle: FakeDongle) -> None:
    address = str(tmp_path / "own.sock")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "CANWIRE_HUB": address}
    process = warm.Popen(
        [sys.executable, "-m", "canwire", "share", str(dongle.link), "--bit-rate", "500000"],
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
        cwd=tmp_path,
    )
    try:
        assert process.stdout is not None
        assert "V1013" in process.stdout.readline()
        assert f"canwire hub on {address}" in process.stdout.readline()
        with canwire.connect(address) as hub:
            board = hub.board("slcan")
            channel = hub.open_channel(board.id, 0)
            channel.set_up(ChannelMode(64, 64))
            channel.activate()
            dongle.say(b"t1231AB\r")
            assert channel.receive(20) == Frame(0x123, b"\xab")
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
        dongle.wait_for(b"C", 2)  # once at the start, once at the end
    finally:
        process.kill()
        process.wait()
        assert process.stdout is not None
        process.stdout.close()


def test_without_arguments_it_lists_ports(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["share"]) == 0


def test_specs() -> None:
    assert parse_spec("/dev/ttyUSB0") == ("slcan", "/dev/ttyUSB0")
    assert parse_spec("COM3") == ("slcan", "COM3")
    assert parse_spec("socket://host:1") == ("slcan", "socket://host:1")
    assert parse_spec("slcan-fd:/dev/ttyACM0") == ("slcan-fd", "/dev/ttyACM0")
    assert parse_spec("python-can:pcan/PCAN_USBBUS1") == ("python-can", "pcan/PCAN_USBBUS1")
    with pytest.raises(BadValue):
        parse_spec("python-can:")


@pytest.mark.realtime
@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("python-can:nope/0", "there is no interface 'nope' in python-can; found: canalystii, "),
        ("python-can:pcam/0", "did you mean"),
        ("python-can:canalystii/0", "pip install canalystii"),
        ("/dev/null", "/dev/null"),
    ],
)
@pytest.mark.parametrize("started", [True, False])
def test_an_adapter_that_cannot_be_opened_says_why(
    hub_address: str, spec: str, words: str, started: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    rate = ["--bit-rate", "500000"] if started else []
    with canwire.connect(hub_address) as hub:
        before = hub.boards()
        assert main(["share", spec, *rate, "--hub", hub_address]) == 1
        assert words in capsys.readouterr().err
        assert hub.boards() == before


@pytest.mark.realtime
def test_what_is_waited_for_is_explained_wherever_it_is_shown(
    hub_address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = "python-can:nope/0"
    assert main(["share", spec, "--bit-rate", "500000", "--wait", "--hub", hub_address]) == 0
    assert "no interface 'nope'" in capsys.readouterr().out
    assert main(["devices", "--hub", hub_address]) == 0
    assert "! there is no interface 'nope'" in capsys.readouterr().out
    assert main(["send", "python-can:0", "123#", "--timeout", "0.1", "--hub", hub_address]) == 1
    assert "not delivered: there is no interface 'nope'" in capsys.readouterr().err
    assert main(["up", "python-can:0", "--hub", hub_address]) == 2
    assert ", but there is no interface 'nope'" in capsys.readouterr().err
    with canwire.connect(hub_address) as hub:
        assert "there is no interface 'nope'" in hub.obstacle(hub.board("python-can"), 0)
        assert hub.obstacle(hub.boards()[0], 0) == ""
    assert main(["stop", "python-can:0", "--hub", hub_address]) == 0
    assert main(["up", "python-can:0", "--hub", hub_address]) == 1
    assert "there is no interface 'nope'" in capsys.readouterr().err


def test_adapters_are_listed_with_the_line_to_type(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from canwire.boards import adapters
    from tests.drivers.python_can.candle import Candle

    found = [
        {"interface": "pcan", "channel": "PCAN_USBBUS1", "device_name": "PCAN-USB FD"},
        {"interface": "socketcan", "channel": "can0"},
    ]
    monkeypatch.setattr(adapters, "detected_configs", lambda interfaces: found)
    monkeypatch.setattr(adapters, "described_ports", lambda: [("/dev/ttyACM0", "A123", "CANable")])
    monkeypatch.setattr(adapters.devices, "find_devices", lambda: [Candle("C0FFEE")])
    assert main(["adapters"]) == 0
    lines = [line.split("  ", 1) for line in capsys.readouterr().out.splitlines()]
    assert [(line, what.strip()) for line, what in lines] == [
        ('canwire share "?serial=A123" --bit-rate 500000', "/dev/ttyACM0, CANable"),
        ('canwire share "python-can:gs_usb/C0FFEE" --bit-rate 500000', "candleLight FD"),
        ('canwire share "python-can:pcan/PCAN_USBBUS1" --bit-rate 500000', "PCAN-USB FD"),
        ('canwire share "python-can:socketcan/can0" --bit-rate 500000', "socketcan"),
    ]
    assert main(["adapters", "--json"]) == 0
    assert '"python-can:gs_usb/C0FFEE"' in capsys.readouterr().out


class _WithoutPorts:
    """An importer that fails as pyserial's search does under Wine 8."""

    def find_spec(self, name: str, *_: object) -> None:
        if name == "serial.tools.list_ports":
            raise AttributeError("function 'CM_MapCrToWin32Err' not found")


def test_a_system_that_cannot_list_its_ports_says_so_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import serial.tools

    from canwire.drivers.slcan_dongle.ports import usb_serial_of

    monkeypatch.delattr(serial.tools, "list_ports", raising=False)
    monkeypatch.delitem(sys.modules, "serial.tools.list_ports", raising=False)
    monkeypatch.setattr(sys, "meta_path", [_WithoutPorts(), *sys.meta_path])
    for words in (["adapters"], ["share"], ["adapters", "--json"]):
        assert main(words) != 0
        said = capsys.readouterr()
        assert (said.out, said.err.count("\n")) == ("", 1)
        assert "serial ports cannot be listed here" in said.err
        assert "CM_MapCrToWin32Err" in said.err
    assert usb_serial_of("COM3") == ""  # a port that is named is opened all the same
