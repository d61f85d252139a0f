"""Which part of a mode is for the controller, and which for the programs of its kin alone."""

from __future__ import annotations

from dataclasses import replace

from canwire.boards.can.hearing import controllers_own
from canwire.boards.can.modes import LineMode
from canwire.values.timing.bit_timing import BitTiming

MODE = LineMode(
    BitTiming.for_bit_rate(500_000, clock_hz=80_000_000),
    registers=(("ACR0", 0x20), ("OCR", 0x1A), ("AMR0", 7)),
)


def test_a_kins_acceptance_registers_do_not_reach_the_controller() -> None:
    assert controllers_own(replace(MODE, kin="acan")).registers == (("OCR", 0x1A),)
    assert controllers_own(MODE).registers == MODE.registers
