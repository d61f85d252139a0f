"""CanBitrate: bit rates as register values of an SJA1000.

Source: VCI V3 .NET manual 4.2.4.1; reference/vci.md sections 3 and 7a.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from canwire.vci.structures import constants as c
from canwire.vci.v3.errors import checked

_REGISTER = 0xFF


@dataclass(frozen=True, slots=True)
class CanBitrate:
    """Registers BTR0 and BTR1 of an SJA1000 at 16 MHz, 0 to 255 each, and a name, which comparisons ignore.

    Raises ArgumentOutOfRangeException.

    >>> CanBitrate.CIA_500_KBIT.bittime
    32
    """

    btr0: int
    btr1: int
    name: str = field(default="", compare=False)

    EMPTY: ClassVar[CanBitrate]
    CIA_10_KBIT: ClassVar[CanBitrate]
    CIA_20_KBIT: ClassVar[CanBitrate]
    CIA_50_KBIT: ClassVar[CanBitrate]
    CIA_125_KBIT: ClassVar[CanBitrate]
    CIA_250_KBIT: ClassVar[CanBitrate]
    CIA_500_KBIT: ClassVar[CanBitrate]
    CIA_800_KBIT: ClassVar[CanBitrate]
    CIA_1000_KBIT: ClassVar[CanBitrate]
    KBIT_100: ClassVar[CanBitrate]  # CanBitrate.100KBit in the manual, _100KBit in .NET
    CIA_BIT_RATES: ClassVar[tuple[CanBitrate, ...]]

    def __post_init__(self) -> None:
        checked("btr0", self.btr0, _REGISTER)
        checked("btr1", self.btr1, _REGISTER)
        if not self.name:
            object.__setattr__(self, "name", f"{self.btr0:02X}:{self.btr1:02X}")

    @property
    def as_int16(self) -> int:
        """AsInt16: BTR1 in the high byte, BTR0 in the low byte, signed like .NET's Int16."""
        word = self.btr1 << 8 | self.btr0
        return word - 0x1_0000 if word & 0x8000 else word

    @property
    def bittime(self) -> int:
        """Bittime: the number of periods of the 16 MHz clock in a bit; the bit rate is 16 000 000 / bittime."""
        return 2 * ((self.btr0 & 0x3F) + 1) * ((self.btr1 & 0xF) + (self.btr1 >> 4 & 7) + 3)

    def __str__(self) -> str:
        return self.name


CanBitrate.EMPTY = CanBitrate(0, 0, "<empty>")
CanBitrate.CIA_10_KBIT = CanBitrate(c.CAN_BT0_10KB, c.CAN_BT1_10KB, "CiA 10 kbit/s")
CanBitrate.CIA_20_KBIT = CanBitrate(c.CAN_BT0_20KB, c.CAN_BT1_20KB, "CiA 20 kbit/s")
CanBitrate.CIA_50_KBIT = CanBitrate(c.CAN_BT0_50KB, c.CAN_BT1_50KB, "CiA 50 kbit/s")
CanBitrate.CIA_125_KBIT = CanBitrate(c.CAN_BT0_125KB, c.CAN_BT1_125KB, "CiA 125 kbit/s")
CanBitrate.CIA_250_KBIT = CanBitrate(c.CAN_BT0_250KB, c.CAN_BT1_250KB, "CiA 250 kbit/s")
CanBitrate.CIA_500_KBIT = CanBitrate(c.CAN_BT0_500KB, c.CAN_BT1_500KB, "CiA 500 kbit/s")
CanBitrate.CIA_800_KBIT = CanBitrate(c.CAN_BT0_800KB, c.CAN_BT1_800KB, "CiA 800 kbit/s")
CanBitrate.CIA_1000_KBIT = CanBitrate(c.CAN_BT0_1000KB, c.CAN_BT1_1000KB, "CiA 1000 kbit/s")
CanBitrate.KBIT_100 = CanBitrate(c.CAN_BT0_100KB, c.CAN_BT1_100KB, "100 kbit/s")
CanBitrate.CIA_BIT_RATES = (
    CanBitrate.CIA_10_KBIT,
    CanBitrate.CIA_20_KBIT,
    CanBitrate.CIA_50_KBIT,
    CanBitrate.CIA_125_KBIT,
    CanBitrate.CIA_250_KBIT,
    CanBitrate.CIA_500_KBIT,
    CanBitrate.CIA_800_KBIT,
    CanBitrate.CIA_1000_KBIT,
)

_KNOWN = {rate: rate for rate in (CanBitrate.EMPTY, *CanBitrate.CIA_BIT_RATES, CanBitrate.KBIT_100)}


def named(rate: CanBitrate) -> CanBitrate:
    """The predefined rate with the same registers, which has a name; the rate itself if there is none."""
    return _KNOWN.get(rate, rate)
