"""Converts the settings of a line for an adapter, and the version of an adapter for a board."""

from __future__ import annotations

from canwire.drivers.driver import LineSettings
from canwire.drivers.slcan_dongle.user import Setup
from canwire.errors import BadTiming, Unsupported

_DATA_SHEET_HZ = 8_000_000  # BTR0 and BTR1 count in periods of half the crystal
_ITS_OWN = ("OCR", "IER")  # registers of an SJA1000 that an adapter's firmware sets by itself
_CODES = tuple(f"ACR{k}" for k in range(4)), tuple(f"AMR{k}" for k in range(4))


def setup_of(settings: LineSettings) -> Setup:
    """The adapter's settings for these settings of a line; raises Unsupported."""
    if settings.loop_back:
        raise Unsupported("a serial adapter has no loop-back")
    return Setup(
        settings.timing.bit_rate,
        _btr(settings),
        None if settings.data_timing is None else settings.data_timing.bit_rate,
        settings.listen_only,
        _accept(settings),
    )


def _btr(settings: LineSettings) -> str | None:
    """BTR0 and BTR1 as four digits; None if they cannot hold the timing."""
    if settings.timing.clock_hz != _DATA_SHEET_HZ:
        return None
    try:
        return "{:02X}{:02X}".format(*settings.timing.to_btr())
    except BadTiming:
        return None


def _accept(settings: LineSettings) -> tuple[int, int] | None:
    """The requested values of M and m, if any: registers ACR0..3 and AMR0..3, the first one in the highest byte."""
    values = {name: value for name, value in settings.registers if name not in _ITS_OWN}
    if not values:
        return None
    code, mask = (
        int.from_bytes(bytes(values.pop(name, 0xFF if names is _CODES[1] else 0) for name in names), "big")
        for names in _CODES
    )
    if values:
        raise Unsupported(f"register {next(iter(values))}: a serial adapter has ACR0..3 and AMR0..3")
    return code, mask


def versions_of(text: str) -> tuple[tuple[int, int, int, int], tuple[int, int]]:
    """Hardware and firmware of V1013: 1.0 and 1.3 (source: CANBUS manual, 1.5)."""
    digits = text[1:5]
    if len(text) != 5 or not digits.isdigit():
        return (0, 0, 0, 0), (0, 0)
    one, two, three, four = map(int, digits)
    return (one, two, 0, 0), (three, four)
