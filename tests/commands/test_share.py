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
    assert main(["share", str(dongle.link), "--hub", hub_address]) == 0
    assert "no adapter answers there" in capsys.readouterr().out


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
