"""Clocks that are off, and slaves that find the bit rate out."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadTiming, BadValue, Lab, LinErrorKind, LinEventKind, LinFrame, LinState
from tests.cases import each

pytestmark = pytest.mark.core

DATA = bytes.fromhex("00ff55aa0180fe7f")


def exchange(rate: int, ppm: float, *, synchronises: bool = True, master_ppm: float = 0.0) -> list[str]:
    """A slave with this clock answers once and listens once; what went wrong at the slave, then at the master."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=rate)
        slave = bus.slave(responses={0x10: DATA}, oscillator_ppm=ppm, synchronises=synchronises)
        master = bus.master(oscillator_ppm=master_ppm)
        slave.events()
        master.events()
        master.ask(0x10, 8)
        master.send(LinFrame(0x11, DATA))
        lab.run_until_idle()
        told = [
            f"{node.name} {event.error.name}"
            for node in (slave, master)
            for event in node.events(LinEventKind.ERROR)
        ]
        if not told:
            assert (slave.receive(), master.receive()) == (LinFrame(0x11, DATA), LinFrame(0x10, DATA))
        return told


@each("rate", [1000, 9600, 19200, 20000])
@each("ppm", [-120_000, -20_000, 0, 20_000, 139_000])
def test_a_slave_that_synchronises_follows_within_14_percent(rate: int, ppm: float) -> None:
    assert exchange(rate, ppm) == []


@pytest.mark.parametrize("ppm", [-170_000, 170_000])
def test_beyond_that_it_cannot(ppm: float) -> None:
    missed = ["slave SYNC"] * 2 if ppm > 0 else []  # by a slow clock the break has 10.8 bits, and is none
    assert exchange(19200, ppm) == [*missed, "master SLNORE"]


def test_a_break_that_is_too_short_for_a_slow_slave() -> None:
    """13 bits are 10.8 of a clock that is 17 % slow, and no break."""
    with Lab() as lab:
        bus = lab.lin_bus()
        slave = bus.slave(oscillator_ppm=-170_000)
        slave.events()
        bus.master().ask(1)
        lab.run_until_idle()
        assert slave.counters.headers == 0


@each(("ppm", "fine"), [(-15_000, True), (15_000, True), (40_000, True), (-80_000, False)])
def test_a_slave_with_a_crystal_does_not_synchronise(ppm: float, fine: bool) -> None:
    told = exchange(19200, ppm, synchronises=False)
    assert (told == []) == fine


@each("master_ppm", [-5_000, 5_000])
@each("ppm", [-15_000, 15_000])
def test_the_tolerances_of_the_specification_always_work(master_ppm: float, ppm: float) -> None:
    assert exchange(19200, ppm, synchronises=False, master_ppm=master_ppm) == []
    assert exchange(19200, 9 * ppm, master_ppm=master_ppm) == []


def test_all_follow_the_master_s_clock() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.slave(responses={0x10: DATA})
        master = bus.master(oscillator_ppm=-100_000)
        master.ask(0x10)
        frame = master.expect(0x10, within=0.1)
        assert frame.timestamp_ns == pytest.approx(124 * 50_000 / 0.9, abs=1)


# automatic bit rate (VCI's AUTO)


@pytest.mark.conforms("X3-37")
@each("rate", [1000, 1200, 2400, 4800, 9600, 10400, 10417, 19200, 20000])
def test_a_slave_finds_the_bit_rate_with_the_first_header(rate: int) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=rate)
        slave = bus.slave(responses={0x10: DATA}, bit_rate=0)
        master = bus.master()
        assert slave.bit_rate == 0
        master.ask(0x10, 8)
        assert master.expect(0x10, within=1.0).data == DATA
        assert slave.bit_rate == rate
        master.send(LinFrame(0x11, b"\1"))
        assert slave.expect(0x11, within=1.0).data == b"\1"
        assert slave.counters.errors == (0,) * 9


@given(st.integers(1000, 20000))
def test_any_rate_is_found(rate: int) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=rate)
        slave = bus.slave(bit_rate=0)
        bus.master().send(LinFrame(1, b"\1"))
        lab.run_until_idle()
        assert (slave.bit_rate, slave.receive()) == (rate, LinFrame(1, b"\1"))


def test_a_silent_bus_tells_no_rate() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(sleep_after=None)
        slave = bus.slave(bit_rate=0)
        lab.run_for(10)
        assert (slave.bit_rate, slave.state) == (0, LinState.OPERATIONAL)


def test_a_wake_up_pulse_tells_no_rate() -> None:
    """Slow enough it looks like a break, but no sync field follows."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=1000)
        slave, other = bus.slave(bit_rate=0), bus.slave("other")
        slave.events()
        other.wake()
        lab.run_for(1.0)
        assert slave.bit_rate == 0
        assert slave.events(LinEventKind.ERROR) == []


@each(("bits", "rate"), [(9, 0), (10, 0), (11, 20_000), (13, 20_000)])
def test_a_break_that_tells_the_rate_has_11_bits(bits: int, rate: int) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave(bit_rate=0)
        bus.faults.short_break(bits)
        bus.master().ask(1)
        lab.run_until_idle()
        assert slave.bit_rate == rate


def test_sync_bytes_without_a_break_tell_no_rate() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave("late", bit_rate=0)
        slave.stop()
        bus.slave(responses={1: b"\x55" * 8})
        master = bus.master()
        master.ask(1, 8)
        lab.run_until(36 * 50_000)
        slave.start()  # into the response
        lab.run_until_idle()
        assert slave.bit_rate == 0
        master.ask(1, 8)
        lab.run_until_idle()
        assert slave.bit_rate == 20_000  # whatever it has seen before


@pytest.mark.conforms("X3-37")
def test_rates_and_clocks_that_cannot_be() -> None:
    with Lab() as lab:
        with pytest.raises(BadValue, match="LIN runs at 1000 to 20000"):
            lab.lin_bus("fast", bit_rate=20_001)
        bus = lab.lin_bus()
        with pytest.raises(BadTiming, match="oscillator_ppm 300000"):
            bus.slave(oscillator_ppm=300_000)
        with pytest.raises(BadTiming, match="break_bits 12: from 13 to 60"):
            bus.master(break_bits=12)
        with pytest.raises(BadTiming, match="start_up_ns 200000000"):
            bus.slave(start_up=0.2)
        with pytest.raises(BadValue, match="999"):
            bus.slave(bit_rate=999)


def test_slaves_of_another_bit_rate_hear_nothing() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=19200)
        slave = bus.slave(responses={0x10: DATA}, bit_rate=9600)
        master = bus.master()
        slave.events()
        master.events()
        master.ask(0x10, 8)
        lab.run_until_idle()
        assert [event.error for event in master.events(LinEventKind.ERROR)] == [LinErrorKind.SLNORE]
        assert slave.counters.headers == 0
