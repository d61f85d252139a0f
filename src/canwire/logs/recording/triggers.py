"""Selects the parts of a recording: from a start to a stop, with the time shortly before and after."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire.errors import BadValue
from canwire.logs.batch import LogBatch, batch_of
from canwire.logs.entry import LogEntry, LogMark, MarkKind
from canwire.values.checks import finite
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

MOST_BEFORE = 1 << 20
"""Number of entries that are kept for a later start: two minutes of a saturated bus at 1 Mbit/s, 88 MiB."""
_LONGEST_S = 86_400.0

Condition = Callable[[LogEntry], bool]


@dataclass(frozen=True, slots=True)
class RecordTriggers:
    """The conditions that start and stop a recording by `record`.

    `start` and `stop` are called with every entry (a frame, an error, a change of state). When `start` returns True,
    that entry and all later ones are kept, and those of `before_s` seconds before it (at most 1,048,576 entries). When
    `stop` returns True, the recording stops `after_s` seconds later; the entry that stops it is kept, too. Then it
    waits for the next start, unless `once`. Without `start` it begins immediately, without `stop` it does not stop.
    The log contains a GAP mark between two parts. Seconds are those of the line's time stamps.

    >>> high = RecordTriggers(start=lambda entry: entry.frame is not None and entry.frame.id == 0x123, before_s=2.0)
    """

    start: Condition | None = None
    stop: Condition | None = None
    before_s: float = 0.0
    after_s: float = 0.0
    once: bool = False

    def __post_init__(self) -> None:
        finite("before_s", self.before_s, 0.0, _LONGEST_S)
        finite("after_s", self.after_s, 0.0, _LONGEST_S)
        for name, without in (("before_s", "start"), ("after_s", "stop"), ("once", "stop")):
            if getattr(self, name) and getattr(self, without) is None:
                raise BadValue(f"{name} {getattr(self, name)!r}: needs a condition to {without}")


class Gate:
    """Passes parts of the entries, by triggers. `starts` counts the starts."""

    def __init__(self, triggers: RecordTriggers, channels: list[str]) -> None:
        self.starts = 0
        self._triggers = triggers
        self._channels = channels
        self._open = triggers.start is None
        self._closed_for_good = False
        self._closes_ns: int | None = None
        self._before: deque[numpy.ndarray] = deque()
        self._latest_ns: int | None = None  # of what went through

    @property
    def over(self) -> bool:
        """Whether no further entry will pass."""
        return self._closed_for_good

    @property
    def ending_s(self) -> float | None:
        """After the last stop: the number of seconds that are still kept, for a line without further entries; else
        None."""
        ends = self._closes_ns is not None and self._is_last()
        return self._triggers.after_s if ends else None

    def passed(self, records: numpy.ndarray) -> Iterator[numpy.ndarray]:
        """The passed parts of the next records of `log_dtype()`; each gap is a mark."""
        begin = 0
        for at, entry in enumerate(LogBatch(records, self._channels)):
            opened = self._open
            if opened and self._closes_ns is not None and entry.timestamp_ns > self._closes_ns:
                self._close()
            if self._open:
                self._look_for_stop(entry)
            elif not self._closed_for_good and self._starts(entry):
                if not opened:
                    self._keep(records[begin:at])
                    begin = at
                    yield from self._kept_before(entry.timestamp_ns)
                self._look_for_stop(entry)
            if opened and not self._open:
                yield self._through(records[begin:at])
                begin = at
        if self._open:
            yield self._through(records[begin:])
        elif not self._closed_for_good:
            self._keep(records[begin:])

    def _starts(self, entry: LogEntry) -> bool:
        start = self._triggers.start
        if start is None or not start(entry):
            return False
        self._open = True
        self.starts += 1
        return True

    def _look_for_stop(self, entry: LogEntry) -> None:
        stop, start = self._triggers.stop, self._triggers.start
        if stop is not None and stop(entry):
            self._closes_ns = entry.timestamp_ns + round(self._triggers.after_s * 1e9)
        elif self._closes_ns is not None and start is not None and start(entry):
            self._closes_ns = None  # it starts again before it has ended

    def _close(self) -> None:
        self._closed_for_good = self._is_last()
        self._open, self._closes_ns = False, None

    def _is_last(self) -> bool:
        return self._triggers.once or self._triggers.start is None

    def _through(self, piece: numpy.ndarray) -> numpy.ndarray:
        if len(piece):
            self._latest_ns = int(piece["time_ns"][-1])
        return piece

    def _keep(self, piece: numpy.ndarray) -> None:
        """Keep these records for `before_s` seconds, in case a start follows."""
        before_ns = round(self._triggers.before_s * 1e9)
        if not before_ns or not len(piece):
            return
        self._before.append(piece)
        newest_ns = int(piece["time_ns"][-1])
        kept = sum(map(len, self._before))
        while kept - len(self._before[0]) >= MOST_BEFORE or (
            int(self._before[0]["time_ns"][-1]) < newest_ns - before_ns
        ):
            kept -= len(self._before.popleft())

    def _kept_before(self, start_ns: int) -> Iterator[numpy.ndarray]:
        from_ns = max(0, start_ns - round(self._triggers.before_s * 1e9))
        kept = [piece[piece["time_ns"] >= from_ns] for piece in self._before]
        self._before.clear()
        kept = [piece for piece in kept if len(piece)]
        before = load_numpy().concatenate(kept)[-MOST_BEFORE:] if kept else None
        first_ns = start_ns if before is None else int(before["time_ns"][0])
        if self._latest_ns is not None and first_ns > self._latest_ns:
            mark = LogMark(MarkKind.GAP, first_ns, count=first_ns - self._latest_ns)
            yield batch_of([LogEntry(first_ns, self._channels[0], mark)], self._channels).records
        if before is not None:
            yield self._through(before)
