"""The capabilities that the simulated boards report.

These are simulated figures. Clocks, register ranges and controller types are the published ones of the real
boards; the divisors of the timers are not published, and are our choice (source: rulings.md 11, reference/vci.md
sections 3 and 8).
"""

from __future__ import annotations

from dataclasses import replace

from canwire.boards.description import Capabilities, Feature, Ticks, TimingRange

LOW_SPEED, HIGH_SPEED = 1, 2  # CAN_BUSC_LOWSPEED, CAN_BUSC_HIGHSPEED
SJA1000, BXCAN, IFICFD = 0x05, 0x0C, 0x0D  # CAN_CTRL_SJA1000, CAN_CTRL_BXCAN, CAN_CTRL_IFICFD

_LARGEST_TICKS = 65_535
_CLASSIC = (
    Feature.STANDARD_AND_EXTENDED
    | Feature.REMOTE_FRAMES
    | Feature.ERROR_FRAMES
    | Feature.BUS_LOAD
    | Feature.ID_FILTER
    | Feature.LISTEN_ONLY
    | Feature.SCHEDULER
    | Feature.DELAYED_TRANSMISSION
    | Feature.SINGLE_SHOT
    | Feature.HIGH_PRIORITY
    | Feature.AUTO_BAUD
)
_FD = Feature.EXTENDED_DATA | Feature.FAST_DATA | Feature.ISO_FRAME | Feature.NON_ISO_FRAME

_FD_CLOCK_HZ = 80_000_000
_FD_NOMINAL = TimingRange(prescaler=(2, 513), tseg1=(1, 256), tseg2=(1, 256), sjw=(1, 128))
# VCI's presets for the data phase use an offset of 128 periods at most (CAN_BTP_DBR_LL_500KB).
_FD_DATA = TimingRange(prescaler=(2, 513), tseg1=(1, 256), tseg2=(1, 256), sjw=(1, 128), offset_max=255)

USB_TO_CAN_FD = Capabilities(
    controller_type=IFICFD,
    bus_coupling=HIGH_SPEED,
    features=int(_CLASSIC | _FD),
    clock_hz=_FD_CLOCK_HZ,
    nominal=_FD_NOMINAL,
    data=_FD_DATA,
    stamps=Ticks(_FD_CLOCK_HZ, 80, 0xFFFF_FFFF),  # 1 us
    cyclic=Ticks(_FD_CLOCK_HZ, 8_000, _LARGEST_TICKS),  # 100 us
    delay=Ticks(_FD_CLOCK_HZ, 8_000, _LARGEST_TICKS),  # 100 us
)
"""A CAN line of the USB-to-CAN FD."""

_CLASSIC_CLOCK_HZ = 36_000_000

USB_TO_CAN = Capabilities(
    controller_type=BXCAN,
    bus_coupling=HIGH_SPEED | LOW_SPEED,
    features=int(_CLASSIC),
    clock_hz=_CLASSIC_CLOCK_HZ,
    nominal=TimingRange(prescaler=(1, 1024), tseg1=(1, 16), tseg2=(1, 8), sjw=(1, 4)),
    data=None,
    stamps=Ticks(_CLASSIC_CLOCK_HZ, 36, 0xFFFF_FFFF),  # 1 us
    cyclic=Ticks(_CLASSIC_CLOCK_HZ, 3_600, _LARGEST_TICKS),  # 100 us
    delay=Ticks(_CLASSIC_CLOCK_HZ, 3_600, _LARGEST_TICKS),  # 100 us
)
"""A CAN line of the USB-to-CAN V2, which knows classic CAN only."""

SJA1000_CLOCK_HZ = 8_000_000  # half its crystal

SJA1000_LINE = Capabilities(
    controller_type=SJA1000,
    bus_coupling=HIGH_SPEED,
    features=int(_CLASSIC & ~Feature.HIGH_PRIORITY),  # the chip has one transmit buffer
    clock_hz=SJA1000_CLOCK_HZ,
    nominal=TimingRange(prescaler=(1, 64), tseg1=(1, 16), tseg2=(1, 8), sjw=(1, 4)),
    data=None,
    stamps=Ticks(SJA1000_CLOCK_HZ, 8, 0xFFFF_FFFF),  # 1 us
    cyclic=Ticks(SJA1000_CLOCK_HZ, 800, _LARGEST_TICKS),  # 100 us
    delay=Ticks(SJA1000_CLOCK_HZ, 800, _LARGEST_TICKS),  # 100 us
)
"""A line with an SJA1000 at 16 MHz (source: SJA1000 data sheet 6.5)."""

PASSIVE_LINE = replace(SJA1000_LINE, features=SJA1000_LINE.features & ~int(Feature.SCHEDULER), cyclic=Ticks())
"""The line of a board without a processor, which has no cyclic list (VCI V4 manual 5.2.5)."""

MCP2515_LINE = Capabilities(
    controller_type=0,  # CAN_CTRL_UNKNOWN: VCI has no number for it
    bus_coupling=HIGH_SPEED,
    features=int(_CLASSIC & ~Feature.HIGH_PRIORITY),  # its three buffers are one for each send channel
    clock_hz=SJA1000_CLOCK_HZ,
    nominal=TimingRange(prescaler=(1, 64), tseg1=(2, 16), tseg2=(2, 8), sjw=(1, 4)),
    data=None,
    stamps=Ticks(SJA1000_CLOCK_HZ, 8, 0xFFFF_FFFF),  # 1 us
    cyclic=Ticks(SJA1000_CLOCK_HZ, 800, _LARGEST_TICKS),  # 100 us
    delay=Ticks(SJA1000_CLOCK_HZ, 800, _LARGEST_TICKS),  # 100 us
)
"""A line with an MCP2515 at 16 MHz (source: MCP2515 data sheet, DS20001801, 5.0)."""

_ADAPTER = (
    Feature.STANDARD_AND_EXTENDED
    | Feature.REMOTE_FRAMES
    | Feature.ERROR_FRAMES
    | Feature.ID_FILTER
    | Feature.SCHEDULER
    | Feature.DELAYED_TRANSMISSION
)

SERIAL_ADAPTER = replace(SJA1000_LINE, features=int(_ADAPTER | Feature.LISTEN_ONLY))
"""A real adapter that speaks the CANBUS dongle's protocol: an SJA1000 as well, of which it shows less."""

ADAPTER = replace(USB_TO_CAN, bus_coupling=HIGH_SPEED, features=int(_ADAPTER))
"""Any adapter: its bit rate counts, its registers are its own."""

FD_ADAPTER = replace(
    USB_TO_CAN_FD,
    features=int(_ADAPTER | Feature.EXTENDED_DATA | Feature.FAST_DATA | Feature.ISO_FRAME),
)
"""The same where it knows CAN FD."""

SERIAL_FD_ADAPTER = replace(FD_ADAPTER, features=FD_ADAPTER.features | Feature.LISTEN_ONLY)
"""A serial adapter that knows CANable's letters for CAN FD."""
