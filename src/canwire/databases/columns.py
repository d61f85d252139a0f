"""Decodes many frames in one call: grouped by message, each signal with a few operations on whole columns.

The values equal those of cantools: the same integers if scale and offset are whole, else the same floating-point
products.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from canwire.databases.description import MessageDescription, SignalDescription
from canwire.databases.field import Words, end_bit, extract, scaled
from canwire.databases.matching import EXTENDED_KEY, Matching
from canwire.values.dlc import CLASSIC_LENGTHS, FD_LENGTHS
from canwire.values.record import (
    DLC_SHIFT,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    REMOTE,
    TYPE_MASK,
    load_numpy,
)
from canwire.values.records import check_dtype

if TYPE_CHECKING:
    import numpy


@dataclass(frozen=True, repr=False)
class SignalColumns:
    """All decoded frames of one message, in the order of the records.

    `rows` are their indices in the records, `time_ns` their times. `signals` are physical values by name: int64 if
    whole, else float64 (uint64 or Python's integers if int64 is too small). `present` gives by name the frames that
    contain a signal, None for all frames: in the others it is multiplexed out, cut off by short data, or does not fit
    into the message, and its value in `signals` is meaningless. `undecoded` counts frames with a multiplexer value
    that the file does not know; they contain no signals.
    """

    message: MessageDescription
    rows: numpy.ndarray
    time_ns: numpy.ndarray
    signals: dict[str, numpy.ndarray]
    present: dict[str, numpy.ndarray | None]
    undecoded: int
    raw: dict[str, numpy.ndarray]

    def __repr__(self) -> str:
        return f"<columns of {self.message.name}: {len(self.rows)} frames, {', '.join(self.signals) or 'no signal'}>"

    def texts(self, name: str) -> numpy.ndarray:
        """The texts of a signal's values in the file, "" for values without a text, as an array of objects."""
        import numpy

        choices = self.message.signals[name].choices
        texts = numpy.full(len(self.rows), "", object)
        raw = self.raw.get(name)
        for value, text in choices.items():
            texts[raw == value] = text
        return texts


def decode_columns(
    records: numpy.ndarray, messages: Sequence[MessageDescription], matching: Matching
) -> dict[str, SignalColumns]:
    """Decode the `record_dtype()` records that are data frames of these messages; returns columns by message name."""
    numpy = load_numpy()
    check_dtype(records)
    records = numpy.ascontiguousarray(records)
    info = records["info"]
    keys = records["id"] | numpy.where(info & EXTENDED, numpy.uint32(EXTENDED_KEY), numpy.uint32(0))
    numbers = matching.find_array(keys)
    numbers[info & (TYPE_MASK | REMOTE) != 0] = -1
    small = numbers.astype(numpy.int16) if len(messages) < 1 << 15 else numbers  # sorted in linear time
    order = numpy.argsort(small, kind="stable")
    counts = numpy.bincount(numbers + 1, minlength=len(messages) + 1)
    ends = numpy.cumsum(counts)
    words = records.view("<u8").reshape(len(records), 10) if len(records) else None
    found = {}
    for number in numpy.flatnonzero(counts[1:]).tolist():
        message = messages[number]
        rows = order[ends[number] : ends[number + 1]]
        if message.decodable:
            found[message.name] = _Group(message, rows, words).columns()
    return found


def decode_signal(
    records: numpy.ndarray, message: MessageDescription, name: str
) -> tuple[numpy.ndarray, numpy.ndarray | None, numpy.ndarray]:
    """Decode one signal of `record_dtype()` records that are all frames of this message: see SignalColumns.

    Returns its physical values, the frames that contain it (None: all), and its raw values."""
    numpy = load_numpy()
    words = numpy.ascontiguousarray(records).view("<u8").reshape(len(records), 10)
    return _Group(message, numpy.arange(len(records)), words).column(name)


class _Group:
    """Frames of one message: `words` are all records as ten 64-bit words each."""

    def __init__(self, message: MessageDescription, rows: numpy.ndarray, words: Any) -> None:
        self._message = message
        self._rows = rows
        self._words = Words(words, rows)
        self._info = words[rows, 1] >> 32
        self._raw: dict[str, numpy.ndarray] = {}
        self._present: dict[str, numpy.ndarray | None] = {}

    def columns(self) -> SignalColumns:
        signals = self._message.signals
        for signal in signals.values():
            self._read(signal)
        undecoded = self._without_unknown_multiplexers()
        return SignalColumns(
            self._message,
            self._rows,
            self._words.times(),
            {name: scaled(signals[name], raw) for name, raw in self._raw.items()},
            self._present,
            undecoded,
            {name: raw for name, raw in self._raw.items() if signals[name].choices},
        )

    def column(self, name: str) -> tuple[numpy.ndarray, numpy.ndarray | None, numpy.ndarray]:
        """Decode only this signal, with the multiplexers that select it."""
        signal = self._message.signals[name]
        self._read(signal)
        for other in self._message.signals.values():
            if other.multiplexer:
                self._read(self._message.signals[other.multiplexer])
        self._without_unknown_multiplexers()
        return scaled(signal, self._raw[name]), self._present[name], self._raw[name]

    def _read(self, signal: SignalDescription) -> None:
        """Extract the signal's raw values, and which frames contain it; its multiplexer, if any, is read first."""
        if signal.name in self._raw:
            return
        present = self._long_enough(signal)
        if signal.multiplexer:
            import numpy

            decides = self._message.signals[signal.multiplexer]
            self._read(decides)
            chosen = numpy.isin(self._raw[decides.name], signal.multiplexer_ids)
            present = _both(present, _both(self._present[decides.name], chosen))
        self._raw[signal.name] = extract(signal, self._words)
        self._present[signal.name] = present

    def _long_enough(self, signal: SignalDescription) -> numpy.ndarray | None:
        if end_bit(signal) > 8 * self._message.length:
            import numpy

            return numpy.zeros(len(self._rows), bool)  # a file that was not read strictly
        lengths = self._lengths
        if lengths is None:
            return None
        there: numpy.ndarray = lengths * 8 >= end_bit(signal)
        return None if there.all() else there

    @cached_property
    def _lengths(self) -> numpy.ndarray | None:
        """Return the data lengths of the frames in bytes; None if all frames are as long as the message."""
        import numpy

        dlc = self._info >> DLC_SHIFT & 15
        is_fd = self._info & EXTENDED_DATA_LENGTH != 0
        lengths = numpy.where(is_fd, numpy.array(FD_LENGTHS)[dlc], numpy.array(CLASSIC_LENGTHS)[dlc])
        return None if (lengths >= self._message.length).all() else lengths

    def _without_unknown_multiplexers(self) -> int:
        import numpy

        wrong: numpy.ndarray | None = None
        for name, ids in self._message.selectors.items():
            strange = ~numpy.isin(self._raw[name], sorted(ids))
            here = self._present[name]
            strange = strange if here is None else strange & here
            wrong = strange if wrong is None else wrong | strange
        if wrong is None or not wrong.any():
            return 0
        for name, present in self._present.items():
            self._present[name] = _both(present, ~wrong)
        return int(wrong.sum())


def _both(one: numpy.ndarray | None, other: numpy.ndarray | None) -> numpy.ndarray | None:
    if one is None:
        return other
    return one if other is None else one & other
