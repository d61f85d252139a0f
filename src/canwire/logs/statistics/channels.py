"""Counts for each channel: frames by kind and direction, errors, other events, and marks of the log."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

from canwire.logs.entry import LogKind, MarkKind
from canwire.logs.statistics.results import ChannelStatistics
from canwire.values.event import ErrorKind, EventKind
from canwire.values.lin.event import LinErrorKind, LinEventKind
from canwire.values.lin.record import OVERRUN as LIN_OVERRUN
from canwire.values.lin.record import TYPE_SHIFT
from canwire.values.named import NamedInt
from canwire.values.record import (
    EVENT_ERROR,
    EVENT_FLAGS,
    EXTENDED_DATA_LENGTH,
    OVERRUN,
    REMOTE,
    TYPE_MASK,
    load_numpy,
)

if TYPE_CHECKING:
    import numpy

_TRANSMITTING = 0x80


class ChannelCounts:
    """The counts of one channel. `set_rates` are its bit rates, by the log or by the channel's name, 0 if unknown.

    `usual_rates` are those of CAN channels without `set_rates`.
    """

    def __init__(self, name: str, set_rates: tuple[int, int], usual_rates: tuple[int, int]) -> None:
        self.name = name
        self.set_rates = set_rates
        self._usual_rates = usual_rates
        self._numbers: Counter[str] = Counter()
        self._errors: Counter[str] = Counter()
        self._events: Counter[str] = Counter()

    @property
    def rates(self) -> tuple[int, int]:
        """The current bit rate, and the one after BRS; 0 if unknown."""
        usual = (0, 0) if self._numbers["lin_frames"] else self._usual_rates
        return self.set_rates[0] or usual[0], self.set_rates[1] or usual[1]

    def add(self, records: numpy.ndarray) -> None:
        """Count entries of this channel, of every kind but marks."""
        kinds = records["kind"]
        for kind in (LogKind.CAN_FRAME, LogKind.LIN_FRAME):
            found = records[kinds == kind]
            if len(found):
                self._add_frames(found, kind is LogKind.LIN_FRAME)
        if (kinds == LogKind.CAN_EVENT).any():
            self._add_events(records[kinds == LogKind.CAN_EVENT], 0, EventKind, ErrorKind)
        if (kinds == LogKind.LIN_EVENT).any():
            self._add_events(records[kinds == LogKind.LIN_EVENT], TYPE_SHIFT, LinEventKind, LinErrorKind)

    def add_mark(self, kind: int, count: int) -> None:
        """Count a mark, with which the log reports lost entries or a gap."""
        if kind == MarkKind.LOST:
            self._numbers["lost"] += count
        elif kind == MarkKind.GAP:
            self._numbers["gap_ns"] += count

    def result(self, load: float | None, load_step_s: float, loads: tuple[float, ...]) -> ChannelStatistics:
        bit_rate, data_bit_rate = self.rates
        return ChannelStatistics(
            name=self.name,
            errors=dict(self._errors),
            events=dict(self._events),
            bit_rate=bit_rate,
            data_bit_rate=data_bit_rate,
            load=load,
            load_step_s=load_step_s,
            loads=loads,
            **self._numbers,
        )

    def _add_frames(self, records: numpy.ndarray, lin: bool) -> None:
        info, direction = records["info"], records["direction"]
        numbers = self._numbers
        numbers["lin_frames" if lin else "frames"] += len(records)
        numbers["received"] += int((direction == 1).sum())
        numbers["transmitted"] += int((direction == 2).sum())
        numbers["overruns"] += int((info & (LIN_OVERRUN if lin else OVERRUN) != 0).sum())
        if not lin:
            numbers["remote"] += int((info & REMOTE != 0).sum())
            numbers["fd"] += int((info & EXTENDED_DATA_LENGTH != 0).sum())

    def _add_events(
        self, records: numpy.ndarray, shift: int, kinds: type[NamedInt], errors: type[NamedInt]
    ) -> None:
        numpy = load_numpy()
        found = records["info"] >> numpy.uint32(shift) & numpy.uint32(TYPE_MASK)
        wrong = found == int(EventKind.ERROR)  # and LinEventKind's
        self._errors.update(_named(records["data"][wrong, EVENT_ERROR], errors))
        self._events.update(_named(found[~wrong], kinds))
        if shift == 0:
            sending = records["data"][wrong, EVENT_FLAGS] & _TRANSMITTING != 0
            self._numbers["errors_sending"] += int(sending.sum())


def _named(values: Any, names: type[NamedInt]) -> dict[str, int]:
    """Return the number of occurrences of each value by its name; a value without a name is given by its number."""
    known = {int(one): one.name for one in names}
    counts = load_numpy().bincount(values.astype("i8"), minlength=1).tolist() if len(values) else []
    return {known.get(value, str(value)): count for value, count in enumerate(counts) if count}
