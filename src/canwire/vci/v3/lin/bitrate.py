"""LinBitrate: bit rates of LIN.

Source: VCI V3 .NET manual 4.3.4.1; reference/vci.md sections 4 and 7a.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from canwire.vci.arguments import UINT16
from canwire.vci.lin import constants as c
from canwire.vci.v3.errors import checked

_NAMES = {c.LIN_BITRATE_UNDEF: "Undefined", c.LIN_BITRATE_AUTO: "Automatic"}


@dataclass(frozen=True, slots=True)
class LinBitrate:
    """A bit rate in bit/s, 0 to 65535, and a name, which comparisons ignore.

    A line accepts MIN_BITRATE to MAX_BITRATE, and AUTO_RATE if it is a slave that can detect the bit rate. Raises
    ArgumentOutOfRangeException.

    >>> LinBitrate.LIN_19200_BIT.as_uint16
    19200
    """

    as_uint16: int
    name: str = field(default="", compare=False)

    UNDEFINED: ClassVar[LinBitrate]
    AUTO_RATE: ClassVar[LinBitrate]
    MIN_BITRATE: ClassVar[LinBitrate]
    MAX_BITRATE: ClassVar[LinBitrate]
    LIN_1000_BIT: ClassVar[LinBitrate]
    LIN_1200_BIT: ClassVar[LinBitrate]
    LIN_2400_BIT: ClassVar[LinBitrate]
    LIN_4800_BIT: ClassVar[LinBitrate]
    LIN_9600_BIT: ClassVar[LinBitrate]
    LIN_10400_BIT: ClassVar[LinBitrate]
    LIN_19200_BIT: ClassVar[LinBitrate]
    LIN_20000_BIT: ClassVar[LinBitrate]

    def __post_init__(self) -> None:
        checked("bitrate", self.as_uint16, UINT16)
        if not self.name:
            object.__setattr__(self, "name", _NAMES.get(self.as_uint16, f"{self.as_uint16} bit/s"))

    def __str__(self) -> str:
        return self.name


LinBitrate.UNDEFINED = LinBitrate(c.LIN_BITRATE_UNDEF)
LinBitrate.AUTO_RATE = LinBitrate(c.LIN_BITRATE_AUTO)
LinBitrate.MIN_BITRATE = LinBitrate(c.LIN_BITRATE_MIN, "Lowest")
LinBitrate.MAX_BITRATE = LinBitrate(c.LIN_BITRATE_MAX, "Highest")
LinBitrate.LIN_1000_BIT = LinBitrate(c.LIN_BITRATE_1000)
LinBitrate.LIN_1200_BIT = LinBitrate(c.LIN_BITRATE_1200)
LinBitrate.LIN_2400_BIT = LinBitrate(c.LIN_BITRATE_2400)
LinBitrate.LIN_4800_BIT = LinBitrate(c.LIN_BITRATE_4800)
LinBitrate.LIN_9600_BIT = LinBitrate(c.LIN_BITRATE_9600)
LinBitrate.LIN_10400_BIT = LinBitrate(c.LIN_BITRATE_10400)
LinBitrate.LIN_19200_BIT = LinBitrate(c.LIN_BITRATE_19200)
LinBitrate.LIN_20000_BIT = LinBitrate(c.LIN_BITRATE_20000)
