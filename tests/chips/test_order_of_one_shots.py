"""Drivers that send single shots and load the next frame when they are told: the order on the bus, both ways."""

from __future__ import annotations

from functools import partial

import pytest

from canwire.bus.can.bus import CanBus
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.values.frame import Frame
from tests.chips.sja1000.bench import BIT_NS, Bench, send

pytestmark = pytest.mark.core

SINGLE_SHOT = m.CMR_TR | m.CMR_AT
LATENCY_NS = 10_000
LONG = Frame(0x100, bytes(8))


class Driver:
    """Sends its frames one after another, as single shots; a while after each interrupt it loads the next."""

    def __init__(self, bench: Bench, chip: Sja1000, frames: list[Frame]) -> None:
        self.bench = bench
        self.chip = chip
        self.frames = frames
        chip.on_interrupt = self.notice

    def notice(self) -> None:
        timeline = self.bench.timeline
        timeline.at(timeline.now_ns + LATENCY_NS, self.serve)

    def serve(self) -> None:
        self.chip.read(m.IR)
        self.chip.read(m.ALC)
        self.chip.write(m.CMR, m.CMR_RRB)
        if self.frames and self.chip.read(m.SR) & m.SR_TBS:
            send(self.chip, self.frames.pop(0), SINGLE_SHOT)


@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.finding("linux 1")
def test_a_loser_that_is_told_at_once_loads_its_next_frame_before_the_winner_ends(bitwise: bool) -> None:
    bench = Bench()
    bench.bus.bitwise = bitwise
    heard: list[int] = []
    listener = bench.chip(m.MOD_AFM | m.MOD_LOM)
    listener.on_interrupt = partial(hear, listener, heard)
    drivers = [
        Driver(bench, bench.chip(), [Frame(0x200, bytes(8)), Frame(0x050, bytes(1))]),
        Driver(bench, bench.chip(), [LONG]),
        Driver(bench, bench.chip(), [Frame(0x101, bytes(8))] * 3),
    ]
    for driver in drivers:
        driver.serve()
    bench.bits(1_000)
    assert heard == [0x100, 0x050, 0x101]


def hear(chip: Sja1000, heard: list[int]) -> None:
    chip.read(m.IR)
    heard.append(chip.read(m.RX_WINDOW + 1) << 3 | chip.read(m.RX_WINDOW + 2) >> 5)
    chip.write(m.CMR, m.CMR_RRB)


@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.finding("linux 1")
def test_a_loser_shows_it_at_the_very_bit(bitwise: bool) -> None:
    """0x200 against 0x100 differ at bit 2 of the identifier, bit 3 of the frame; nothing is stuffed before it."""
    bench = Bench()
    bench.bus.bitwise = bitwise
    x, y = bench.chip(), bench.chip()
    send(x, Frame(0x200, bytes(1)))
    send(y, Frame(0x100, bytes(1)))
    assert status(bench.bus, x, 0.5) == (m.SR_TS, 0)
    lost_at = 1 + 1 + 0.875  # SOF, ID.10, ID.9
    assert status(bench.bus, x, lost_at) == (m.SR_TS, 0)
    assert status(bench.bus, x, lost_at + 0.01) == (m.SR_RS, m.IR_ALI)
    assert x.read(m.ALC) == 1
    assert status(bench.bus, y, 10) == (m.SR_TS, 0)


@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.finding("linux 1")
def test_a_lone_sender_finds_out_at_the_ack_slot(bitwise: bool) -> None:
    bench = Bench()
    bench.bus.bitwise = bitwise
    chip = bench.chip()
    send(chip, Frame(0x123), SINGLE_SHOT)  # no stuff bit but one: the ACK slot is bit 36
    slot = 36 + 0.875
    assert status(bench.bus, chip, slot) == (m.SR_TS, 0)
    assert chip.peek(m.TXERR) == 0
    ts, flags = status(bench.bus, chip, slot + 0.01)
    assert (ts, flags & m.IR_BEI, chip.peek(m.TXERR), chip.read(m.ECC)) == (m.SR_TS, m.IR_BEI, 8, 0xD9)
    last_of_intermission = 37 + 14 + 2 + 0.875
    assert status(bench.bus, chip, last_of_intermission)[0] == m.SR_TS
    assert status(bench.bus, chip, last_of_intermission + 0.01)[0] == 0


@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.finding("wire 9")
def test_ts_and_rs_last_through_the_intermission(bitwise: bool) -> None:
    bench = Bench()
    bench.bus.bitwise = bitwise
    x, y = bench.chip(), bench.chip()
    send(x, Frame(0x123, b"\x11\x22"))  # 62 bits
    end = 62 + 2 + 0.875
    assert (status(bench.bus, x, end)[0], status(bench.bus, y, end)[0]) == (m.SR_TS, m.SR_RS)
    assert (status(bench.bus, x, end + 0.01)[0], status(bench.bus, y, end + 0.01)[0]) == (0, 0)


_starts: dict[CanBus, int] = {}  # by the bus itself: an id may be given to the next one


def status(bus: CanBus, chip: Sja1000, bits: float) -> tuple[int, int]:
    """TS and RS, and the interrupt register, so many bits after the first call for this bus."""
    start_ns = _starts.setdefault(bus, bus.timeline.now_ns)
    bus.timeline.run_until(start_ns + round(bits * BIT_NS) - 1)
    return chip.peek(m.SR) & (m.SR_TS | m.SR_RS), chip.peek(m.IR)
