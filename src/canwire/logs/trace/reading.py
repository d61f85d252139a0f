"""Reads a trace file by file: it needs the memory of one file, whatever the trace's size."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from canwire.errors import BadLog
from canwire.logs import journal
from canwire.logs.batch import LogBatch, renumbered
from canwire.logs.source import Source
from canwire.logs.tables import parquet_file
from canwire.logs.trace.files import files_of, is_journal, opened

_AT_ONCE = 1 << 17


class TraceFile(Source):
    """One file of the trace; its faults become faults of the trace, with the file's name."""

    def __init__(self, trace: Source, path: Path, file: BinaryIO) -> None:
        super().__init__(str(path), file, trace.limits)
        self._trace = trace
        self._name = path.name

    def fault(self, where: str, what: str) -> None:
        self._trace.fault(f"{self._name}, {where}", what)


def recognises(head: bytes) -> bool:
    """Return False: a trace is a folder, not a file."""
    del head
    return False


def read(source: Source) -> Iterator[LogBatch]:
    """Yield the entries of the files one after another. An unreadable file is a fault; raises
    BadLog if it is no trace."""
    for path in files_of(source.path):
        try:
            file, path = opened(path)
            with file:
                yield from _read(source, TraceFile(source, path, file), is_journal(path))
        except (BadLog, OSError) as error:
            source.fault(path.name, str(error).removeprefix(f"{path}: "))


def _read(trace: Source, file: TraceFile, grows: bool) -> Iterator[LogBatch]:
    if grows and not file.file.read(1):
        return  # nothing was flushed yet
    file.file.seek(0)
    for batch in journal.read(file) if grows else parquet_file.read(file):
        trace.dated = trace.dated or file.dated
        trace.start_ns = file.start_ns if trace.start_ns is None else trace.start_ns
        trace.clock = trace.clock or file.clock
        records = renumbered(batch, trace.channels)
        for at in range(0, len(records), _AT_ONCE):
            yield LogBatch(records[at : at + _AT_ONCE], trace.channels)
