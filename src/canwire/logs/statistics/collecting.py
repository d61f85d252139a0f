"""`log_statistics`: a log, or several that follow each other, batch by batch."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from canwire.errors import BadValue
from canwire.logs.batch import LogBatch
from canwire.logs.entry import LogKind, MarkKind
from canwire.logs.log import Log, open_log
from canwire.logs.statistics.busy import Busy
from canwire.logs.statistics.channels import ChannelCounts
from canwire.logs.statistics.periods import Identifiers
from canwire.logs.statistics.results import ChannelStatistics, LogStatistics
from canwire.values.checks import whole
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

_PIECE = 1 << 16
Rates = int | Mapping[str, int] | None


def log_statistics(
    *logs: Log | str | os.PathLike[str], bit_rate: Rates = None, data_bit_rate: Rates = None
) -> LogStatistics:
    """Count what is in a log: identifiers with their periods, errors, losses, directions, load over time.

    Several logs are read as one continuous log, like the files of a rotated recording. The load needs bit rates
    (bit/s): the log's own, else `bit_rate` and `data_bit_rate`, for all channels of CAN or by their names.
    Faults of a file are left out; its Log lists them. Memory does not grow with the log.
    Raises BadValue, BadLog, OSError. Needs canwire[arrays].

    >>> found = log_statistics("examples/car-candump.log", bit_rate=500_000)
    >>> found.channels[0].frames, f"{found.channels[0].load:.0f} %", found.identifiers[0].count
    (12974, '36 %', 725)
    """
    if not logs:
        raise BadValue("log_statistics: a log, or several")
    collector = Collector(_by_name("bit_rate", bit_rate), _by_name("data_bit_rate", data_bit_rate))
    for log in logs:
        with ExitStack() as closing:
            opened = log if isinstance(log, Log) else closing.enter_context(open_log(log))
            for batch in opened.batches():
                collector.add(batch)
            collector.dated = collector.dated or opened.dated
            collector.clock = collector.clock or opened.clock
    return collector.result()


class Collector:
    """Collects batches in the order of the log. Rates are by channel, with "" for all other channels."""

    def __init__(self, bit_rates: Mapping[str, int], data_bit_rates: Mapping[str, int]) -> None:
        self.dated = False
        self.clock = ""
        self._rates = (bit_rates, data_bit_rates)
        self._names: list[str] = []
        self._channels: list[ChannelCounts] = []
        self._busy: list[Busy] = []
        self._identifiers = Identifiers()
        self._begin_ns: int | None = None
        self._ends: tuple[int, int] | None = None
        self._entries = self._marks = self._nameless = 0

    def add(self, batch: LogBatch) -> None:
        """Count the entries of a batch."""
        records = self._renumbered(batch)
        for at in range(0, len(records), _PIECE):
            piece = records[at : at + _PIECE]
            begin = 0
            for mark in load_numpy().flatnonzero(piece["kind"] == LogKind.MARK).tolist():
                if self._changes_rates(piece[mark]):
                    self._add(piece[begin:mark])
                    begin = mark
                    self._set_rates(piece[mark])
            self._add(piece[begin:])

    def result(self) -> LogStatistics:
        first_ns, last_ns = self._ends or (0, 0)
        return LogStatistics(
            entries=self._entries,
            marks=self._marks,
            unlisted=self._identifiers.unlisted + self._nameless,
            dated=self.dated,
            clock=self.clock,
            first_ns=first_ns,
            last_ns=last_ns,
            channels=tuple(
                sorted((self._channel_result(number) for number in range(len(self._names))), key=_name)
            ),
            identifiers=tuple(self._identifiers.results(self._names)),
        )

    def _channel_result(self, number: int) -> ChannelStatistics:
        counts = self._channels[number]
        busy = self._busy[number] if number < len(self._busy) else None
        if busy is None or busy.unknown or not counts.rates[0] or self._ends is None:
            return counts.result(None, 0.0, ())
        step_s, loads, mean = busy.loads(self._ends[1])
        return counts.result(mean, step_s, loads)

    def _renumbered(self, batch: LogBatch) -> numpy.ndarray:
        """Return the records of a batch, with channels numbered by the collector's names."""
        for name in batch.channels:
            if name not in self._names:
                self._names.append(name)
                bit_rates, data_bit_rates = self._rates
                own = (bit_rates.get(name, 0), data_bit_rates.get(name, 0))
                usual = (bit_rates.get("", 0), data_bit_rates.get("", 0))
                self._channels.append(ChannelCounts(name, own, usual))
        numbers = [self._names.index(name) for name in batch.channels]
        records = batch.records
        nameless = records["channel"] >= len(numbers)
        if nameless.any():
            self._nameless += int(nameless.sum())
            records = records[~nameless]
        if numbers != list(range(len(numbers))):
            records = records.copy()
            records["channel"] = load_numpy().array(numbers, "u2")[records["channel"]]
        return records

    def _add(self, records: numpy.ndarray) -> None:
        if not len(records):
            return
        self._entries += len(records)
        times = records["time_ns"].astype("i8")
        first, last = int(times.min()), int(times.max())
        before = self._ends or (first, last)
        self._ends = (min(first, before[0]), max(last, before[1]))
        for mark in records[records["kind"] == LogKind.MARK]:
            self._marks += 1
            self._channels[mark["channel"]].add_mark(int(mark["id"]), _numbers(mark)[0])
        framed = (records["kind"] == LogKind.CAN_FRAME) | (records["kind"] == LogKind.LIN_FRAME)
        frames = records if framed.all() else records[framed]
        if len(frames):
            self._identifiers.add(frames)
            if self._begin_ns is None:
                self._begin_ns = int(frames["time_ns"].astype("i8").min())
        for number in load_numpy().flatnonzero(load_numpy().bincount(records["channel"])).tolist():
            self._add_channel(number, records, frames)

    def _add_channel(self, number: int, records: numpy.ndarray, frames: numpy.ndarray) -> None:
        counts = self._channels[number]
        counts.add(_of_channel(records, number))
        if self._begin_ns is None:
            return
        while len(self._busy) <= number:
            self._busy.append(Busy(self._begin_ns))
        self._busy[number].add(_of_channel(frames, number), *counts.rates)

    def _changes_rates(self, mark: Any) -> bool:
        counts = self._channels[mark["channel"]]
        return int(mark["id"]) == MarkKind.BIT_RATE and _numbers(mark)[1:] != counts.set_rates

    def _set_rates(self, mark: Any) -> None:
        """Use the bit rates of a mark from here on; a rate that the mark leaves out stays unchanged."""
        counts = self._channels[mark["channel"]]
        _, bit_rate, data_bit_rate = _numbers(mark)
        before = counts.set_rates
        counts.set_rates = (bit_rate or before[0], data_bit_rate or before[1])


def _of_channel(records: numpy.ndarray, number: int) -> numpy.ndarray:
    those = records["channel"] == number
    found: numpy.ndarray = records if those.all() else records[those]
    return found


def _numbers(mark: Any) -> tuple[int, int, int]:
    """Return a mark's count and both bit rates, from the places that batch.py defines."""
    data = mark["data"].tobytes()
    return (
        int.from_bytes(data[:8], "little"),
        int.from_bytes(data[8:12], "little"),
        int.from_bytes(data[12:16], "little"),
    )


def _name(channel: ChannelStatistics) -> str:
    return channel.name


def _by_name(what: str, rates: Rates) -> dict[str, int]:
    given = dict(rates) if isinstance(rates, Mapping) else {} if rates is None else {"": rates}
    return {name: whole(what, rate, 1, 1_000_000_000) for name, rate in given.items()}
