"""Extracts the bits of a signal from many frames: the data are 64-bit words, and a signal is in one or two of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire.databases.description import SignalDescription

if TYPE_CHECKING:
    import numpy

_DATA = 2  # the data's first word of a record's ten
_WORD = 64
_BITS = 8 * _WORD  # of the longest frame


class Words:
    """The data of some records, word by word; each word is fetched once."""

    def __init__(self, words: Any, rows: numpy.ndarray) -> None:
        self._words = words
        self._rows = rows
        self._little: dict[int, numpy.ndarray] = {}
        self._big: dict[int, numpy.ndarray] = {}

    def times(self) -> numpy.ndarray:
        times: numpy.ndarray = self._words[self._rows, 0]
        return times

    def little(self, number: int) -> numpy.ndarray:
        """Eight data bytes from 8 * number on as one word, the first byte lowest."""
        if number not in self._little:
            self._little[number] = self._words[self._rows, _DATA + number].astype("u8", copy=False)
        return self._little[number]

    def big(self, number: int) -> numpy.ndarray:
        """Eight data bytes from 8 * number on as one word, the first byte highest."""
        if number not in self._big:
            self._big[number] = self.little(number).byteswap()
        return self._big[number]


def extract(signal: SignalDescription, words: Words) -> numpy.ndarray:
    """Return raw values: int64, uint64 for 64 unsigned bits, float64 for floats, objects for more than 64 bits."""
    import numpy

    if end_bit(signal) > _BITS:
        return numpy.zeros(len(words.times()), numpy.int64)  # no frame has it: the message needs several
    if signal.length > _WORD:
        return _wide(signal, words)
    bits = _big(signal, words) if signal.big_endian else _little(signal, words)
    unused = numpy.uint64(_WORD - signal.length)
    if signal.is_float:
        return _floats(bits << unused >> unused, signal.length)
    if signal.signed:
        return (bits << unused).view(numpy.int64) >> numpy.int64(_WORD - signal.length)
    bits = bits << unused >> unused
    return bits if signal.length == _WORD else bits.view(numpy.int64)


def scaled(signal: SignalDescription, raw: numpy.ndarray) -> numpy.ndarray:
    """Physical values: raw * scale + offset, with the same results as Python's numbers."""
    scale, offset = signal.scale, signal.offset
    whole = not signal.is_float and float(scale).is_integer() and float(offset).is_integer()
    if scale == 1 and offset == 0:
        return raw
    if whole:
        scale, offset = int(scale), int(offset)
    if isinstance(scale, int) and not signal.is_float and not _fits(signal, scale, offset):
        raw = raw.astype(object)
    elif isinstance(scale, float) and raw.dtype != object:
        raw = raw.astype("f8")
    elif isinstance(scale, int) and not signal.is_float and raw.dtype != object:
        raw = raw.astype("i8")
    physical: numpy.ndarray = raw * scale + offset
    return physical if whole else physical.astype("f8")


def _fits(signal: SignalDescription, scale: int, offset: float) -> bool:
    return (1 << signal.length) * abs(scale) + abs(int(offset)) + 1 < 1 << 63


def _little(signal: SignalDescription, words: Words) -> numpy.ndarray:
    """Return the bits of a little-endian signal, the lowest at position 0; bits above the signal are still set."""
    import numpy

    number, shift = divmod(signal.start_bit, _WORD)
    bits = words.little(number) >> numpy.uint64(shift)
    if shift + signal.length > _WORD:
        bits = bits | words.little(number + 1) << numpy.uint64(_WORD - shift)
    return bits


def _big(signal: SignalDescription, words: Words) -> numpy.ndarray:
    import numpy

    number, before = divmod(_highest(signal), _WORD)
    below = _WORD - before - signal.length
    if below >= 0:
        return words.big(number) >> numpy.uint64(below)
    return words.big(number) << numpy.uint64(-below) | words.big(number + 1) >> numpy.uint64(_WORD + below)


def end_bit(signal: SignalDescription) -> int:
    """The number of data bits that are needed to contain the signal."""
    return (_highest(signal) if signal.big_endian else signal.start_bit) + signal.length


def _highest(signal: SignalDescription) -> int:
    """Return the position of the signal's highest bit, counted from the highest bit of byte 0."""
    return 8 * (signal.start_bit // 8) + 7 - signal.start_bit % 8


def _floats(bits: numpy.ndarray, length: int) -> numpy.ndarray:
    floats: numpy.ndarray = bits.astype(f"u{length // 8}").view(f"f{length // 8}").astype("f8")
    return floats


def _wide(signal: SignalDescription, words: Words) -> numpy.ndarray:
    """Return raw values of more than 64 bits as Python integers."""
    total: Any = 0
    for number in range(8):
        if signal.big_endian:
            total = total + (words.big(number).astype(object) << _WORD * (7 - number))
        else:
            total = total + (words.little(number).astype(object) << _WORD * number)
    shift = 8 * _WORD - _highest(signal) - signal.length if signal.big_endian else signal.start_bit
    raw: numpy.ndarray = total >> shift & (1 << signal.length) - 1
    if signal.signed:
        sign = 1 << signal.length - 1
        raw = (raw ^ sign) - sign
    return raw
