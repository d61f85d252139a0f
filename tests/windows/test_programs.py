"""Hubs of Linux and Windows, and the other's programs on them; five interfaces in five processes of Windows."""

from __future__ import annotations

import re
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

import canwire
from tests.docs.test_five_programs import GUIDE, PROGRAM, SHOWN
from tests.hubs import free_port, offering, served_here
from tests.windows.conftest import LONG_S, Windows, line_of

pytestmark = pytest.mark.conforms("N-64")

BEGINS = "HW000001:0"


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


def test_interfaces_each_in_a_process_of_its_own(windows: Windows, tmp_path: Path) -> None:
    """docs/five-programs.md: VCI, ACAN, CANDRV, python-can, and a serial adapter (by TCP: no pseudo terminals)."""
    page = GUIDE.read_text(encoding="utf-8")
    address, port = windows.path(tmp_path / "hub"), free_port()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CANWIRE_HUB", address)
        line_of(
            windows.start("-m", "canwire", "serve", "--time", "fast", "--socket", address), "canwire hub on"
        )
        line_of(windows.start("-m", "canwire", "slcan", "--tcp", f"127.0.0.1:{port}"), str(port))
        programs = {
            number: windows.start(
                "-c",
                text.replace(
                    'serial.Serial("./ttyCANBUS0"', f'serial.serial_for_url("socket://127.0.0.1:{port}"'
                ),
            )
            for _, number, text in PROGRAM.findall(page)
        }
        for program in programs.values():
            line_of(program, "ready")
        (go,) = re.findall(r"^\$ canwire (send .*)$", page, re.MULTILINE)
        windows.done(*go.split())
    expected = SHOWN.findall(page)[0].splitlines()
    for number, program in programs.items():
        assert program.stdout is not None
        assert [program.stdout.readline().strip() for _ in range(4)] == [
            other for other in expected if not other.startswith(number)
        ]
