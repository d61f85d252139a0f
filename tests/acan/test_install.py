"""Which board the driver serves. Source: INduCAN104 manual, "Drivers and utilities setup"."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import canwire
from canwire import BadText, BadValue, InUse
from canwire.acan.driver import open_driver
from canwire.acan.hard_config import HardConfig
from canwire.acan.install import DriverAbsent, Installation, find_line, install, setup, uninstall
from tests.cases import each
from tests.hubs import Connect

SJA1000, OTHER = 5, 0x0A
LONG = 60  # seconds after which something that should happen never will


@pytest.mark.conforms("AC-05")
@each(
    ("text", "expected"),
    [
        ("/P:280 /I:5", Installation(0x280, 5)),
        ("/P:280/I:5", Installation(0x280, 5)),  # as the manual prints its example
        ("/p:3e0 /i:11*", Installation(0x3E0, 11, shared=True)),
        ("/I:9 /P:100h", Installation(0x100, 9)),
        ("/U", None),
        ("/u", None),
    ],
)
def test_the_command_line_of_acan_exe(text: str, expected: Installation | None) -> None:
    assert Installation.parse(text) == expected
    assert Installation.parse(text.split()) == expected


@pytest.mark.conforms("AC-05")
@each(
    "text", ["", "/P:280", "/I:5", "/P:280 /I:5 /U", "/P:xyz /I:5", "/P:280 /P:2A0", "/P:280 /I:5 x", "/I:5x"]
)
def test_other_command_lines_are_refused(text: str) -> None:
    with pytest.raises(BadText):
        Installation.parse(text)


@pytest.mark.conforms("AC-05")
@each("text", ["/P:281 /I:5", "/P:E0 /I:5", "/P:400 /I:5", "/P:280 /I:6", "/P:280 /I:12"])
def test_what_no_jumper_can_set_is_refused(text: str) -> None:
    with pytest.raises(BadValue, match=r"port|irq"):
        Installation.parse(text)


@pytest.mark.conforms("AC-06")
def test_the_ini_section() -> None:
    text = "[386Enh]\ndevice=vacand.386\ndevice=*vmd\n\n[ACAN]\nBase=2A0h\nIrq=7\n"
    assert Installation.from_ini(text) == Installation(0x2A0, 7)
    made = Installation(0x300, 10, shared=True)
    assert Installation.from_ini(made.to_ini()) == made


@pytest.mark.conforms("AC-06")
@each("text", ["", "Base=280", "[ACAN]\nBase=280\n", "[ACAN]\nBase=x\nIrq=5", "[ACAN]\nBase\nIrq=5"])
def test_an_ini_file_without_it_is_refused(text: str) -> None:
    with pytest.raises(BadText, match="ACAN"):
        Installation.from_ini(text)


def test_the_note_that_the_hub_keeps() -> None:
    for made in (Installation(0x280, 5), Installation(0x3E0, 11, shared=True)):
        assert Installation.from_note(made.to_note()) == made
    assert Installation(0x280, 5).to_note() == b"280:5"
    with pytest.raises(BadText):
        Installation.from_note(b"nonsense")


@pytest.mark.conforms("AC-06")
def test_setup_writes_scripts_and_configurations(tmp_path: Path) -> None:
    paths = setup(0x2A0, 7, tmp_path / "ACAN")
    assert [path.name for path in paths] == ["START", "STOP", "acan.ini", "canwire.toml"]
    start, stop, ini, world = paths
    assert "/P:2A0 /I:7" in start.read_text()
    assert "/U" in stop.read_text()
    assert os.access(start, os.X_OK)
    assert os.access(stop, os.X_OK)
    assert Installation.from_ini(ini.read_text()) == Installation(0x2A0, 7)
    assert "base = 0x2A0\nirq = 7\n" in world.read_text()
    assert setup(0x280, 5, tmp_path / "ACAN") == paths
    with pytest.raises(BadValue):
        setup(0x2A1, 7, tmp_path)


class Machine:
    """A hub's boards and notes, and what happens to its lines."""

    def __init__(self, *boards: Any) -> None:
        self._boards = boards
        self._notes: dict[str, bytes] = {}
        self.running = False
        self.channels = 0
        self.calls: list[str] = []

    def boards(self) -> tuple[Any, ...]:
        return self._boards

    def note(self, name: str) -> bytes:
        return self._notes.get(name, b"")

    def set_note(self, name: str, value: bytes) -> None:
        self._notes[name] = value

    def line_status(self, board: int, line: int) -> Any:
        return SimpleNamespace(running=self.running, channels=self.channels)

    @contextlib.contextmanager
    def open_control(self, board: int, line: int) -> Iterator[Any]:
        def called(name: str) -> Any:
            return lambda: self.calls.append(f"{name} {board}.{line}")

        yield SimpleNamespace(stop=called("stop"), reset=called("reset"))


def board(id: int, kind: str, *types: int, resources: tuple[tuple[str, str], ...] = ()) -> Any:
    lines = tuple(
        SimpleNamespace(bus_type="CAN", capabilities=SimpleNamespace(controller_type=type)) for type in types
    )
    return SimpleNamespace(id=id, kind=kind, hardware_id=f"HW{id:06}", lines=lines, resources=resources)


def indu(id: int, base: str, irq: str) -> Any:
    return board(id, "inducan104", SJA1000, resources=(("I/O", f"{base}h-29Fh"), ("IRQ", irq)))


def test_without_installation_the_first_inducan_is_served_before_other_sja1000s() -> None:
    machine = Machine(board(1, "usb", OTHER, SJA1000), board(2, "pc-i04", SJA1000), indu(3, "280", "5"))
    assert find_line(machine)[0].id == 3
    found, number = find_line(Machine(board(1, "usb", OTHER, SJA1000), board(2, "pc-i04", SJA1000)))
    assert (found.id, number) == (1, 1)


@pytest.mark.conforms("AC-05", "AC-09")
def test_without_any_sja1000_there_is_no_driver() -> None:
    with pytest.raises(DriverAbsent, match="HW000001"):
        find_line(Machine(board(1, "usb", OTHER)))


@pytest.mark.conforms("AC-05", "AC-07")
def test_installation_needs_a_controller_that_answers_and_takes_it_off_the_bus() -> None:
    machine = Machine(indu(1, "280", "5"), indu(2, "2A0", "7"))
    for wrong in (Installation(0x2A0, 5), Installation(0x300, 7)):
        with pytest.raises(DriverAbsent, match="answers"):
            install(machine, wrong)
    assert find_line(machine)[0].id == 1
    machine.running = True
    assert install(machine, Installation(0x2A0, 7)).id == 2
    assert machine.calls == ["stop 2.0"]
    assert find_line(machine)[0].id == 2


@pytest.mark.conforms("AC-05")
def test_one_installation_at_a_time() -> None:
    machine = Machine(indu(1, "280", "5"), indu(2, "2A0", "7"))
    install(machine, Installation(0x280, 5))
    install(machine, Installation(0x280, 5))
    with pytest.raises(InUse, match="280:5"):
        install(machine, Installation(0x2A0, 7))
    uninstall(machine)
    with pytest.raises(DriverAbsent, match="uninstalled"):
        find_line(machine)
    install(machine, Installation(0x2A0, 7))
    assert find_line(machine)[0].id == 2


@pytest.mark.conforms("AC-05")
def test_uninstalling_frees_the_line_unless_somebody_uses_it() -> None:
    machine = Machine(indu(1, "280", "5"))
    machine.channels = 2
    with pytest.raises(InUse, match="2 programs"):
        uninstall(machine)
    machine.channels = 0
    uninstall(machine)
    uninstall(machine)
    assert machine.calls == ["reset 1.0"]


@pytest.mark.conforms("AC-05", "AC-07", "AC-09")
def test_installation_on_a_hub_is_every_programs(hub: canwire.Hub, connect: Connect) -> None:
    other = connect("second program")
    with open_driver(hub) as driver:
        driver.configure(HardConfig())
        driver.bus_on()
        assert install(other, Installation(0x280, 5)).hardware_id == "HW000104"
        assert not driver.on_bus
        with pytest.raises(InUse):
            uninstall(other)
    with pytest.raises(InUse):
        install(hub, Installation(0x300, 7))
    uninstall(other)
    with pytest.raises(DriverAbsent):
        open_driver(hub)
    with pytest.raises(DriverAbsent, match="300h"):
        install(hub, Installation(0x300, 7))
    install(hub, Installation(0x280, 5, shared=True))
    with open_driver(other) as driver:
        assert not driver.initialised


@pytest.mark.conforms("AC-06")
def test_the_world_that_setup_writes_has_that_board(tmp_path: Path) -> None:
    *_, world = setup(0x2A0, 7, tmp_path)
    with canwire.connect(config=world, time="virtual") as hub:
        install(hub, Installation(0x2A0, 7))
        with open_driver(hub) as driver:
            assert driver.hub.board("inducan104").resources[:2] == (("I/O", "2A0h-2BFh"), ("IRQ", "7"))


@pytest.mark.conforms("AC-05", "AC-06")
@pytest.mark.finding("acan A10")
@pytest.mark.parametrize("named", [False, True], ids=["usual socket", "CANWIRE_HUB"])
def test_start_and_stop_load_and_unload_driver_and_hub(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: bool
) -> None:
    """With the real scripts: a hub of their own on a socket of its own, the one that programs ask."""
    paths = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(os.path.abspath, paths)))  # the scripts go elsewhere
    start, stop, *_ = setup(0x2A0, 7, tmp_path / "acan")
    command = tmp_path / "canwire"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m canwire "$@"\n')
    command.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    if named:
        monkeypatch.setenv("CANWIRE_HUB", str(tmp_path / "named.sock"))
    try:
        subprocess.run([start], check=True, timeout=LONG)
        with canwire.connect() as hub, open_driver(hub) as driver:
            assert hub.address == (str(tmp_path / "named.sock") if named else canwire.default_address())
            assert hub.note("acan") == b"2A0:7"
            assert not driver.initialised
            subprocess.run([start], check=True, timeout=LONG)  # the hub runs already
    finally:
        stopped = subprocess.run([stop], timeout=LONG)
    assert stopped.returncode == 0
