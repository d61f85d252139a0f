"""The MCP2515's registers and instructions, without a bus: every address, every bit, every row of its tables."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadTiming, BadValue
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.controller import Mcp2515
from canwire.chips.mcp2515.modes import timing_of
from tests.cases import each
from tests.effort import examples
from tests.tables import mcp2515_vectors as table

pytestmark = pytest.mark.core

ALL = range(m.ADDRESSES)
BYTE = st.integers(0, 255)
ADDRESS = st.integers(0, 127)


def in_mode(mode: int) -> Mcp2515:
    chip = Mcp2515()
    chip.write(m.CANCTRL, mode << m.REQOP_SHIFT | 0x07)
    assert chip.read(m.CANSTAT) >> m.REQOP_SHIFT == mode
    return chip


def test_every_address_is_a_register() -> None:
    named = {register.address for register in m.MAP.registers}
    assert {m.canonical(address) for address in ALL} == named
    assert len({register.name for register in m.MAP.registers}) == len(m.MAP.registers) == 114


@pytest.mark.smoke
@pytest.mark.parametrize(("address", "name", "value", "writable"), table.REGISTERS)
def test_reset_values_and_writable_bits(address: int, name: str, value: int, writable: int) -> None:
    register = m.MAP.named(name)
    assert (register.address, m.WRITABLE[address]) == (address, writable)
    chip = Mcp2515()
    assert chip.read(address) == value
    if address not in (m.CANCTRL, *m.TXBCTRL):
        chip.write(address, 0xFF)
        bukt1 = m.RX_BUKT1 if address == m.RXBCTRL[0] else 0
        assert chip.read(address) == writable | bukt1
    chip.reset()
    known = "x" not in register.after_hardware
    assert chip.read(address) == (value if known or address in (m.CANCTRL, *m.TXBCTRL) else writable)


@each("mode", range(5))
def test_what_configuration_mode_alone_lets_be_written(mode: int) -> None:
    at_rest = {address for first, last in table.AT_REST for address in range(first, last + 1)}
    assert at_rest == m.AT_REST
    chip = in_mode(mode)
    for address in at_rest:
        chip.write(address, 0xA5)
        chip.modify(address, 0xFF, 0xA5)
    changed = {address for address in at_rest if chip.cells[address]}
    assert changed == (at_rest if mode == m.CONFIGURATION else set())


def test_filters_and_masks_read_as_0_outside_configuration_mode() -> None:
    chip = Mcp2515()
    for address in m.HIDDEN:
        chip.write(address, 0xE3)
    assert all(chip.read(address) for address in m.HIDDEN)
    chip.write(m.CANCTRL, 0)
    assert not any(chip.read(address) for address in m.HIDDEN)
    chip.write(m.CANCTRL, m.CONFIGURATION << m.REQOP_SHIFT)
    assert all(chip.read(address) for address in m.HIDDEN)


def test_status_and_control_are_in_every_row() -> None:
    chip = in_mode(m.LISTEN_ONLY)
    assert {chip.read(row | 0x0E) for row in range(0, 128, 16)} == {0x60}
    for row in range(0, 128, 16):
        chip.write(row | 0x0F, 0x60 | row >> 5)
        assert chip.read(0x0F) == 0x60 | row >> 5


@given(ADDRESS, BYTE, BYTE, BYTE)
def test_bit_modify_takes_its_mask_where_the_map_says_so(
    address: int, before: int, mask: int, value: int
) -> None:
    at = m.canonical(address)
    if at in (m.CANCTRL, m.CANINTF, m.EFLG, *m.TXBCTRL) or at not in m.WRITABLE:
        return
    chip, other = Mcp2515(), Mcp2515()
    chip.write(address, before)
    other.write(address, before)
    chip.modify(address, mask, value)
    kept = mask if at in m.MODIFIABLE else 0xFF
    other.write(address, (other.read(address) & ~kept) | (value & kept))
    assert chip.read(address) == other.read(address)


@examples(100)
@given(st.lists(st.tuples(st.sampled_from("rwm"), ADDRESS, BYTE, BYTE), max_size=60))
def test_any_access_leaves_a_chip_that_makes_sense(accesses: list[tuple[str, int, int, int]]) -> None:
    chip = Mcp2515()
    for kind, address, mask, value in accesses:
        if kind == "w":
            chip.write(address, value)
        elif kind == "m":
            chip.modify(address, mask, value)
        else:
            assert chip.read(address) == chip.peek(address) <= 0xFF
        assert chip.read(m.CANSTAT) & 0x11 == 0
        assert chip.read(m.CANSTAT) >> m.REQOP_SHIFT <= m.CONFIGURATION
        assert chip.interrupt == bool(chip.read(m.CANINTE) & chip.read(m.CANINTF))
        assert (chip.read(m.TEC), chip.read(m.REC), chip.read(m.EFLG) & 0x3F) == (0, 0, 0)
        for register in m.MAP.registers:
            there = sum(bit.mask for bit in register.bits) if register.bits else 0xFF
            assert chip.read(register.address) & ~there == 0
    chip.reset()
    assert (chip.read(m.CANSTAT), chip.read(m.CANCTRL), chip.interrupt) == (0x80, 0x87, False)


@each(("flags", "code"), table.ICOD)
def test_interrupt_codes(flags: int, code: int) -> None:
    chip = Mcp2515()
    chip.write(m.CANINTF, flags)
    assert (chip.read(m.CANSTAT) >> 1 & 7, chip.interrupt) == (0, False)  # none is enabled
    chip.write(m.CANINTE, flags)
    assert (chip.read(m.CANSTAT) >> 1 & 7, chip.interrupt) == (code, flags != 0)


def test_int_is_told_once_until_it_has_been_inactive() -> None:
    chip = Mcp2515()
    told: list[int] = []
    chip.on_interrupt = lambda: told.append(chip.read(m.CANINTF))
    chip.write(m.CANINTE, 0x03)
    chip.write(m.CANINTF, 0x01)
    chip.write(m.CANINTF, 0x03)
    assert told == [0x01]
    chip.modify(m.CANINTF, 0xFF, 0)
    chip.modify(m.CANINTF, 0x02, 0x02)
    assert told == [0x01, 0x02]


@each(("flags", "requested", "status"), table.READ_STATUS)
def test_read_status(flags: int, requested: tuple[int, ...], status: int) -> None:
    chip = Mcp2515()
    chip.write(m.CANINTF, flags)
    for control, bit in zip(m.TXBCTRL, requested, strict=True):
        chip.write(control, bit * m.TX_TXREQ)
    assert chip.read_status() == status


@each(("flags", "control0", "low0", "control1", "low1", "status"), table.RX_STATUS)
def test_rx_status(flags: int, control0: int, low0: int, control1: int, low1: int, status: int) -> None:
    chip = Mcp2515()
    chip.write(m.CANINTF, flags)
    for at, control, low in ((m.RXBCTRL[0], control0, low0), (m.RXBCTRL[1], control1, low1)):
        chip.cells[at], chip.cells[at + m.SIDL] = control, low
    assert chip.rx_status() == status


def test_the_buffers_instructions() -> None:
    chip = Mcp2515()
    chip.load_buffer(1, bytes(range(0xF0, 0xFD)))
    assert [chip.read(0x41 + k) for k in range(13)] == [
        0xF0, 0xF1 & 0xEB, 0xF2, 0xF3, 0xF4 & 0x4F, *range(0xF5, 0xFD)]  # fmt: skip
    chip.request_to_send(0b010)
    chip.load_buffer(1, bytes(13))
    chip.write(0x46, 0x55)
    assert (chip.read(0x41), chip.read(0x46)) == (0xF0, 0xF5)  # what is to be sent stays
    chip.cells[0x71:0x7E] = bytes(range(13))
    chip.write(m.CANINTF, 0x03)
    assert chip.read_buffer(1) == bytes(range(13))
    assert chip.read(m.CANINTF) == 0x01
    for wrong in (
        lambda: chip.load_buffer(3, b""),
        lambda: chip.load_buffer(0, bytes(14)),
        lambda: chip.read_buffer(2),
    ):
        with pytest.raises(BadValue):
            wrong()


@each(("cnf1", "cnf2", "cnf3", "rate", "quanta", "sampled", "jump"), table.CNF)
def test_bit_timing(cnf1: str, cnf2: str, cnf3: str, rate: int, quanta: int, sampled: int, jump: int) -> None:
    timing = timing_of(int(cnf1, 16), int(cnf2, 16), int(cnf3, 16), 16_000_000)
    assert (timing.bit_rate, timing.quanta, 1 + timing.tseg1, timing.sjw) == (rate, quanta, sampled, jump)
    chip = Mcp2515()
    for address, value in zip((m.CNF1, m.CNF2, m.CNF3), (cnf1, cnf2, cnf3), strict=True):
        chip.write(address, int(value, 16))
    chip.write(m.CANCTRL, 0)
    assert (chip.bit_ps, chip.sample_ps) == (timing.bit_time_ps, timing.sample_time_ps)


def test_another_crystal() -> None:
    chip = Mcp2515(None, 20_000_000)
    for address, value in ((m.CNF1, 0x01), (m.CNF2, 0x98), (m.CNF3, 0x03)):
        chip.write(address, value)
    chip.oscillator_ppm = 100.0
    chip.write(m.CANCTRL, 0)
    assert chip.bit_ps == round(2_000_000 / 1.0001)
    with pytest.raises(BadTiming):
        Mcp2515(None, 0)


@each(("tec", "rec", "flags"), table.EFLG)
def test_error_flags_follow_the_counters(tec: int, rec: int, flags: int) -> None:
    chip = Mcp2515()
    chip.confinement.tec, chip.confinement.rec = tec, rec
    chip._weigh()
    assert chip.read(m.EFLG) == flags
    assert chip.passive == (flags & 0x18 != 0 and tec < 256)
    assert (chip.read(m.TEC), chip.read(m.REC)) == (min(tec, 255), rec)
    assert bool(chip.read(m.CANINTF) & m.INT_ERR) == bool(flags)


def test_pins() -> None:
    chip = Mcp2515()
    assert chip.read(m.TXRTSCTRL) == 0x38  # inputs, pulled up
    chip.set_rts(1, False)
    assert chip.read(m.TXRTSCTRL) == 0x28
    assert chip.read(m.TXBCTRL[1]) == 0
    chip.set_rts(1, True)
    chip.write(m.TXRTSCTRL, 0x02)
    assert chip.read(m.TXRTSCTRL) == 0x2A
    chip.set_rts(1, False)
    assert chip.read(m.TXBCTRL[1]) == m.TX_TXREQ
    assert chip.buffer_full_pin(0) is None
    chip.write(m.BFPCTRL, 0x3C)
    assert (chip.buffer_full_pin(0), chip.buffer_full_pin(1)) == (True, True)
    chip.write(m.BFPCTRL, 0x1F)
    chip.write(m.CANINTF, 0x02)
    assert (chip.buffer_full_pin(0), chip.buffer_full_pin(1)) == (True, False)
    assert chip.clkout_hz == 2_000_000
    chip.write(m.CANCTRL, 0x84)
    assert chip.clkout_hz == 16_000_000
    chip.write(m.CANCTRL, 0x80)
    assert chip.clkout_hz == 0


def test_an_interrupt_flag_stays_while_its_condition_prevails() -> None:
    chip = Mcp2515()
    chip._overflow(m.EFLG_RX0OVR)
    chip.write(m.CANINTF, 0)
    assert chip.read(m.CANINTF) == m.INT_ERR
    chip.modify(m.EFLG, 0xFF, 0)
    chip.write(m.CANINTF, 0)
    assert chip.read(m.CANINTF) == 0
