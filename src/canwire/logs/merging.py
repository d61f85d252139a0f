"""Merges logs in order of time: `merge_logs`."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from canwire.errors import BadValue
from canwire.logs.batch import LogBatch, in_time, renumbered
from canwire.logs.convert import renamed
from canwire.logs.log import Log
from canwire.logs.writer import LogWriter, create_log
from canwire.values.checks import instance
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy


def merge_logs(
    sources: Sequence[Log],
    target: str | os.PathLike[str],
    *,
    format: str | None = None,
    channels: Sequence[Mapping[str, str]] = (),
    only: Callable[[LogBatch], LogBatch] | None = None,
) -> LogWriter:
    """Write several logs into one; returns the closed writer with `count` and `left_out`. Each Log has its `faults`.

    If every log has a date, in its stamps or in its head, the dates put all times on one clock. If none has, all logs
    begin at the same zero. `channels` renames, one mapping for each log; channels with one name become one channel.
    `only` may select records of each batch. Needs canwire[arrays].

    Raises BadValue if only some logs have a date or if the target is one of the logs, and the errors of `convert_log`;
    then the target is unchanged.

    >>> with open_log("a.log") as a, open_log("b.blf") as b:  # doctest: +SKIP
    ...     merge_logs([a, b], "both.mf4", channels=[{}, {"can0": "can1"}])
    """
    instance("sources", sources, list, tuple)
    name = os.fspath(target)
    for source in sources:
        instance("sources", source, Log)
        if (
            name != "-"
            and os.path.exists(name)
            and source.path != "-"
            and os.path.samefile(source.path, name)
        ):
            raise BadValue(f"{name}: the same file twice; give the new log another name")
    names = [*channels, *[{}] * (len(sources) - len(channels))]
    parts = [_Part(source, mapping, only) for source, mapping in zip(sources, names, strict=True)]
    dated = _on_one_clock(parts)
    starts = [part.log.start_ns for part in parts if part.log.start_ns is not None]
    with create_log(
        name, format=format, dated=dated, start_ns=min(starts, default=None) if dated else None, whole=True
    ) as writer:
        found: list[str] = []
        for records in _merged(parts, found):
            writer.write_batch(LogBatch(records, found))
    return writer


class _Part:
    """One log, read in batches; `shift_ns` is added to its times."""

    def __init__(
        self, log: Log, names: Mapping[str, str], only: Callable[[LogBatch], LogBatch] | None
    ) -> None:
        self.log = log
        self.shift_ns = 0
        self._names = names
        self._only = only
        self._batches = log.batches()
        self.batch = next(self._batches, None)  # what the head says is known then

    def take(self, channels: list[str]) -> numpy.ndarray | None:
        """Return the chosen records of the batch, then read the next batch; None at the end."""
        batch, self.batch = self.batch, None
        if batch is None:
            return None
        self.batch = next(self._batches, None)
        chosen = batch if self._only is None else self._only(batch)
        records = renumbered(renamed(chosen, self._names), channels)
        if self.shift_ns:
            records = records.copy()
            records["time_ns"] += load_numpy().uint64(self.shift_ns)
        return records


def _on_one_clock(parts: Sequence[_Part]) -> bool:
    """Make the times of all parts count from one zero; returns whether that zero is 1970."""
    undated = [part for part in parts if part.batch is not None and not part.log.dated]
    without = [part.log.path for part in undated if part.log.start_ns is None]
    if not without:
        for part in undated:
            part.shift_ns = part.log.start_ns or 0
        return True
    if len(undated) < len(parts):
        raise BadValue(
            f"{', '.join(without)}: no date, and the other logs have one; logs are merged where all have one, or none"
        )
    return False


def _merged(parts: Sequence[_Part], channels: list[str]) -> Iterator[numpy.ndarray]:
    """Yield records of all parts in order of time, up to the time that each part has been read to."""
    held: list[numpy.ndarray | None] = [part.take(channels) for part in parts]
    while any(one is not None for one in held):
        lasts = [int(one["time_ns"].max(initial=0)) for one in held if one is not None]
        until_ns = min(lasts)
        ready = []
        for at, one in enumerate(held):
            if one is None:
                continue
            due = one["time_ns"] <= until_ns
            ready.append(one[due])
            held[at] = one[~due]
            if due.all():
                held[at] = parts[at].take(channels)
        yield in_time(load_numpy().concatenate(ready))
