"""Chips that a test attaches to a lab's bus by hand are warned of as nodes are."""

from __future__ import annotations

import pytest

from canwire import BitTiming, Lab
from canwire.bus.can.node import Node
from canwire.chips.mcp2515 import register_map as mcp
from canwire.chips.mcp2515.controller import Mcp2515
from canwire.chips.sja1000 import register_map as sja
from canwire.chips.sja1000.controller import Sja1000

AT_500K, AT_250K = (0x00, 0x1C), (0x01, 0x1C)
EARLY = (0x00, 0x67)  # 500 kbit/s, sampled at 56 %


def sja1000(bus: object, btr: tuple[int, int]) -> Sja1000:
    chip = Sja1000(bus)
    chip.write(sja.CDR, sja.CDR_PELICAN)
    chip.write(sja.BTR0, btr[0])
    chip.write(sja.BTR1, btr[1])
    chip.write(sja.MOD, sja.MOD_AFM)
    return chip


def mcp2515(bus: object, cnf1: int) -> Mcp2515:
    chip = Mcp2515(bus)
    for address, value in ((mcp.CNF1, cnf1), (mcp.CNF2, 0xAC), (mcp.CNF3, 0x03)):
        chip.write(address, value)
    chip.write(mcp.CANCTRL, mcp.NORMAL << mcp.REQOP_SHIFT)
    return chip


def told(lab: Lab, make: object) -> list[tuple[str, tuple[str, ...]]]:
    bus = lab.can_bus(timing=BitTiming.from_btr(*AT_500K))
    bus.node("a")
    make(bus)  # type: ignore[operator]
    return [(found.what, found.nodes) for found in bus.warnings]


def test_an_sja1000_at_another_rate(lab: Lab) -> None:
    assert told(lab, lambda bus: sja1000(bus, AT_250K)) == [("bit rates", ("a", "SJA1000 no. 1"))]


def test_an_mcp2515_at_another_rate(lab: Lab) -> None:
    assert told(lab, lambda bus: mcp2515(bus, 0x01)) == [("bit rates", ("a", "MCP2515 no. 1"))]


def test_chips_at_the_rate_of_the_bus(lab: Lab) -> None:
    assert told(lab, lambda bus: (sja1000(bus, AT_500K), mcp2515(bus, 0x00))) == []


def test_a_chip_in_reset_mode_takes_no_part(lab: Lab) -> None:
    assert told(lab, lambda bus: sja1000(bus, AT_250K).write(sja.MOD, sja.MOD_RM)) == []


def test_a_chip_that_is_unplugged_is_warned_of_no_more(lab: Lab) -> None:
    bus = lab.can_bus(timing=BitTiming.from_btr(*AT_500K))
    bus.node("a")
    chip = sja1000(bus, AT_250K)
    assert len(bus.warnings) == 1
    bus.wire.detach(chip)
    assert bus.warnings == []


def test_a_chip_has_its_own_name_and_a_drift(lab: Lab) -> None:
    def make(bus: object) -> None:
        chip = Sja1000(bus)
        chip.name, chip.oscillator_ppm = "gauge", 30_000.0
        for address, value in ((sja.BASIC_BTR0, AT_500K[0]), (sja.BASIC_BTR1, AT_500K[1]), (sja.BASIC_CR, 0)):
            chip.write(address, value)

    assert told(lab, make) == [("oscillators", ("a", "gauge"))]


def test_a_long_cable_counts_for_a_chip_too(lab: Lab) -> None:
    bus = lab.can_bus(timing=BitTiming.from_btr(*AT_500K), length_m=140)
    bus.node("a")
    assert bus.warnings == []
    sja1000(bus, EARLY)
    assert [(found.what, found.nodes) for found in bus.warnings] == [("cable", ("SJA1000 no. 1",))]


def test_a_node_that_says_nothing_of_its_timing_is_left_out(lab: Lab) -> None:
    def make(bus: object) -> None:
        node = Node()
        node.on_bus = True
        bus.wire.attach(node)  # type: ignore[attr-defined]

    assert told(lab, make) == []


@pytest.mark.parametrize("count", [1, 2])
def test_a_stalled_bus_names_the_chip(lab: Lab, count: int) -> None:
    bus = lab.can_bus(timing=BitTiming.from_btr(*AT_500K))
    for _ in range(count):
        sja1000(bus, AT_250K)
    node = bus.node("a")
    for found in bus.warnings:
        assert found.nodes == ("a", *(f"SJA1000 no. {k + 1}" for k in range(count)))
    assert len(bus.warnings) == 1
    assert node.settings.timing.bit_rate == 500_000
