"""Registers as data: access, bits, patterns of reset values, and the SJA1000's two maps."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue
from canwire.chips.registers import Access, Bit, Register, RegisterAccess, RegisterFile, after_reset
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000

pytestmark = pytest.mark.core


def test_a_pattern_sets_clears_and_keeps() -> None:
    assert after_reset("0000xxx1", 0xFF) == 0x0F
    assert after_reset("0000xxx1", 0x00) == 0x01
    assert after_reset("xxxxxxxx", 0xA5) == 0xA5
    with pytest.raises(ValueError, match="shorter"):
        after_reset("01", 0)


def test_bits_describe_themselves() -> None:
    assert Bit("RM", 0).describe(1) == "RM"
    assert Bit("RM", 0).describe(2) == ""
    assert Bit("AFM", 3, 1, ((0, "dual"), (1, "single"))).describe(0) == "AFM=dual"
    assert Bit("DLC", 0, 4).describe(0x87) == "DLC=7"
    assert Bit("SEG", 0, 5, ((3, "start of frame"),)).describe(4) == "SEG=4"
    assert Bit("SEG", 2, 3).mask == 0x1C


def test_a_file_finds_its_registers() -> None:
    mode = Register("MOD", 0, Access.READ_WRITE, Access.READ_WRITE)
    sent, got = (
        Register("TX", 1, Access.WRITE, Access.NONE),
        Register("RX", 1, Access.READ, Access.NONE),
    )
    file = RegisterFile([mode, sent, got])
    assert file.named("RX") is got
    assert file.at(1, False) is got
    assert file.at(1, False, Access.WRITE) is sent
    assert file.at(1, True) is None
    assert file.readable(False) == (mode, got)
    with pytest.raises(BadValue, match="register 'XX': there is MOD, TX, RX"):
        file.named("XX")


def test_a_chip_is_register_access() -> None:
    access: RegisterAccess = Sja1000()
    access.write(m.BTR0, 0x12)
    assert access.read(m.BTR0) == 0x12


@pytest.mark.parametrize("registers", [m.PELICAN, m.BASIC])
def test_maps_are_sound(registers: RegisterFile) -> None:
    """Names are unique, an address has one register a direction and mode, bits do not overlap."""
    names = [register.name for register in registers.registers]
    assert len(set(names)) == len(names)
    for resetting in (False, True):
        for access in (Access.READ, Access.WRITE):
            there = [
                register.address for register in registers.registers if register.access(resetting) & access
            ]
            assert len(set(there)) == len(there)
    for register in registers.registers:
        masks = [bit.mask for bit in register.bits]
        assert sum(masks) == sum(1 << k for k in range(8) if any(mask >> k & 1 for mask in masks))
        assert len(register.after_hardware) == len(register.after_software) == 8


def test_every_address_of_the_data_sheet_is_there() -> None:
    pelican = {register.address for register in m.PELICAN.registers}
    assert set(range(112)) - pelican == {5, 9, 10}
    basic = {register.address for register in m.BASIC.registers}
    assert set(range(32)) - basic == {9, 30}


@given(st.sampled_from([*m.PELICAN.registers, *m.BASIC.registers]), st.integers(0, 255))
def test_every_value_can_be_described(register: Register, value: int) -> None:
    text = register.describe(value)
    assert text == text.strip()
    assert "  " not in text


def test_all_codes_have_names() -> None:
    assert len(m.ECC_SEGMENTS) == len(dict(m.ECC_SEGMENTS)) == 24
    assert dict(m.ALC_BITS) == {
        **{bit: f"ID.{28 - bit}" for bit in range(11)},
        11: "SRTR",
        12: "IDE",
        **{bit: f"ID.{30 - bit}" for bit in range(13, 31)},
        31: "RTR",
    }
