"""Identifiers and their periods, as rows of one array: a batch is sorted by identifier, and its groups are added up.

Means and deviations of batches are combined by Chan's formula. Only these rows are kept, and the periods of an
identifier until 32 of them are known.
Source: Chan, Golub, LeVeque, "Updating Formulae and a Pairwise Algorithm for Computing Sample Variances" (1979).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire.logs.entry import LogKind
from canwire.logs.statistics.results import IdentifierStatistics
from canwire.values.lin.record import LENGTH_SHIFT
from canwire.values.record import DLC_SHIFT, EXTENDED, EXTENDED_DATA_LENGTH, REMOTE, load_numpy

if TYPE_CHECKING:
    import numpy

Columns = dict[str, "numpy.ndarray"]
MOST = 1 << 16
"""Greatest number of distinct identifiers."""
GAP = 3.0
"""Factor of the typical period: a longer period is a gap."""
_EARLY = 32
_LIN, _LONG = 1 << 30, 1 << 29
_FIELDS = [("key", "u8"), ("count", "i8"), ("R", "i8"), ("T", "i8"), ("remote", "i8"), ("fd", "i8"), ("dlcs", "i8"),
           ("first", "i8"), ("last", "i8"), ("periods", "i8"), ("mean", "f8"), ("squares", "f8"), ("least", "i8"),
           ("most", "i8"), ("most_at", "i8"), ("usual", "f8"), ("gaps", "i8"), ("backwards", "i8")]  # fmt: skip


class Identifiers:
    """Counts frames by channel and identifier."""

    def __init__(self) -> None:
        numpy = load_numpy()
        self.unlisted = 0
        self._rows = numpy.zeros(256, _FIELDS)
        self._known = 0
        self._keys = numpy.zeros(0, "u8")  # sorted, and whose rows they are
        self._numbers = numpy.zeros(0, "i4")
        self._early: dict[int, list[float]] = {}

    def add(self, records: numpy.ndarray) -> None:
        """Count frames of CAN and LIN, in the order of the log."""
        numpy = load_numpy()
        numbers = self._numbers_of(_keys_of(records))
        if (numbers < 0).any():
            self.unlisted += int((numbers < 0).sum())
            records, numbers = records[numbers >= 0], numbers[numbers >= 0]
        if not len(records):
            return
        small = numbers.astype(numpy.int16) if self._known < 1 << 15 else numbers  # sorted in linear time
        order = numpy.argsort(small, kind="stable")
        numbers = numbers[order]
        begins = numpy.flatnonzero(numpy.diff(numbers, prepend=-1))
        columns = {name: records[name][order] for name in ("time_ns", "info", "kind", "direction")}
        self._add_groups(columns, numbers, begins)

    def results(self, channels: list[str]) -> list[IdentifierStatistics]:
        """Return the results in order of the channel's name and the identifier."""
        for number in list(self._early):
            self._settle(number)
        rows = self._rows[: self._known]
        found = [_result(row, channels) for row in rows]
        return sorted(found, key=lambda one: (one.channel, one.lin, one.extended, one.id))

    def _numbers_of(self, keys: numpy.ndarray) -> numpy.ndarray:
        """Return the row of each key, -1 for a new key if the table is full."""
        numpy = load_numpy()
        numbers = self._looked_up(keys)
        if (numbers < 0).any() and self._known < MOST:
            new = numpy.unique(keys[numbers < 0])[: MOST - self._known]
            self._grow(self._known + len(new))
            self._rows["key"][self._known : self._known + len(new)] = new
            numbered = numpy.arange(self._known, self._known + len(new), dtype="i4")
            self._known += len(new)
            every = numpy.concatenate([self._keys, new])
            order = numpy.argsort(every, kind="stable")
            self._keys, self._numbers = every[order], numpy.concatenate([self._numbers, numbered])[order]
            numbers = self._looked_up(keys)
        return numbers

    def _looked_up(self, keys: numpy.ndarray) -> numpy.ndarray:
        numpy = load_numpy()
        if not len(self._keys):
            return numpy.full(len(keys), -1, "i4")
        at = numpy.minimum(numpy.searchsorted(self._keys, keys), len(self._keys) - 1)
        return numpy.where(self._keys[at] == keys, self._numbers[at], -1)

    def _grow(self, needed: int) -> None:
        numpy = load_numpy()
        if needed > len(self._rows):
            more = numpy.zeros(max(needed, 2 * len(self._rows)), _FIELDS)
            more[: self._known] = self._rows[: self._known]
            self._rows = more

    def _add_groups(self, records: Columns, numbers: numpy.ndarray, begins: numpy.ndarray) -> None:
        """Add records that are sorted by their rows' `numbers`; a group begins at each of `begins`."""
        numpy = load_numpy()
        rows, those = self._rows, numbers[begins]
        times = records["time_ns"].astype("i8")
        ends = numpy.append(begins[1:], len(times))
        before = numpy.append(0, times[:-1])
        before[begins] = rows["last"][those]
        new = rows["count"][those] == 0
        rows["usual"][those[new]] = numpy.nan
        rows["first"][those[new]] = times[begins[new]]
        rows["last"][those] = times[ends - 1]
        for name, values in _counted(records).items():
            rows[name][those] += numpy.add.reduceat(values, begins, dtype="i8")
        rows["count"][those] += ends - begins
        rows["dlcs"][those] |= numpy.bitwise_or.reduceat(_lengths(records), begins)
        periods = times - before
        counted = periods >= 0
        counted[begins[new]] = False
        backwards = periods < 0
        backwards[begins[new]] = False
        if backwards.any():
            rows["backwards"][those] += numpy.add.reduceat(backwards, begins, dtype="i8")
        self._add_periods(periods[counted], numbers[counted], times[counted])

    def _add_periods(self, periods: numpy.ndarray, numbers: numpy.ndarray, times: numpy.ndarray) -> None:
        numpy = load_numpy()
        if not len(periods):
            return
        rows = self._rows
        begins = numpy.flatnonzero(numpy.diff(numbers, prepend=-1))
        those = numbers[begins]
        sizes = numpy.diff(numpy.append(begins, len(periods)))
        self._add_extremes(periods, begins, sizes, those, times)
        means = numpy.add.reduceat(periods.astype("f8"), begins) / sizes
        squares = numpy.add.reduceat((periods - numpy.repeat(means, sizes)) ** 2, begins)
        had, mean = rows["periods"][those], rows["mean"][those]
        every, apart = had + sizes, means - mean
        rows["mean"][those] = mean + apart * sizes / every
        rows["squares"][those] += squares + apart**2 * had * sizes / every
        rows["periods"][those] = every
        usual = rows["usual"][those]
        limits = numpy.where(
            usual > 0, GAP * usual, numpy.inf
        )  # NaN: not known yet; 0: stamps too coarse to tell
        longer = periods > numpy.repeat(limits, sizes)
        rows["gaps"][those] += numpy.add.reduceat(longer, begins, dtype="i8")
        for at in numpy.flatnonzero(numpy.isnan(usual)).tolist():
            self._add_early(int(those[at]), periods[begins[at] : begins[at] + sizes[at]])

    def _add_extremes(self, periods: Any, begins: Any, sizes: Any, those: Any, times: Any) -> None:
        numpy = load_numpy()
        rows = self._rows
        least, most = numpy.minimum.reduceat(periods, begins), numpy.maximum.reduceat(periods, begins)
        first = rows["periods"][those] == 0
        rows["least"][those] = numpy.where(first, least, numpy.minimum(rows["least"][those], least))
        longer = first | (most > rows["most"][those])
        if longer.any():
            places = numpy.flatnonzero(periods == numpy.repeat(most, sizes))
            at = places[numpy.searchsorted(places, begins[longer])]  # the first of each group
            rows["most_at"][those[longer]] = times[at]
            rows["most"][those[longer]] = most[longer]

    def _add_early(self, number: int, periods: numpy.ndarray) -> None:
        """Keep the first periods of an identifier until its median period is known."""
        early = self._early.setdefault(number, [])
        needed = _EARLY - len(early)
        early += periods[:needed].tolist()
        if len(early) == _EARLY:
            usual = self._settle(number)
            self._rows["gaps"][number] += _longer(periods[needed:], usual)

    def _settle(self, number: int) -> float:
        """Compute the median period of an identifier from its first periods."""
        numpy = load_numpy()
        early = numpy.array(self._early.pop(number))
        usual = float(numpy.median(early))
        self._rows["usual"][number] = usual
        self._rows["gaps"][number] += _longer(early, usual)
        return usual


def _longer(periods: numpy.ndarray, usual: float) -> int:
    return int((periods > GAP * usual).sum()) if usual > 0 else 0


def _keys_of(records: numpy.ndarray) -> numpy.ndarray:
    """Combine channel, LIN or CAN, format and identifier in one number."""
    numpy = load_numpy()
    info, lin = records["info"], records["kind"] == LogKind.LIN_FRAME
    long = (info & EXTENDED != 0) & ~lin
    low = numpy.where(lin, info & 0x3F | _LIN, records["id"] & 0x1FFFFFFF)
    low = low | numpy.where(long, numpy.uint32(_LONG), numpy.uint32(0))
    return records["channel"].astype("u8") << 32 | low


def _counted(records: Columns) -> dict[str, numpy.ndarray]:
    can = records["kind"] == LogKind.CAN_FRAME
    info = records["info"]
    return {
        "R": records["direction"] == 1,
        "T": records["direction"] == 2,
        "remote": (info & REMOTE != 0) & can,
        "fd": (info & EXTENDED_DATA_LENGTH != 0) & can,
    }


def _lengths(records: Columns) -> numpy.ndarray:
    """Return a number with one bit set, at the place of the length code."""
    numpy = load_numpy()
    assert DLC_SHIFT == LENGTH_SHIFT
    return numpy.int64(1) << (records["info"] >> DLC_SHIFT & 15).astype("i8")


def _result(row: Any, channels: list[str]) -> IdentifierStatistics:
    key, periods, dlcs = int(row["key"]), int(row["periods"]), int(row["dlcs"])
    timed = periods > 0
    return IdentifierStatistics(
        channel=channels[key >> 32],
        id=key & (_LONG - 1),
        extended=bool(key & _LONG),
        lin=bool(key & _LIN),
        count=int(row["count"]),
        received=int(row["R"]),
        transmitted=int(row["T"]),
        remote=int(row["remote"]),
        fd=int(row["fd"]),
        dlcs=tuple(code for code in range(16) if dlcs >> code & 1),
        first_ns=int(row["first"]),
        last_ns=int(row["last"]),
        mean_s=float(row["mean"]) / 1e9 if timed else None,
        least_s=int(row["least"]) / 1e9 if timed else None,
        most_s=int(row["most"]) / 1e9 if timed else None,
        jitter_s=(max(0.0, float(row["squares"])) / periods) ** 0.5 / 1e9 if timed else None,
        most_at_ns=int(row["most_at"]),
        usual_s=float(row["usual"]) / 1e9 if timed else None,
        gaps=int(row["gaps"]),
        backwards=int(row["backwards"]),
    )
