"""CanBitrate: registers of the manual's table (4.2.4.1) and of reference/vci.md section 3."""

from __future__ import annotations

import dataclasses

import pytest

from canwire.vci.v3 import ArgumentOutOfRangeException, CanBitrate
from tests.cases import each

RATES = [
    (10, CanBitrate.CIA_10_KBIT, 0x31, 0x1C),
    (20, CanBitrate.CIA_20_KBIT, 0x18, 0x1C),
    (50, CanBitrate.CIA_50_KBIT, 0x09, 0x1C),
    (100, CanBitrate.KBIT_100, 0x04, 0x1C),
    (125, CanBitrate.CIA_125_KBIT, 0x03, 0x1C),
    (250, CanBitrate.CIA_250_KBIT, 0x01, 0x1C),
    (500, CanBitrate.CIA_500_KBIT, 0x00, 0x1C),
    (800, CanBitrate.CIA_800_KBIT, 0x00, 0x16),
    (1000, CanBitrate.CIA_1000_KBIT, 0x00, 0x14),
]


@pytest.mark.conforms("X3-11")
@each(("kbit", "rate", "btr0", "btr1"), RATES)
def test_predefined_rates(kbit: int, rate: CanBitrate, btr0: int, btr1: int) -> None:
    assert (rate.btr0, rate.btr1) == (btr0, btr1)
    assert 16_000_000 / rate.bittime == kbit * 1000
    assert rate.as_int16 == btr1 << 8 | btr0
    assert f"{kbit} kbit/s" in rate.name


@pytest.mark.conforms("X3-11")
def test_the_cia_list_leaves_out_100_kbit() -> None:
    assert list(CanBitrate.CIA_BIT_RATES) == [rate for kbit, rate, _, _ in RATES if kbit != 100]


def test_empty() -> None:
    assert (CanBitrate.EMPTY.btr0, CanBitrate.EMPTY.btr1) == (0, 0)


def test_names() -> None:
    assert CanBitrate(0x31, 0x1C).name == "31:1C"
    assert str(CanBitrate(1, 2, "mine")) == "mine"
    assert CanBitrate(0x31, 0x1C) == CanBitrate.CIA_10_KBIT


def test_as_int16_is_signed() -> None:
    assert CanBitrate(0x00, 0x9C).as_int16 == 0x9C00 - 0x10000


@each(("btr0", "btr1"), [(-1, 0), (0, 256), (1.5, 0)])
def test_registers_hold_a_byte(btr0: int, btr1: int) -> None:
    with pytest.raises(ArgumentOutOfRangeException):
        CanBitrate(btr0, btr1)


def test_it_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        CanBitrate.CIA_10_KBIT.btr0 = 1  # type: ignore[misc]
