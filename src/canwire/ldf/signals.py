"""Signals of a LIN description: their places in frames, and their values by the file's encodings.

Source: LIN 2.2A 9.2.6; ldfparser 0.26.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

Value = int | float | str


@dataclass(frozen=True, slots=True)
class LinSignal:
    """A signal in its frame: its place in bits, and its encoding in the file.

    `scale`, `offset` and the limits are those of its first physical range; without a range, those of the raw bits.
    `texts` are by raw value. `start` is the initial value in the form that `decode` returns.
    """

    name: str
    start_bit: int
    length: int
    minimum: float
    maximum: float
    scale: float
    offset: float
    unit: str
    texts: Mapping[int, str]
    start: Value | list[int]


def shown(signal: Any, raw: Any) -> Value:
    encoding = getattr(signal, "encoding_type", None)
    if encoding is not None:
        try:
            return encoding.decode(raw, signal)
        except Exception:  # no row of the encoding fits
            return raw
    return raw


def signal_of(signal: Any, start_bit: int) -> LinSignal:
    encoding = getattr(signal, "encoding_type", None)
    converters = [] if encoding is None else encoding.get_converters()
    physical = next((one for one in converters if type(one).__name__ == "PhysicalValue"), None)
    texts = {one.phy_value: one.info for one in converters if type(one).__name__ == "LogicalValue"}
    raw, scale, offset, unit = (0, (1 << signal.width) - 1), 1.0, 0.0, ""
    if physical is not None:
        raw, scale, offset = (physical.phy_min, physical.phy_max), physical.scale, physical.offset
        unit = physical.unit or ""
    low, high = sorted(end * scale + offset for end in raw)
    start = shown(signal, signal.init_value)
    return LinSignal(signal.name, start_bit, signal.width, low, high, scale, offset, unit, texts, start)
