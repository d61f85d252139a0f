"""The formats of logs: their names, files, readers and writers, and what each can hold."""

from __future__ import annotations

import difflib
import importlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from canwire.errors import BadLog, BadValue

HEAD = 4096
"""Number of bytes at the start of a file by which its format is recognised."""


@dataclass(frozen=True)
class LogFormat:
    """A row of the table: `module` has `recognises(head)`, `read(source)` and, if it `writes`, `Writer`.

    `suffixes` are those of its files, the default first; `what` describes the format in lists.
    """

    name: str
    suffixes: tuple[str, ...]
    module: str
    what: str
    writes: bool = True


_ROWS = (
    LogFormat("candump", (".log", ".candump", ".txt"), "candump", "candump -l, -L and its screen lines"),
    LogFormat("csv", (".csv",), "tables.csv", "a row for an entry; read by its header's names"),
    LogFormat("asc", (".asc",), "asc", "Vector's text form"),
    LogFormat("trc", (".trc",), "trc", "PEAK's, 1.0 to 2.1; written is 2.1"),
    LogFormat("parquet", (".parquet",), "tables.parquet_file", "a row for an entry, for pandas and DuckDB"),
    LogFormat("pcapng", (".pcapng", ".pcap"), "pcapng", "Wireshark's; pcap is read, too"),
    LogFormat(
        "sqlite", (".db", ".sqlite", ".sqlite3"), "tables.sqlite_file", "a database; python-can's is read"
    ),
    LogFormat("blf", (".blf",), "blf", "Vector's binary form"),
    LogFormat("mf4", (".mf4",), "mf4", "ASAM MDF 4, in the layout for bus logging"),
    LogFormat("trace", (".trace",), "trace", "a folder of Parquet files, for `canwire query`"),
    LogFormat("journal", (".journal",), "journal", "a recording that is not finished yet"),
    LogFormat("gvret", (".csv",), "tables.gvret", "SavvyCAN's CSV; `csv` reads it"),
    LogFormat("python-can-csv", (".csv",), "tables.python_can_csv", "python-can's CSV; `csv` reads it"),
    LogFormat("python-can-db", (".db",), "tables.python_can_db", "python-can's SQLite; `sqlite` reads it"),
    LogFormat("busmaster", (".log",), "busmaster", "BUSMASTER's text form", writes=False),
    LogFormat("microchip", (".log",), "microchip", "Microchip's CAN BUS Analyzer", writes=False),
    LogFormat("carbus", (".trc",), "carbus", "CARBUS Analyzer (CAN-Hacker)", writes=False),
)
FORMATS = {row.name: row for row in _ROWS}


def log_formats() -> list[LogFormat]:
    """All formats of logs."""
    return list(FORMATS.values())


def load_format(row: LogFormat) -> Any:
    """The module that reads and writes the format."""
    return importlib.import_module(f"canwire.logs.{row.module}")


def format_named(name: str) -> LogFormat:
    """The format of that name; raises BadValue with similar names."""
    if name in FORMATS:
        return FORMATS[name]
    near = difflib.get_close_matches(name.lower().lstrip("."), _known(), 3, 0.5)
    meant = list(dict.fromkeys(_known()[word] for word in near))
    hint = f"did you mean {' or '.join(meant)}?" if meant else "there are " + ", ".join(FORMATS)
    raise BadValue(f"no log format {name!r}; {hint}")


def format_to_write(path: str, name: str | None) -> LogFormat:
    """The format for writing a file of that name; raises BadValue for an unknown suffix or a read-only format."""
    if name is None and (path.endswith(("/", os.sep)) or os.path.isdir(path)):
        return FORMATS["trace"]
    if name is None:
        suffix = Path(path).suffix.lower()
        found = next((row for row in FORMATS.values() if suffix in row.suffixes and row.writes), None)
        if found is None:
            told = f"{path}: " + (
                f"no log format has {suffix!r}" if suffix else "no suffix that tells a format"
            )
            near = difflib.get_close_matches(
                suffix, [s for row in FORMATS.values() for s in row.suffixes], 2, 0.5
            )
            hint = f"did you mean {' or '.join(near)}?" if near else "name one: " + ", ".join(FORMATS)
            raise BadValue(f"{told}; {hint}")
        return found
    row = format_named(name)
    if not row.writes:
        raise BadValue(
            f"{row.name}: read only; written are " + ", ".join(r.name for r in FORMATS.values() if r.writes)
        )
    return row


def format_of_file(path: str, head: bytes) -> LogFormat:
    """Return the format of a file with this beginning; if several match, its suffix decides. Raises
    BadLog for no log."""
    suffix = Path(path).suffix.lower()
    rows = sorted(FORMATS.values(), key=lambda row: suffix not in row.suffixes)
    for row in rows:
        if load_format(row).recognises(head):
            return row
    if not head:
        raise BadLog(f"{path}: an empty file, so no log")
    shown = head[:32].decode("ascii", "backslashreplace").splitlines()[0] if head else ""
    raise BadLog(f"{path} is no log that canwire knows ({', '.join(FORMATS)}); it begins with {shown!r}")


def _known() -> dict[str, str]:
    """Words that mean a format: names and suffixes."""
    found = {row.name: row.name for row in FORMATS.values()}
    for row in FORMATS.values():
        for suffix in row.suffixes:
            found.setdefault(suffix.lstrip("."), row.name)
    return found
