"""Registers through /dev/port, for which an ordinary file stands in here."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire.drivers.sja1000 import port_access
from canwire.drivers.sja1000.port_access import PortAccess
from canwire.errors import BadValue, Closed, NoSuchBoard, Unsupported
from canwire.values.isa_address import port_of

BASE = 0x280
CDR = port_of(31, BASE)


@pytest.fixture
def ports(tmp_path: Path) -> Path:
    """64 KiB in which nothing answers."""
    path = tmp_path / "port"
    path.write_bytes(b"\xff" * 0x10000)
    return path


@pytest.fixture
def access(ports: Path) -> Iterator[PortAccess]:
    access = PortAccess(BASE, str(ports))
    yield access
    access.close()


def poke(path: Path, port: int, value: int) -> None:
    with path.open("r+b") as file:
        file.seek(port)
        file.write(bytes([value]))


@pytest.mark.conforms("AC-02")
def test_registers_at_their_ports(ports: Path, access: PortAccess) -> None:
    expected = bytearray(b"\xff" * 0x10000)
    for register in range(128):
        access.write(register, register)
        expected[port_of(register, BASE)] = register
    assert ports.read_bytes() == expected
    assert [access.read(register) for register in range(128)] == list(range(128))
    assert access.read(130) == 2  # the board has seven address lines to the chip


@pytest.mark.parametrize("value", [-1, 256])
def test_values_that_are_no_bytes(access: PortAccess, value: int) -> None:
    with pytest.raises(BadValue, match="for port 680h: 0 to 0xFF"):
        access.write(32, value)


# detection


@pytest.mark.conforms("AC-05")
@pytest.mark.parametrize("divider", [0x00, 0x07, 0xC8, 0x85])
def test_an_sja1000_answers(ports: Path, access: PortAccess, divider: int) -> None:
    poke(ports, CDR, divider)
    before = ports.read_bytes()
    assert access.answers()
    assert ports.read_bytes() == before


@pytest.mark.conforms("AC-05")
def test_nothing_answers_at_empty_ports(ports: Path, access: PortAccess) -> None:
    before = ports.read_bytes()
    assert not access.answers()
    assert ports.read_bytes() == before


@pytest.mark.conforms("AC-05")
def test_something_else_does_not_keep_what_is_written(
    ports: Path, access: PortAccess, monkeypatch: pytest.MonkeyPatch
) -> None:
    poke(ports, CDR, 0x05)
    written: list[tuple[bytes, int]] = []

    def pwrite(descriptor: int, data: bytes, port: int) -> int:
        written.append((data, port))
        return len(data)

    monkeypatch.setattr(os, "pwrite", pwrite)
    assert not access.answers()
    assert written == [(b"\x02", CDR), (b"\x05", CDR)]  # tried, and put back


def test_only_the_clocks_divisor_is_tried(
    ports: Path, access: PortAccess, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Mode and comparator stay as they are, even of a chip in reset mode."""
    poke(ports, CDR, 0xC8)
    written: list[int] = []
    really = os.pwrite

    def pwrite(descriptor: int, data: bytes, port: int) -> int:
        assert port == CDR
        written.append(data[0])
        return really(descriptor, data, port)

    monkeypatch.setattr(os, "pwrite", pwrite)
    assert access.answers()
    assert {value & 0xF8 for value in written} == {0xC8}
    assert len({value & 0x07 for value in written}) > 2
    assert written[-1] == 0xC8


# refusals


def test_no_such_device(tmp_path: Path) -> None:
    with pytest.raises(NoSuchBoard) as error:
        PortAccess(BASE, str(tmp_path / "port"))
    assert str(error.value) == (
        f"{tmp_path / 'port'}: there is no such device; ports need Linux on a PC, "
        'or leave access = "port" out of canwire.toml to simulate the board'
    )


def test_a_system_without_ports(ports: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "pread")
    with pytest.raises(NoSuchBoard, match="this system has no port device"):
        PortAccess(BASE, str(ports))


def test_a_directory(tmp_path: Path) -> None:
    with pytest.raises(Unsupported, match="is no port device: Is a directory"):
        PortAccess(BASE, str(tmp_path))


@pytest.mark.parametrize("number", [1, 13])  # EPERM of a locked-down kernel, EACCES of the file's mode
def test_without_rights(ports: Path, monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    """Root may do everything here, so the refusal has to be made."""

    def refuse(path: str, flags: int) -> int:
        raise OSError(number, os.strerror(number), path)

    monkeypatch.setattr(port_access.os, "open", refuse)
    with pytest.raises(Unsupported) as error:
        PortAccess(BASE, str(ports))
    assert str(error.value) == (
        f"{ports}: no rights to use ports: it takes root with CAP_SYS_RAWIO, and a kernel that is not locked "
        'down; or leave access = "port" out of canwire.toml to simulate the board'
    )


@pytest.mark.skipif(os.geteuid() == 0, reason="root may open everything")
def test_a_file_that_others_own(ports: Path) -> None:
    ports.chmod(0)
    with pytest.raises(Unsupported, match="no rights to use ports"):
        PortAccess(BASE, str(ports))


def test_a_device_that_ends_early(tmp_path: Path) -> None:
    path = tmp_path / "port"
    path.write_bytes(bytes(0x300))
    access = PortAccess(BASE, str(path))
    assert access.read(31) == 0
    with pytest.raises(NoSuchBoard, match="it ends before port 680h; it is no port device"):
        access.read(32)
    access.close()


def test_a_device_that_fails_later(access: PortAccess, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*arguments: object) -> bytes:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(os, "pread", fail)
    monkeypatch.setattr(os, "pwrite", fail)
    with pytest.raises(Unsupported, match="Input/output error"):
        access.read(0)
    with pytest.raises(Unsupported, match="Input/output error"):
        access.write(0, 0)


@pytest.mark.parametrize("base", [0x290, 0])
def test_a_base_that_no_board_can_have(ports: Path, base: int) -> None:
    with pytest.raises(BadValue, match="base address"):
        PortAccess(base, str(ports))


# closing


def test_closed(access: PortAccess) -> None:
    access.close()
    access.close()
    with pytest.raises(Closed, match=r"port at 280h is closed"):
        access.read(0)
    with pytest.raises(Closed):
        access.write(0, 0)
    with pytest.raises(Closed):
        access.answers()


def test_forgotten(ports: Path) -> None:
    def descriptors() -> int:
        """Of this file; threads of earlier tests may open and close others meanwhile."""
        return sum(os.path.realpath(path) == os.path.realpath(ports) for path in Path("/dev/fd").iterdir())

    access = PortAccess(BASE, str(ports))
    assert descriptors() == 1
    del access
    gc.collect()
    assert descriptors() == 0
