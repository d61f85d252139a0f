"""CanBitrate2 and CanFdBitrate: bit timings of Ixxat.Vci4.

Source: the vendor's published contract of Ixxat.Vci4 (names and figures); VCI V4 manual 7.3.4.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from canwire.vci.arguments import UINT16, UINT32
from canwire.vci.can.structures import CanBtp
from canwire.vci.net4.enums import CanBitrateMode
from canwire.vci.v3.errors import checked

_NONE, _RAW = CanBitrateMode.NONE, CanBitrateMode.RAW


@dataclass(frozen=True, slots=True)
class CanBitrate2:
    """One bit timing, and a name, which comparisons ignore.

    Without RAW, `prescaler` is the rate in bit/s and the other numbers are ratios, as in CANBTP; with RAW, it is the
    prescaler and the others are quanta. Raises ArgumentOutOfRangeException.
    """

    mode: CanBitrateMode
    prescaler: int
    time_segment1: int
    time_segment2: int
    sjw: int
    transmitter_delay: int
    name: str = field(default="not specified", compare=False)

    EMPTY: ClassVar[CanBitrate2]
    CIA_10_KBIT: ClassVar[CanBitrate2]
    CIA_20_KBIT: ClassVar[CanBitrate2]
    CIA_50_KBIT: ClassVar[CanBitrate2]
    CIA_125_KBIT: ClassVar[CanBitrate2]
    CIA_250_KBIT: ClassVar[CanBitrate2]
    CIA_500_KBIT: ClassVar[CanBitrate2]
    CIA_800_KBIT: ClassVar[CanBitrate2]
    CIA_1000_KBIT: ClassVar[CanBitrate2]
    KBIT_100: ClassVar[CanBitrate2]  # _100KBit in .NET
    CANFD_250_KBIT: ClassVar[CanBitrate2]
    CANFD_500_KBIT: ClassVar[CanBitrate2]
    CANFD_833_KBIT: ClassVar[CanBitrate2]
    CANFD_1000_KBIT: ClassVar[CanBitrate2]
    CANFD_1538_KBIT: ClassVar[CanBitrate2]
    CANFD_2000_KBIT: ClassVar[CanBitrate2]
    CANFD_4000_KBIT: ClassVar[CanBitrate2]
    CANFD_5000_KBIT: ClassVar[CanBitrate2]
    CANFD_6667_KBIT: ClassVar[CanBitrate2]
    CANFD_8000_KBIT: ClassVar[CanBitrate2]
    CANFD_10000_KBIT: ClassVar[CanBitrate2]
    IFI_833_KBIT: ClassVar[CanBitrate2]
    IFI_1000_KBIT: ClassVar[CanBitrate2]
    IFI_2000_KBIT: ClassVar[CanBitrate2]
    IFI_4000_KBIT: ClassVar[CanBitrate2]
    IFI_5000_KBIT: ClassVar[CanBitrate2]
    IFI_6667_KBIT: ClassVar[CanBitrate2]
    IFI_8000_KBIT: ClassVar[CanBitrate2]
    IFI_10000_KBIT: ClassVar[CanBitrate2]
    CANOPEN_ARB_125_KBIT: ClassVar[CanBitrate2]
    CANOPEN_ARB_250_KBIT: ClassVar[CanBitrate2]
    CANOPEN_ARB_500_KBIT: ClassVar[CanBitrate2]
    CANOPEN_ARB_800_KBIT: ClassVar[CanBitrate2]
    CANOPEN_ARB_1000_KBIT: ClassVar[CanBitrate2]
    CANOPEN_1000_KBIT: ClassVar[CanBitrate2]
    CANOPEN_2000_KBIT: ClassVar[CanBitrate2]
    CANOPEN_4000_KBIT: ClassVar[CanBitrate2]
    CANOPEN_5000_KBIT: ClassVar[CanBitrate2]
    CIA_BIT_RATES: ClassVar[tuple[CanBitrate2, ...]]
    CAN_FD_BIT_RATES: ClassVar[tuple[CanBitrate2, ...]]
    CAN_FD_IFI_BIT_RATES: ClassVar[tuple[CanBitrate2, ...]]

    def __post_init__(self) -> None:
        for name, high in zip(_WORDS, (UINT32, UINT32, UINT16, UINT16, UINT16, UINT16), strict=True):
            checked(name, getattr(self, name), high)

    def structure(self) -> CanBtp:
        """V4's structure for this timing."""
        return CanBtp(*(int(getattr(self, name)) for name in _WORDS))

    @classmethod
    def of(cls, btp: CanBtp) -> CanBitrate2:
        """The timing for V4's structure; a predefined one if it has the same numbers."""
        made = cls(CanBitrateMode(btp.mode), btp.bps, btp.ts1, btp.ts2, btp.sjw, btp.tdo)
        return _KNOWN.get(made, made)

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, init=False)
class CanFdBitrate:
    """The timings of a CAN FD bus: arbitration and fast data. If only one is given, it applies to both."""

    std_bitrate: CanBitrate2
    fast_bitrate: CanBitrate2

    CIA_BIT_RATES: ClassVar[tuple[CanFdBitrate, ...]]
    SHORT_LINE_CANFD_BIT_RATES: ClassVar[tuple[CanFdBitrate, ...]]
    LONG_LINE_CANFD_BIT_RATES: ClassVar[tuple[CanFdBitrate, ...]]
    CANOPEN_BIT_RATES: ClassVar[tuple[CanFdBitrate, ...]]

    def __init__(self, std_bitrate: CanBitrate2, fast_bitrate: CanBitrate2 | None = None) -> None:
        object.__setattr__(self, "std_bitrate", std_bitrate)
        object.__setattr__(self, "fast_bitrate", fast_bitrate or std_bitrate)


_WORDS = ("mode", "prescaler", "time_segment1", "time_segment2", "sjw", "transmitter_delay")
_FIGURES: dict[str, tuple[int, int, int, int, int]] = {  # bit/s, then TS1, TS2, SJW and TDO
    "CIA_10_KBIT": (10_000, 14, 2, 1, 0),
    "CIA_20_KBIT": (20_000, 14, 2, 1, 0),
    "CIA_50_KBIT": (50_000, 14, 2, 1, 0),
    "KBIT_100": (100_000, 14, 2, 1, 0),
    "CIA_125_KBIT": (125_000, 14, 2, 1, 0),
    "CIA_250_KBIT": (250_000, 14, 2, 1, 0),
    "CIA_500_KBIT": (500_000, 14, 2, 1, 0),
    "CIA_800_KBIT": (800_000, 8, 2, 1, 0),
    "CIA_1000_KBIT": (1_000_000, 6, 2, 1, 0),
    "CANFD_250_KBIT": (250_000, 6400, 1600, 1600, 6400),
    "CANFD_500_KBIT": (500_000, 6400, 1600, 1600, 6400),
    "CANFD_833_KBIT": (833_333, 1600, 400, 400, 6480),
    "CANFD_1000_KBIT": (1_000_000, 1600, 400, 400, 1600),
    "CANFD_1538_KBIT": (1_538_461, 1000, 300, 300, 1040),
    "CANFD_2000_KBIT": (2_000_000, 1600, 400, 400, 1600),
    "CANFD_4000_KBIT": (4_000_000, 800, 200, 200, 800),
    "CANFD_5000_KBIT": (5_000_000, 600, 200, 200, 600),
    "CANFD_6667_KBIT": (6_666_666, 400, 200, 200, 402),
    "CANFD_8000_KBIT": (8_000_000, 400, 100, 100, 250),
    "CANFD_10000_KBIT": (10_000_000, 300, 100, 100, 200),
    "CANOPEN_ARB_125_KBIT": (125_000, 800, 200, 200, 0),
    "CANOPEN_ARB_250_KBIT": (250_000, 800, 200, 200, 0),
    "CANOPEN_ARB_500_KBIT": (500_000, 800, 200, 200, 0),
    "CANOPEN_ARB_800_KBIT": (800_000, 800, 200, 200, 0),
    "CANOPEN_ARB_1000_KBIT": (1_000_000, 800, 200, 200, 0),
    "CANOPEN_1000_KBIT": (1_000_000, 800, 200, 200, 750),
    "CANOPEN_2000_KBIT": (2_000_000, 750, 250, 250, 770),
    "CANOPEN_4000_KBIT": (4_000_000, 700, 300, 300, 600),
    "CANOPEN_5000_KBIT": (5_000_000, 750, 250, 250, 750),
}
_RAW_FIGURES: dict[str, tuple[int, int, int, int, int]] = {  # the prescaler, then the same, at 80 MHz
    "IFI_833_KBIT": (6, 12, 3, 3, 78),
    "IFI_1000_KBIT": (4, 15, 4, 4, 64),
    "IFI_2000_KBIT": (2, 15, 4, 4, 32),
    "IFI_4000_KBIT": (2, 7, 2, 2, 16),
    "IFI_5000_KBIT": (2, 5, 2, 2, 12),
    "IFI_6667_KBIT": (2, 3, 2, 2, 8),
    "IFI_8000_KBIT": (2, 3, 1, 1, 5),
    "IFI_10000_KBIT": (2, 2, 1, 1, 4),
}
_WORD_OF = {"CIA": "CiA", "CANFD": "CAN FD", "IFI": "IFI CAN FD", "CANOPEN": "CANopen"}


def _title(name: str) -> str:
    first, *rest = name.removesuffix("_KBIT").removeprefix("KBIT_").split("_")
    return " ".join([_WORD_OF.get(first, first), *(word for word in rest if word != "ARB"), "kbit/s"])


def _rates(*names: str) -> tuple[CanBitrate2, ...]:
    return tuple(getattr(CanBitrate2, name) for name in names)


def _named(prefix: str, *kbits: int) -> tuple[CanBitrate2, ...]:
    return _rates(*(f"{prefix}_{kbit}_KBIT" for kbit in kbits))


CanBitrate2.EMPTY = CanBitrate2(_NONE, 0, 0, 0, 0, 0, "<empty>")
for _table, _mode in ((_FIGURES, _NONE), (_RAW_FIGURES, _RAW)):
    for _name, _figures in _table.items():
        setattr(CanBitrate2, _name, CanBitrate2(_mode, *_figures, _title(_name)))
CanBitrate2.CIA_BIT_RATES = _named("CIA", 10, 20, 50, 125, 250, 500, 800, 1000)
CanBitrate2.CAN_FD_BIT_RATES = _named("CANFD", 1000, 2000, 4000, 5000, 6667, 8000, 10000)
CanBitrate2.CAN_FD_IFI_BIT_RATES = _named("IFI", 1000, 2000, 4000, 5000, 6667, 8000, 10000)
_KNOWN = {rate: rate for rate in _rates("EMPTY", *reversed(_FIGURES), *_RAW_FIGURES)}

CanFdBitrate.CIA_BIT_RATES = tuple(map(CanFdBitrate, CanBitrate2.CIA_BIT_RATES))
CanFdBitrate.SHORT_LINE_CANFD_BIT_RATES = tuple(
    CanFdBitrate(CanBitrate2.CANFD_500_KBIT, fast) for fast in CanBitrate2.CAN_FD_BIT_RATES
)
CanFdBitrate.LONG_LINE_CANFD_BIT_RATES = tuple(
    CanFdBitrate(CanBitrate2.CANFD_250_KBIT, fast)
    for fast in _named("CANFD", 500, 833, 1000, 1538, 2000, 4000)
)
CanFdBitrate.CANOPEN_BIT_RATES = tuple(
    CanFdBitrate(slow, fast)
    for slow in _named("CANOPEN_ARB", 125, 250, 500, 800, 1000)
    for fast in _named("CANOPEN", 1000, 2000, 4000, 5000)
)
