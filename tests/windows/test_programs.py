"""Verbs as processes of Windows on a hub there; hubs of Linux and Windows, and the other's programs on them."""

from __future__ import annotations

import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

import canwire
from tests.hubs import free_port, offering, served_here
from tests.windows.conftest import LONG_S, Program, Windows

BEGINS = "HW000001:0"


def line_of(program: Program, holds: str) -> str:
    """The first line of its output with these words in it."""
    assert program.stdout is not None
    said = []
    for line in program.stdout:
        said.append(line)
        if holds in line:
            return line
    raise AssertionError(f"{program.args} ended without {holds!r}: {''.join(said)}")


@pytest.fixture
def hub(windows: Windows, tmp_path: Path) -> str:
    """A hub on Windows: its address there."""
    address = windows.path(tmp_path / "hub")
    line_of(windows.start("-m", "canwire", "serve", "--time", "fast", "--socket", address), "canwire hub on")
    return address


def test_verbs_each_in_a_process_of_its_own(windows: Windows, hub: str) -> None:
    def canwire_(*words: str) -> str:
        return windows.run("-m", "canwire", *words)

    assert "uncompiled" in canwire_("--version")
    assert "HW000001" in canwire_("devices", "--hub", hub)
    assert "Windows 10" in canwire_("doctor", "--hub", hub)
    canwire_("up", "HW000002:0", "--hub", hub)
    dump = windows.start("-m", "canwire", "dump", "HW000002:0", "--hub", hub, "--count", "1")
    while dump.poll() is None:  # it listens as soon as it has begun, of which it says nothing
        canwire_("send", BEGINS, "123#1122", "--hub", hub)
    assert "11 22" in line_of(dump, "123")


def test_a_program_of_windows_on_a_hub_of_linux(windows: Windows, tmp_path: Path) -> None:
    with (
        served_here(tmp_path) as here,
        offering(here) as (address, _),
        closing(canwire.connect(here)) as linux,
    ):
        channel = opened(linux)
        said = windows.run("-m", "canwire", "send", BEGINS, "123#1122", "--hub", address)
        frame = channel.receive(LONG_S)
        assert frame is not None, said
        assert (frame.id, bytes(frame.data)) == (0x123, b"\x11\x22")


def test_a_program_of_linux_on_a_hub_of_windows(windows: Windows, hub: str) -> None:
    port = free_port()
    words = ("--realm", "tests", "--name", "windows", "--listen", f"tcp/127.0.0.1:{port}")
    line_of(windows.start("-m", "canwire", "offer", "--hub", hub, *words), "offered as")
    address = f"zenoh://tests/windows?via=tcp/127.0.0.1:{port}"
    with closing(canwire.connect(address)) as program:
        heard = opened(program)
        sender = [sys.executable, "-m", "canwire", "send", BEGINS, "123#1122", "--hub", address]
        subprocess.run(sender, check=True, timeout=LONG_S, capture_output=True)
        frame = heard.receive(LONG_S)
        assert frame is not None
        assert (frame.id, bytes(frame.data)) == (0x123, b"\x11\x22")


def opened(hub: canwire.Hub) -> canwire.HubChannel:
    """A channel of the second board's first line, which runs with 500 kbit/s from now on, as verbs have it."""
    board = hub.boards()[1].id
    control = hub.open_control(board, 0)
    control.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)))
    control.start()
    made = hub.open_channel(board, 0)
    made.set_up(canwire.ChannelMode(256, 64))
    made.activate()
    return made
