"""The INduCAN104's jumpers, ports, interrupt lines and LED, by its manual."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.boards.inducan104 import IRQS, InduCan104, Jumpers, checked_place
from canwire.boards.isa import IsaPlace
from canwire.errors import BadValue
from canwire.values.isa_address import BASES, port_of, register_at
from tests.cases import each

# E24 E23 E22 E21 E20, address: the manual's table, row by row
TABLE = [
    ("P NP P P P", 0x100),
    ("P NP P P NP", 0x120),
    ("P NP P NP P", 0x140),
    ("P NP P NP NP", 0x160),
    ("P NP NP P P", 0x180),
    ("P NP NP P NP", 0x1A0),
    ("P NP NP NP P", 0x1C0),
    ("P NP NP NP NP", 0x1E0),
    ("NP P P P P", 0x200),
    ("NP P P P NP", 0x220),
    ("NP P P NP P", 0x240),
    ("NP P P NP NP", 0x260),
    ("NP P NP P P", 0x280),
    ("NP P NP P NP", 0x2A0),
    ("NP P NP NP P", 0x2C0),
    ("NP P NP NP NP", 0x2E0),
    ("NP NP P P P", 0x300),
    ("NP NP P P NP", 0x320),
    ("NP NP P NP P", 0x340),
    ("NP NP P NP NP", 0x360),
    ("NP NP NP P P", 0x380),
    ("NP NP NP P NP", 0x3A0),
    ("NP NP NP NP P", 0x3C0),
    ("NP NP NP NP NP", 0x3E0),
]


class Chip:
    """128 registers that are nothing but memory, and an INT that a test moves."""

    def __init__(self) -> None:
        self.registers = bytearray(range(128))
        self.interrupt = False
        self.on_interrupt: Callable[[], None] | None = None

    def read(self, address: int) -> int:
        return self.registers[address]

    def write(self, address: int, value: int) -> None:
        self.registers[address] = value

    def request(self) -> None:
        self.interrupt = True
        assert self.on_interrupt is not None
        self.on_interrupt()


# jumpers


@pytest.mark.conforms("AC-01")
@each(("row", "base"), TABLE)
def test_the_manuals_table(row: str, base: int) -> None:
    jumpers = Jumpers.parse(row)
    assert jumpers.base == base
    assert Jumpers.for_base(base) == jumpers
    assert str(jumpers) == row


@pytest.mark.conforms("AC-01")
def test_as_delivered() -> None:
    assert str(Jumpers()) == "NP P NP P P"
    assert Jumpers().base == 0x280
    assert checked_place() == IsaPlace(0x280, 5)


@pytest.mark.conforms("AC-01")
def test_24_addresses_and_no_others() -> None:
    assert list(BASES) == [base for _, base in TABLE]
    refused = 0
    for bits in range(32):
        jumpers = Jumpers(*(bool(bits >> bit & 1) for bit in range(5)))
        if jumpers.address in BASES:
            assert Jumpers.for_base(jumpers.base) == jumpers
            continue
        refused += 1
        with pytest.raises(BadValue) as error:
            _ = jumpers.base
        assert str(error.value) == (
            f"jumpers E24..E20 {jumpers}: base address {jumpers.address:03X}h: "
            "100h, 120h, 140h and so on to 3E0h; usually 280h"
        )
    assert refused == 8


@pytest.mark.conforms("AC-01")
@each("base", [0, 0xE0, 0x281, 0x290, 0x400, 0x680, -32, True, 10**30])
def test_addresses_that_no_jumpers_set(base: int) -> None:
    for refusing in (Jumpers.for_base, checked_place, lambda base: port_of(0, base)):
        with pytest.raises(BadValue, match="base address"):
            refusing(base)


@each("text", ["", "NP P NP P", "NP P NP P P P", "NP P NP P X", "np p np p p"])
def test_text_that_is_no_jumpers(text: str) -> None:
    with pytest.raises(BadValue, match="for each of E24 E23 E22 E21 E20"):
        Jumpers.parse(text)


# ports


@pytest.mark.conforms("AC-02")
@each(
    ("register", "port"),
    [(0, 0x280), (31, 0x29F), (32, 0x680), (64, 0xA80), (96, 0xE80), (127, 0xE9F)],
)
def test_r45_pages(register: int, port: int) -> None:
    """R45 of reference/sja1000.md, and the pages that the manual gives."""
    assert port_of(register, 0x280) == port
    assert register_at(port, 0x280) == register


@given(st.sampled_from(BASES), st.integers(0, 127))
def test_every_register_has_one_port(base: int, register: int) -> None:
    port = port_of(register, base)
    assert register_at(port, base) == register
    assert [other for other in BASES if register_at(port, other) is not None] == [base]


@given(st.sampled_from(BASES), st.integers(0, 0xFFFF))
def test_every_port_by_its_address_lines(base: int, port: int) -> None:
    """A9..A5 select, A11, A10 and A4..A0 address, A15..A12 go nowhere."""
    lines = [port >> line & 1 for line in range(16)]
    selected = lines[5:10] == [base >> line & 1 for line in range(5, 10)]
    address = sum(bit << index for index, bit in enumerate([*lines[:5], *lines[10:12]]))
    assert register_at(port, base) == (address if selected else None)


@pytest.mark.parametrize("register", [-1, 128])
def test_registers_that_are_not_there(register: int) -> None:
    with pytest.raises(BadValue, match="0 to 127"):
        port_of(register, 0x280)


@pytest.mark.conforms("AC-02")
def test_reading_and_writing() -> None:
    chip = Chip()
    board = InduCan104(0x2A0, 7, chip)
    assert [board.read_port(port) for port in (0x2A0, 0x2BF, 0x6A0, 0xAA0, 0xEBF)] == [0, 31, 32, 64, 127]
    assert [board.read_port(port) for port in (0x280, 0x29F, 0x2C0, 0x680, 0)] == [0xFF] * 5
    board.write_port(0x6A1, 0xA5)
    assert chip.registers[33] == 0xA5
    before = bytes(chip.registers)
    board.write_port(0x681, 0x5A)
    assert chip.registers == before
    for value in (-1, 256):
        with pytest.raises(BadValue, match="for port 6A1h: 0 to 0xFF"):
            board.write_port(0x6A1, value)
    assert board.jumpers == Jumpers.for_base(0x2A0)


# interrupts


@pytest.mark.conforms("AC-03")
def test_the_levels() -> None:
    assert IRQS == (3, 4, 5, 7, 9, 10, 11)
    for irq in range(-1, 17):
        if irq in IRQS:
            assert InduCan104(0x280, irq, Chip()).place == IsaPlace(0x280, irq)
            continue
        with pytest.raises(BadValue) as error:
            InduCan104(0x280, irq, Chip())
        assert str(error.value) == f"IRQ {irq}: 3, 4, 5, 7, 9, 10 or 11; usually 5"


@pytest.mark.conforms("AC-03")
def test_the_led_is_the_interrupt() -> None:
    chip = Chip()
    board = InduCan104(0x280, 5, chip)
    assert not board.led
    chip.request()  # nobody serves it
    assert board.led
    chip.interrupt = False
    assert not board.led


@pytest.mark.conforms("AC-03")
def test_whoever_serves_the_interrupt_is_called() -> None:
    chip, served = Chip(), []
    board = InduCan104(0x280, 5, chip)
    board.on_irq = lambda: served.append(board.led)
    chip.request()
    assert served == [True]
