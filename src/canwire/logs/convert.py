"""Converts a log to another format: `convert_log`."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping

from canwire.errors import BadValue
from canwire.logs.batch import LogBatch
from canwire.logs.log import Log, open_log
from canwire.logs.writer import LogWriter, create_log


def convert_log(
    source: Log | str | os.PathLike[str],
    target: str | os.PathLike[str],
    *,
    format: str | None = None,
    channels: Mapping[str, str] | None = None,
    only: Callable[[LogBatch], LogBatch] | None = None,
) -> LogWriter:
    """Write a log in another format; returns the closed writer with `count` and `left_out`. The Log has the `faults`.

    `channels` renames ({"can0": "can2"}), `only` may select records of each batch. Raises BadValue if both are the same
    file, BadLog, OSError, and the errors of `open_log` and `create_log`; then an existing file is unchanged, and no
    part of the new one is left. Only a trace keeps the part that was written.
    """
    if not isinstance(source, Log):
        with open_log(source) as log:
            return convert_log(log, target, format=format, channels=channels, only=only)
    name = os.fspath(target)
    if name != "-" and os.path.exists(name) and source.path != "-" and os.path.samefile(source.path, name):
        raise BadValue(f"{name}: the same file twice; give the new log another name")
    batches = source.batches()
    first = next(batches, None)  # the head is known then, and a file that is no log leaves nothing behind
    with create_log(
        name,
        format=format,
        dated=source.dated,
        start_ns=source.start_ns,
        clock=source.clock,
        whole=True,
    ) as writer:
        while first is not None:
            chosen = first if only is None else only(first)
            writer.write_batch(renamed(chosen, channels))
            first = next(batches, None)
    return writer


def renamed(batch: LogBatch, names: Mapping[str, str] | None) -> LogBatch:
    """The batch with renamed channels."""
    if not names:
        return batch
    return LogBatch(batch.records, [names.get(name, name) for name in batch.channels])
