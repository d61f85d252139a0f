"""The SJA1000's registers without other nodes: vectors R01 to R23, maps, access, reset values."""

from __future__ import annotations

import re
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadTiming, BadValue
from canwire.bus.can.bus import CanBus
from canwire.chips.registers import Access
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.timeline import Timeline
from tests.cases import each
from tests.chips.sja1000.bench import Bench
from tests.effort import examples
from tests.tables import sja1000_vectors

pytestmark = pytest.mark.core

STEP = re.compile(r"(HW|P)|(bits) (\d+)|W(\d+)=(\w+)|R(\d+)(?:&(\w+))?=(\w+)")


@pytest.mark.smoke
@pytest.mark.parametrize(
    ("number", "program"), sja1000_vectors.PROGRAMS, ids=[row[0] for row in sja1000_vectors.PROGRAMS]
)
def test_vectors_without_other_nodes(bench: Bench, number: str, program: str) -> None:
    chip = bench.bare()
    steps = STEP.findall(program)
    assert len(steps) == len(re.sub(r"bits \d", "b", program).split())
    for reset, bits, count, written, value, address, mask, expected in steps:
        if reset:
            chip.hardware_reset()
            if reset == "P":
                chip.write(m.CDR, m.CDR_PELICAN)
        elif bits:
            bench.bits(int(count))
        elif written:
            chip.write(int(written), int(value, 0))
        else:
            found = chip.read(int(address)) & int(mask or "0xFF", 0)
            assert found == int(expected, 0), f"{number} R{address}: {found:#04x}, not {expected}"


def test_all_vectors_are_there() -> None:
    assert [row[0] for row in sja1000_vectors.PROGRAMS] == [f"R{k:02}" for k in range(1, 24)]


@each("pelican", [False, True])
@each("resetting", [False, True])
def test_access_is_what_the_map_says(pelican: bool, resetting: bool) -> None:
    """Plain registers: what can be written reads back, what cannot stays; the rest reads as nothing."""
    chip = Sja1000()
    chip.write(m.CDR, m.CDR_PELICAN if pelican else 0)
    registers = m.PELICAN if pelican else m.BASIC
    if not resetting:
        chip.write(0, 0)
    special = {"MOD", "CMR", "SR", "IR", "CDR", "CR", "TXERR", "RXERR", "RBSA", "RMC"}
    for address in range(m.PELICAN_ADDRESSES if pelican else m.BASIC_ADDRESSES):
        readable = registers.at(address, resetting)
        writable = registers.at(address, resetting, Access.WRITE)
        if readable is None:
            assert chip.read(address) == (0x00 if pelican else 0xFF), address
        if (readable and readable.name in special) or (writable and writable.name in special):
            continue
        before = chip.peek(address)
        chip.write(address, 0x5A)
        if readable and readable is writable:
            assert chip.read(address) == 0x5A, readable.name
        else:
            assert chip.read(address) == before, address


@pytest.mark.parametrize("registers", [m.PELICAN, m.BASIC])
def test_reset_values_are_what_the_map_says(registers: Any) -> None:
    for filler in (0x00, 0xFF):
        chip = Sja1000()
        pelican = registers is m.PELICAN
        chip.write(m.CDR, m.CDR_PELICAN if pelican else 0)
        for address in (m.IER, *range(m.ACR0, m.AMR3 + 1)):
            chip.write(address, filler)
        chip.hardware_reset()
        if pelican:
            chip.write(m.CDR, m.CDR_PELICAN)
        for register in registers.readable(True):
            if register.name == "CDR":
                continue
            value = chip.peek(register.address)
            for place, wanted in zip(range(7, -1, -1), register.after_hardware, strict=True):
                if wanted != "x":
                    assert value >> place & 1 == int(wanted), (register.name, f"{value:08b}")


def test_the_motorola_pin_sets_the_clock_divider() -> None:
    chip = Sja1000(reset_mode_cdr=0x05)
    assert chip.read(m.CDR) == 0x05
    with pytest.raises(BadValue, match="reset_mode_cdr 7: 0x00"):
        Sja1000(reset_mode_cdr=7)
    with pytest.raises(BadTiming, match="oscillator_hz"):
        Sja1000(oscillator_hz=0)


def test_clkout_follows_the_divider() -> None:
    chip = Sja1000(oscillator_hz=24_000_000)
    expected = [12e6, 6e6, 4e6, 3e6, 2.4e6, 2e6, 24e6 / 14, 24e6]
    for code, frequency in enumerate(expected):
        chip.write(m.CDR, code)
        assert chip.clkout_hz == pytest.approx(frequency)
    chip.write(m.CDR, m.CDR_CLOCK_OFF)
    assert chip.clkout_hz == 0


@each(
    ("oscillator_hz", "btr0", "btr1", "bit_ps", "sample_ps", "jump_ps"),
    [
        (16_000_000, 0x00, 0x1C, 2_000_000, 1_750_000, 125_000),
        (16_000_000, 0x3F, 0x7F, 200_000_000, 136_000_000, 8_000_000),
        (16_000_000, 0x00, 0x14, 1_000_000, 750_000, 125_000),
        (24_000_000, 0xC0, 0x34, 833_333, 500_000, 333_332),
    ],
)
def test_bit_times_come_from_the_timing_registers(
    oscillator_hz: int, btr0: int, btr1: int, bit_ps: int, sample_ps: int, jump_ps: int
) -> None:
    chip = Sja1000(oscillator_hz=oscillator_hz)
    chip.write(m.BTR0, btr0)
    chip.write(m.BTR1, btr1)
    chip.write(m.MOD, 0)
    assert (chip.bit_ps, chip.sample_ps, chip.jump_ps) == (bit_ps, sample_ps, jump_ps)


def test_a_crystal_that_is_off_makes_longer_bits() -> None:
    chip = Sja1000()
    chip.oscillator_ppm = -1000
    chip.write(m.BTR1, 0x1C)
    chip.write(m.MOD, 0)
    assert chip.bit_ps == pytest.approx(2_002_002, abs=1)


def test_peek_has_no_side_effects(bench: Bench) -> None:
    chip = bench.chip()
    chip.write(m.CMR, m.CMR_TR | m.CMR_AT)
    bench.bits(100)
    assert chip.interrupt
    seen = [chip.peek(address) for address in range(128)]
    assert seen == [chip.peek(address) for address in range(128)]
    assert chip.interrupt
    assert seen == [chip.read(address) for address in range(128)]
    assert not chip.interrupt


def test_works_without_a_bus_and_waits_for_one() -> None:
    chip = Sja1000()
    chip.write(m.BTR1, 0x1C)
    chip.write(m.CDR, m.CDR_PELICAN)
    chip.write(m.MOD, 0)
    chip.write(m.CMR, m.CMR_TR)
    assert chip.read(m.SR) == 0x30
    timeline = Timeline()
    timeline.run_until(1_000_000)
    CanBus(timeline).attach(chip)
    timeline.run_until(1_022_000)
    assert timeline.now_ns == 1_022_000
    assert chip.read(m.SR) & m.SR_RS == 0
    chip.bus.detach(chip)
    assert chip.read(m.SR) == 0x00


@given(st.integers(0, 1 << 30), st.integers(0, 1 << 30))
def test_values_have_eight_bits_and_addresses_alias(address: int, value: int) -> None:
    chip = Sja1000()
    chip.write(m.CDR, m.CDR_PELICAN)
    chip.write(address & ~127 | m.BTR0, value)
    assert chip.read(m.BTR0) == value & 0xFF


ACCESSES = st.lists(
    st.tuples(st.integers(0, 3), st.one_of(st.integers(0, 31), st.integers(0, 127)), st.integers(0, 255)),
    max_size=200,
)


@examples(100)
@given(ACCESSES)
def test_nothing_that_is_written_breaks_a_chip(accesses: list[tuple[int, int, int]]) -> None:
    """Two chips, random accesses and time: everything stays a byte, and time goes on."""
    timeline = Timeline()
    bus = CanBus(timeline)
    chips = [Sja1000(bus), Sja1000(bus)]
    calls = []
    for chip in chips:
        chip.on_interrupt = lambda: calls.append(1)
        chip.write(m.BASIC_BTR1, 0x14)
        chip.write(m.CDR, m.CDR_PELICAN)
        chip.write(m.MOD, 0)
    for action, address, value in accesses:
        chip = chips[action & 1]
        if action & 2:
            chip.write(address, value)
        else:
            timeline.run_until(timeline.now_ns + value * 500)
            assert 0 <= chip.read(address) <= 255
        if chip.interrupt:
            assert chip.peek(m.IR) & ~(0xE0 if chip.peek(m.CDR) < 0x80 else 0)
    for chip in chips:
        assert all(0 <= chip.read(address) <= 255 for address in range(128))


def test_descriptions_name_the_bits() -> None:
    assert m.PELICAN.named("SR").describe(0x3C) == "TS RS TCS TBS"
    assert m.PELICAN.named("ECC").describe(0xD9) == "ERRC=other error DIR=TX SEG=acknowledge slot"
    assert m.PELICAN.named("ALC").describe(11) == "BITNO=SRTR"
    assert m.PELICAN.named("BTR1").describe(0x1C) == "SAM=1 TSEG2=2 TSEG1=13"
    assert m.PELICAN.named("OCR").describe(0x6A) == "TX1=pull-down OCPOL1 TX0=pull-down OCMODE=normal"
    assert m.PELICAN.named("RXERR").describe(12) == ""


@each(
    ("ocr", "dominant", "recessive"),
    [
        (0x6A, ("low", "float"), ("float", "low")),  # INduCAN104
        (0x1A, ("low", "float"), ("high", "float")),
        (0x1E, ("high", "float"), ("low", "float")),
        (0x12, ("float", "float"), ("high", "float")),
        (0x16, ("high", "float"), ("float", "float")),
        (0x0E, ("float", "float"), ("low", "float")),
        (0xDA, ("low", "low"), ("high", "high")),
        (0x1B, ("low", "clock"), ("high", "clock")),
        (0x02, ("float", "float"), ("float", "float")),
    ],
)
def test_output_pins(ocr: int, dominant: tuple[str, str], recessive: tuple[str, str]) -> None:
    chip = Sja1000()
    assert chip.output_pins(True) == ("float", "float")
    chip.write(m.OCR, ocr)
    chip.write(m.BASIC_CR, 0)
    chip.on_bus = True
    assert (chip.output_pins(True), chip.output_pins(False)) == (dominant, recessive)
