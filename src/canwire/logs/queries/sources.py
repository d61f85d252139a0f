"""The Parquet files of a query: files of any origin, those of a trace, or files made from a journal or another log."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

from canwire.errors import BadLog
from canwire.logs.convert import convert_log
from canwire.logs.log import open_log
from canwire.logs.source import LogFault
from canwire.logs.tables.order import ROW
from canwire.logs.tables.parquet_file import open_parquet
from canwire.logs.trace.files import files_of, is_journal, opened


class QuerySource(NamedTuple):
    """Files that DuckDB can read, all with the same columns; if `sorted_`, with a column `row`. Also lists faults."""

    files: list[str]
    dated: bool
    sorted_: bool
    faults: list[LogFault]


def query_source(path: str, home: str) -> QuerySource:
    """Return the files of a trace, or of any other log; other logs and journals are first converted into `home`.

    An unreadable file of a trace is a fault. Raises BadLog if there is nothing to read, OSError.
    """
    if os.path.isdir(path):
        return _checked(path, files_of(path), home)
    with open_log(path) as log:
        if log.format == "parquet":
            return _checked(path, [Path(path)], home)
        made = convert_log(log, os.path.join(home, "log.trace"))
        found = _checked(path, files_of(made.path), home)
        return found._replace(faults=log.faults + found.faults)


def _checked(path: str, listed: list[Path], home: str) -> QuerySource:
    files: list[str] = []
    faults: list[LogFault] = []
    dated, rows = False, True
    for number, file in enumerate(listed):
        try:
            file = _found(file)
            if is_journal(file):
                if not file.stat().st_size:
                    continue  # nothing was flushed yet
                file = _whole(file, Path(home, f"{number}.parquet"), faults)
            with file.open("rb") as opened:
                found, about = open_parquet(str(file), opened)
                rows = rows and ROW in found.schema_arrow.names
                dated = dated or bool(about["dated"])
            files.append(str(file))
        except (BadLog, OSError) as error:
            faults.append(LogFault(file.name, str(error).removeprefix(f"{file}: ")))
    if not files:
        raise BadLog(f"{path}: nothing of it can be read" + (f"; {faults[0]}" if faults else " yet"))
    return QuerySource(files, dated, rows, faults)


def _found(file: Path) -> Path:
    """Return the present name of a file, which may have changed from a journal to a complete file."""
    handle, file = opened(file)
    handle.close()
    return file


def _whole(journal: Path, made: Path, faults: list[LogFault]) -> Path:
    """Convert the journal of a running or killed recording to a Parquet file."""
    with open_log(journal, format="journal") as log:
        convert_log(log, made)
        faults += [LogFault(f"{journal.name}, {where}", what) for where, what in log.faults]
    return made
