"""Computes how long the frames of a channel occupied its bus, in equal time steps that double when
the log needs more."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.logs.entry import LogKind
from canwire.logs.statistics.wire_bits import wire_bits
from canwire.values.lin.record import ID_ONLY, LENGTH_SHIFT
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

_STEPS = 4096
_STEP_NS = 100_000_000
_LIN_HEADER, _LIN_BYTE = 34, 10  # bits: break, delimiter, sync, identifier; start, eight, stop


class Busy:
    """The busy time of one channel. The first step begins at `begin_ns`."""

    def __init__(self, begin_ns: int) -> None:
        self.unknown = False
        """Some frames were at a rate that nobody knows."""
        self._begin_ns = begin_ns
        self._step_ns = _STEP_NS
        self._sums = load_numpy().zeros(_STEPS)

    def add(self, records: numpy.ndarray, bit_rate: int, data_bit_rate: int) -> None:
        """Add frames at these bit rates, 0 for an unknown rate."""
        if not len(records):
            return
        lin = records["kind"] == LogKind.LIN_FRAME
        numpy = load_numpy()
        bits, fast = numpy.zeros(len(records), "i8"), numpy.zeros(len(records), "i8")
        if lin.any():
            bits[lin] = _lin_bits(records[lin])
        if not lin.all():
            bits[~lin], fast[~lin] = wire_bits(records[~lin])
        if not bit_rate or (not data_bit_rate and fast.any()):
            self.unknown = True
            return
        busy_ns = (bits - fast) * (1e9 / bit_rate) + fast * (1e9 / (data_bit_rate or bit_rate))
        self._put(records["time_ns"].astype("i8"), busy_ns)

    def loads(self, end_ns: int) -> tuple[float, tuple[float, ...], float]:
        """Return the seconds of a step, the load of each step in percent, and the load of the whole time up to
        `end_ns`."""
        span_ns = max(end_ns - self._begin_ns, 0)
        count = min(span_ns // self._step_ns + 1, _STEPS)
        widths = [self._step_ns] * count
        widths[-1] = max(span_ns - (count - 1) * self._step_ns, 1)
        sums = self._sums[:count].tolist()
        if (
            count > 1 and widths[-1] < self._step_ns // 10
        ):  # too short to say anything: the step before has it
            last, last_sum = widths.pop(), sums.pop()
            widths[-1] += last
            sums[-1] += last_sum
        loads = tuple(100 * busy / width for busy, width in zip(sums, widths, strict=True))
        mean = 100 * sum(sums) / span_ns if span_ns else 0.0
        return self._step_ns / 1e9, loads, mean

    def _put(self, times: numpy.ndarray, busy_ns: numpy.ndarray) -> None:
        numpy = load_numpy()
        after = numpy.maximum(times - self._begin_ns, 0)
        while int(after.max()) // self._step_ns >= _STEPS:
            self._sums[: _STEPS // 2] = self._sums[::2] + self._sums[1::2]
            self._sums[_STEPS // 2 :] = 0
            self._step_ns *= 2
        self._sums += numpy.bincount(after // self._step_ns, busy_ns, _STEPS)


def _lin_bits(records: numpy.ndarray) -> numpy.ndarray:
    """Return the minimum number of bits of each LIN frame: there may be spaces between its bytes."""
    numpy = load_numpy()
    info = records["info"]
    response = numpy.where(info & ID_ONLY, 0, ((info >> LENGTH_SHIFT & 0xFF) + 1) * _LIN_BYTE)
    return _LIN_HEADER + response.astype("i8")
