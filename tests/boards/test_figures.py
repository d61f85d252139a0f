"""The simulated figures against the published ones and the presets that programs bring along."""

from __future__ import annotations

from dataclasses import replace

import pytest

from canwire import BitTiming, Capabilities, Feature, TimingLimits, TimingRange
from canwire.boards import figures
from canwire.boards.figures import USB_TO_CAN, USB_TO_CAN_FD
from tests.cases import each

# CAN_BTP_ presets of VCI 4: bit/s, TS1, TS2, SJW, TDO (reference/vci.md section 3)
NOMINAL_PRESETS = [
    (5_000, 17, 8, 1, 0),
    *((rate, 14, 2, 1, 0) for rate in (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000)),
    (800_000, 8, 2, 1, 0),
    (1_000_000, 6, 2, 1, 0),
]
DATA_PRESETS = [
    (1_000_000, 1600, 400, 400, 1600),
    (2_000_000, 1600, 400, 400, 1600),
    (4_000_000, 800, 200, 200, 800),
    (5_000_000, 600, 200, 200, 600),
    (8_000_000, 400, 100, 100, 250),
    (10_000_000, 300, 100, 100, 200),
    (500_000, 6400, 1600, 1600, 6400),
    (833_333, 1600, 400, 400, 1620),
    (1_538_461, 1000, 300, 300, 1040),
]


def limits_of(found: TimingRange) -> TimingLimits:
    (low, high), (_, tseg1), (_, tseg2), (_, sjw) = found.prescaler, found.tseg1, found.tseg2, found.sjw
    return TimingLimits("board", high, tseg1, tseg2, sjw, 3, 1 + tseg1 + tseg2, prescaler_min=low)


@pytest.mark.parametrize(
    ("capabilities", "clock_hz", "ranges", "type_and_coupling"),
    [
        (USB_TO_CAN_FD, 80_000_000, ((2, 513), (1, 256), (1, 256), (1, 128)), (0x0D, 2)),
        (USB_TO_CAN, 36_000_000, ((1, 1024), (1, 16), (1, 8), (1, 4)), (0x0C, 3)),
        (figures.SJA1000_LINE, 8_000_000, ((1, 64), (1, 16), (1, 8), (1, 4)), (0x05, 2)),
        (figures.MCP2515_LINE, 8_000_000, ((1, 64), (2, 16), (2, 8), (1, 4)), (0, 2)),
    ],
)
def test_what_is_published_of_the_real_boards(
    capabilities: Capabilities, clock_hz: int, ranges: object, type_and_coupling: tuple[int, int]
) -> None:
    """reference/vci.md section 8; SJA1000 data sheet 6.5; MCP2515 data sheet 5.3, both with 16 MHz."""
    found = capabilities.nominal
    assert capabilities.clock_hz == clock_hz
    assert (found.prescaler, found.tseg1, found.tseg2, found.sjw) == ranges
    assert (capabilities.controller_type, capabilities.bus_coupling) == type_and_coupling


@pytest.mark.parametrize(
    "capabilities",
    [USB_TO_CAN_FD, USB_TO_CAN, figures.SJA1000_LINE, figures.MCP2515_LINE],
    ids=["fd", "classic", "sja1000", "mcp2515"],
)
def test_ticks_are_whole_nanoseconds(capabilities: Capabilities) -> None:
    ticks = (capabilities.stamps, capabilities.cyclic, capabilities.delay)
    assert [tick.tick_ns for tick in ticks] == [1_000, 100_000, 100_000]
    assert all(tick.divisor * 10**9 % tick.clock_hz == 0 for tick in ticks)
    assert [tick.maximum for tick in ticks] == [0xFFFF_FFFF, 65_535, 65_535]


def test_only_the_fd_board_knows_fd() -> None:
    fd = Feature.EXTENDED_DATA | Feature.FAST_DATA | Feature.ISO_FRAME | Feature.NON_ISO_FRAME
    assert USB_TO_CAN_FD.features ^ USB_TO_CAN.features == fd
    assert USB_TO_CAN_FD.can(fd)
    assert USB_TO_CAN_FD.data == replace(USB_TO_CAN_FD.nominal, offset_max=255)
    assert USB_TO_CAN.data is None


def test_what_the_other_boards_cannot_do() -> None:
    every = USB_TO_CAN.features
    assert every & ~figures.SJA1000_LINE.features == Feature.HIGH_PRIORITY
    assert every & ~figures.MCP2515_LINE.features == Feature.HIGH_PRIORITY
    assert every & ~figures.PASSIVE_LINE.features == Feature.HIGH_PRIORITY | Feature.SCHEDULER
    assert (figures.PASSIVE_LINE.cyclic.tick_ns, figures.SJA1000_LINE.cyclic.tick_ns) == (0, 100_000)
    adapter = Feature.LISTEN_ONLY | Feature.BUS_LOAD | Feature.SINGLE_SHOT | Feature.HIGH_PRIORITY
    assert every & ~figures.ADAPTER.features == adapter | Feature.AUTO_BAUD
    for plain, other in (
        (figures.ADAPTER, figures.SERIAL_ADAPTER),
        (figures.FD_ADAPTER, figures.SERIAL_FD_ADAPTER),
    ):
        assert plain.features ^ other.features == Feature.LISTEN_ONLY
    fd = Feature.EXTENDED_DATA | Feature.FAST_DATA | Feature.ISO_FRAME
    assert figures.ADAPTER.features ^ figures.FD_ADAPTER.features == fd


@each("preset", NOMINAL_PRESETS, ids=lambda preset: str(preset[0]))
@each("capabilities", [USB_TO_CAN_FD, USB_TO_CAN], ids=["fd", "classic"])
def test_nominal_presets_run(capabilities: Capabilities, preset: tuple[int, ...]) -> None:
    rate, ts1, ts2, sjw, _ = preset
    limits = limits_of(capabilities.nominal)
    timing = BitTiming.from_proportions(rate, ts1, ts2, sjw, capabilities.clock_hz, limits=limits)
    assert timing.bit_rate == rate


@each("preset", DATA_PRESETS, ids=lambda preset: str(preset[0]))
def test_data_presets_run(preset: tuple[int, ...]) -> None:
    rate, ts1, ts2, sjw, tdo = preset
    assert USB_TO_CAN_FD.data is not None
    limits = limits_of(USB_TO_CAN_FD.data)
    timing = BitTiming.from_proportions(rate, ts1, ts2, sjw, USB_TO_CAN_FD.clock_hz, limits=limits, tdo=tdo)
    assert rate in (int(timing.exact_bit_rate), timing.bit_rate)  # printed rates are rounded or cut
    assert timing.tdo <= USB_TO_CAN_FD.data.offset_max
