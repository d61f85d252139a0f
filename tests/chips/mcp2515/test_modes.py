"""The MCP2515's modes: how they are entered and left, what they let happen, sleep and waking up."""

from __future__ import annotations

import pytest

from canwire import Frame
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.controller import Mcp2515
from tests.cases import each
from tests.chips.mcp2515.bench import Bench, ask, frame_of, load, mode_of, send

pytestmark = pytest.mark.core

A, B = Frame(0x111, b"a"), Frame(0x222, b"bb")


@pytest.fixture(params=[False, True], ids=["skipping", "bitwise"])
def bench(request: pytest.FixtureRequest) -> Bench:
    return Bench(bitwise=request.param)


@pytest.mark.parametrize("before", [0, 2, 3, 4])
@pytest.mark.parametrize("after", range(5))
def test_from_every_mode_to_every_other(bench: Bench, before: int, after: int) -> None:
    chip = bench.chip(before)
    assert mode_of(chip) == before
    ask(chip, after)
    assert mode_of(chip) == after
    assert chip.read(m.CANCTRL) >> 5 == after
    bench.bits(20)
    assert (chip.on_bus, chip.asleep) == (after in (m.NORMAL, m.LISTEN_ONLY), after == m.SLEEP)


@each("wrong", [5, 6, 7])
def test_what_is_no_mode_changes_nothing(wrong: int) -> None:
    chip = Mcp2515()
    chip.write(m.CANCTRL, 0)
    ask(chip, wrong)
    assert mode_of(chip) == m.NORMAL


def test_after_configuration_mode_11_recessive_bits_are_waited_for(bench: Bench) -> None:
    chip = bench.chip(m.CONFIGURATION)
    ask(chip, m.NORMAL)
    bench.bits(10)
    assert not chip.on_bus
    bench.bits(2)
    assert chip.on_bus


@pytest.mark.parametrize("mode", [1, 2, 3, 4])
def test_a_mode_waits_until_everything_is_sent(bench: Bench, mode: int) -> None:
    partner, chip = bench.partner(), bench.chip()
    send(chip, A, 0)
    send(chip, B, 1)
    ask(chip, mode)
    assert mode_of(chip) == m.NORMAL
    bench.bits(75)
    assert mode_of(chip) == m.NORMAL
    bench.bits(150)
    assert mode_of(chip) == mode
    assert partner.heard() == [B, A]


@pytest.mark.parametrize("mode", [1, 2, 3, 4])
def test_a_mode_waits_until_a_frame_that_is_received_is_over(bench: Bench, mode: int) -> None:
    partner, chip = bench.partner(), bench.chip()
    bench.partner("another")
    partner.send(A)
    bench.bits(20)
    ask(chip, mode)
    assert mode_of(chip) == m.NORMAL
    bench.bits(60)
    assert mode_of(chip) == mode
    assert frame_of(chip.read_buffer(0)) == A


def test_a_mode_waits_until_an_error_frame_is_over(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    bench.faults.flip(bit="dlc", seen_by=chip)
    partner.send(A)
    bench.bits(21)
    ask(chip, m.CONFIGURATION)
    assert mode_of(chip) == m.NORMAL
    bench.bits(200)
    assert mode_of(chip) == m.CONFIGURATION


def test_what_can_not_be_sent_holds_the_mode_until_it_is_given_up(bench: Bench) -> None:
    chip = bench.chip()
    send(chip, A)
    ask(chip, m.CONFIGURATION)
    bench.bits(3000)
    assert mode_of(chip) == m.NORMAL
    chip.modify(m.CANCTRL, m.CTRL_ABAT, m.CTRL_ABAT)
    bench.bits(200)
    assert mode_of(chip) == m.CONFIGURATION


def test_configuration_mode_clears_the_counters(bench: Bench) -> None:
    chip = bench.chip()
    chip.modify(m.CANCTRL, m.CTRL_OSM, m.CTRL_OSM)
    for _ in range(13):
        send(chip, A)
        bench.bits(200)
    assert (chip.read(m.TEC), chip.read(m.EFLG)) == (104, 0x05)
    ask(chip, m.CONFIGURATION)
    assert (chip.read(m.TEC), chip.read(m.EFLG)) == (0, 0)


def test_reset_in_the_middle_of_a_frame(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    send(chip, Frame(0x123, bytes(8)))
    bench.bits(30)
    chip.reset()
    assert (mode_of(chip), chip.read(m.TXBCTRL[0]), chip.read(m.CNF2)) == (m.CONFIGURATION, 0, 0)
    bench.bits(300)
    assert partner.heard() == []
    assert partner.line.driver.counters().rec > 0  # the others saw it break off


def test_listen_only_hears_and_is_not_heard(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip(m.LISTEN_ONLY)
    send(chip, B)
    partner.send(A)
    bench.bits(3000)
    assert partner.line.driver.counters().tec == 128  # nobody acknowledges
    assert (chip.read(m.TEC), chip.read(m.REC), chip.read(m.EFLG)) == (0, 0, m.EFLG_RX0OVR)
    assert chip.read(m.CANINTF) == m.INT_MERR | m.INT_RX0 | m.INT_ERR  # a passive sender's frames look good
    chip.read_buffer(0)
    bench.partner("another")
    bench.bits(300)
    assert frame_of(chip.read_buffer(0)) == A
    assert chip.read(m.TXBCTRL[0]) == m.TX_TXREQ
    ask(chip, m.NORMAL)
    bench.bits(200)
    assert partner.heard() == [B]


def test_loop_back_hears_only_itself(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip(m.LOOP_BACK, bukt=True)
    bench.partner("another")
    partner.send(A)
    send(chip, B)
    assert chip.read(m.CANINTF) == 0
    bench.bits(60)
    assert chip.read(m.CANINTF) == 0
    bench.bits(16)
    assert chip.read(m.CANINTF) == m.INT_TX0 | m.INT_RX0
    assert frame_of(chip.read_buffer(0)) == B
    assert partner.heard() == []
    for buffer in range(2):
        load(chip, buffer, Frame(buffer, b""), buffer)
    chip.request_to_send(0b11)
    ask(chip, m.NORMAL)
    assert mode_of(chip) == m.LOOP_BACK
    bench.bits(200)
    assert mode_of(chip) == m.NORMAL
    assert [frame_of(chip.read_buffer(number)).id for number in (0, 1)] == [1, 0]
    assert chip.read(m.TEC) == 0


def test_filters_count_in_loop_back_too(bench: Bench) -> None:
    chip = bench.chip(m.CONFIGURATION, rxm=m.RXM_FILTERS)
    for place, octet in enumerate(bytes.fromhex("FFE00000")):
        chip.write(m.RXM[0] + place, octet)
        chip.write(m.RXM[1] + place, octet)
    chip.write(m.RXF[4], 0x111 >> 3)
    chip.write(m.RXF[4] + 1, (0x111 & 7) << 5)
    ask(chip, m.LOOP_BACK)
    send(chip, B)
    bench.bits(100)
    assert chip.read(m.CANINTF) == m.INT_TX0
    send(chip, A)
    bench.bits(100)
    assert chip.read(m.CANINTF) == m.INT_TX0 | m.INT_RX1
    assert chip.read(m.RXBCTRL[1]) & 7 == 4


def test_a_frame_wakes_and_is_lost(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip(m.SLEEP)
    bench.partner("another")
    assert (mode_of(chip), chip.clkout_hz) == (m.SLEEP, 0)
    partner.send(A)
    bench.bits(5)
    assert (mode_of(chip), chip.read(m.CANINTF)) == (m.LISTEN_ONLY, m.INT_WAK)
    assert chip.read(m.CANSTAT) & 0x0E == 4
    assert chip.listen_only  # it acknowledges nothing until its processor asks for a mode
    bench.bits(100)
    assert chip.read(m.CANINTF) == m.INT_WAK
    partner.send(B)
    bench.bits(100)
    assert frame_of(chip.read_buffer(0)) == B
    ask(chip, m.NORMAL)
    assert mode_of(chip) == m.NORMAL
    send(chip, A)
    bench.bits(100)
    assert partner.heard() == [A]


def test_without_wakie_it_sleeps_on(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip(m.SLEEP, enabled=0xFF & ~m.INT_WAK)
    bench.partner("another")
    partner.send(A)
    bench.bits(100)
    assert (mode_of(chip), chip.read(m.CANINTF)) == (m.SLEEP, 0)
    chip.modify(m.CANINTF, m.INT_WAK, m.INT_WAK)
    assert mode_of(chip) == m.SLEEP
    chip.write(m.CANINTF, 0)
    chip.write(m.CANINTE, m.INT_WAK)
    partner.send(B)
    bench.bits(100)
    assert mode_of(chip) == m.LISTEN_ONLY


def test_the_processor_wakes_it(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip(m.SLEEP)
    send(chip, A)
    ask(chip, m.NORMAL)  # is not heard
    bench.bits(100)
    assert mode_of(chip) == m.SLEEP
    chip.modify(m.CANINTF, m.INT_WAK, m.INT_WAK)
    assert (mode_of(chip), chip.interrupt) == (m.LISTEN_ONLY, True)
    ask(chip, m.NORMAL)
    bench.bits(5)
    assert not chip.on_bus
    bench.bits(200)
    assert (mode_of(chip), partner.heard()) == (m.NORMAL, [A])


def test_registers_can_be_read_asleep(bench: Bench) -> None:
    chip = bench.chip(m.SLEEP)
    assert (chip.read(m.CNF2), chip.read(m.CANINTE)) == (0xAC, 0xFF)
    chip.reset()
    assert (mode_of(chip), chip.asleep) == (m.CONFIGURATION, False)


def test_a_short_wakes_it(bench: Bench) -> None:
    bench.partner()
    chip = bench.chip(m.SLEEP)
    bench.faults.short()
    bench.bits(5)
    assert mode_of(chip) == m.LISTEN_ONLY


def test_bus_off_ends_in_listen_only_mode(bench: Bench) -> None:
    bench.partner()
    chip = bench.chip()
    bench.faults.flip(bit="dlc", seen_by="sender", times=None)
    send(chip, A)
    bench.bits(32 * 45)
    assert chip.read(m.EFLG) & m.EFLG_TXBO
    chip.modify(m.TXBCTRL[0], m.TX_TXREQ, 0)
    ask(chip, m.LISTEN_ONLY)
    assert (mode_of(chip), chip.read(m.EFLG)) == (m.LISTEN_ONLY, 0)
    bench.bits(20)
    assert chip.on_bus


# three special cases: docs/mcp2515.md


@pytest.mark.finding("linux 5")
def test_in_bus_off_a_frame_to_send_holds_the_mode_until_it_is_aborted(bench: Bench) -> None:
    bench.partner()
    chip = off_the_bus(bench)
    ask(chip, m.SLEEP)
    bench.bits(100)
    assert (mode_of(chip), chip.read(m.TXBCTRL[0]) & m.TX_TXREQ) == (m.NORMAL, m.TX_TXREQ)
    chip.modify(m.CANCTRL, m.CTRL_ABAT, m.CTRL_ABAT)
    assert (mode_of(chip), chip.read(m.TXBCTRL[0])) == (m.SLEEP, m.TX_ABTF | m.TX_TXERR)


@pytest.mark.finding("linux 5")
def test_in_bus_off_a_mode_that_was_asked_for_comes_when_the_frame_has_gone_out_after_recovery(
    bench: Bench,
) -> None:
    partner = bench.partner()
    chip = off_the_bus(bench)
    ask(chip, m.CONFIGURATION)
    bench.faults.clear()
    bench.bits(128 * 11 + 200)
    assert (mode_of(chip), partner.heard()) == (m.CONFIGURATION, [A])


def off_the_bus(bench: Bench) -> Mcp2515:
    """A chip that has gone bus-off with a frame it still has to send."""
    chip = bench.chip()
    bench.faults.flip(bit="dlc", seen_by="sender", times=None)
    send(chip, A)
    bench.bits(32 * 45)
    assert chip.read(m.EFLG) & m.EFLG_TXBO
    return chip


@pytest.mark.finding("linux 5")
def test_a_chip_that_falls_asleep_with_wakif_set_wakes_at_once(bench: Bench) -> None:
    """Closed in the middle of a frame and opened again before it ends: sleep is entered after WAKIF was set."""
    partner, chip = bench.partner(), bench.chip(enabled=m.INT_WAK)
    partner.send(A)
    bench.bits(20)
    ask(chip, m.SLEEP)
    assert mode_of(chip) == m.NORMAL
    chip.modify(m.CANINTF, m.INT_WAK, m.INT_WAK)
    bench.bits(100)
    assert (mode_of(chip), chip.asleep) == (m.LISTEN_ONLY, False)


@pytest.mark.finding("linux 5")
def test_wakie_written_after_wakif_wakes_too(bench: Bench) -> None:
    bench.partner()
    chip = bench.chip(m.SLEEP, enabled=0)
    chip.modify(m.CANINTF, m.INT_WAK, m.INT_WAK)
    assert mode_of(chip) == m.SLEEP
    chip.write(m.CANINTE, m.INT_WAK)
    assert (mode_of(chip), chip.interrupt) == (m.LISTEN_ONLY, True)


@pytest.mark.finding("linux 5")
def test_errif_of_an_overflow_can_be_cleared_once_rxnovr_is(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    for _ in range(2):
        partner.send(A)
    bench.bits(300)
    assert chip.read(m.EFLG) == m.EFLG_RX0OVR
    chip.modify(m.CANINTF, m.INT_ERR, 0)
    assert chip.read(m.CANINTF) & m.INT_ERR
    chip.modify(m.EFLG, m.EFLG_RX0OVR, 0)
    assert chip.read(m.CANINTF) & m.INT_ERR  # until it is written once more
    chip.modify(m.CANINTF, m.INT_ERR, 0)
    assert not chip.read(m.CANINTF) & m.INT_ERR
