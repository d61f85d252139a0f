"""Queries traces with SQL: `open_trace`."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from typing import Any

from canwire.databases.database import Database
from canwire.databases.loading import load_database
from canwire.errors import BadValue, Closed, ExtraMissing
from canwire.logs.queries.mistakes import EXPLAIN, one_line, unknown_names
from canwire.logs.queries.signals import SignalTables
from canwire.logs.queries.sources import query_source
from canwire.logs.queries.views import VIEWS, entries, quoted
from canwire.logs.source import LogFault
from canwire.values.checks import whole

_Described = Database | str | os.PathLike[str]
_LEAST = 64 << 20
_USUAL = 512 << 20


class Trace:
    """A log for SQL queries, made by `open_trace`; a context manager.

    Tables: `frames`, `errors`, `events`, `lin`, `marks`, `entries` for all of these; with a database `signals`,
    `messages`, and one for each message by its name. `faults` lists parts that could not be read. `connection` is
    the DuckDBPyConnection, for its other functions.
    """

    def __init__(self, path: str, databases: Sequence[tuple[str, Database]], memory_bytes: int) -> None:
        duckdb = _duckdb()
        self.path = path
        self._home = tempfile.TemporaryDirectory(prefix="canwire-")
        self._error: type[Exception] = duckdb.Error
        self._signals: SignalTables | None = None
        self._closed = False
        self.connection: Any = duckdb.connect()
        try:
            self._source = query_source(path, self._home.name)
            self.connection.execute(f"set memory_limit = '{memory_bytes >> 10}KiB'")
            self.connection.execute(
                f"set temp_directory = {quoted(os.path.join(self._home.name, 'spilled'))}"
            )
            self.connection.execute("set preserve_insertion_order = false")
            self.connection.execute("set python_enable_replacements = false")  # ours are no tables
            self.connection.execute(f"create view entries as {entries(self._source)}")
            for name, text in VIEWS.items():
                self.connection.execute(f"create view {name} as {text}")
            if databases:
                self._signals = SignalTables(self.connection, databases)
        except BaseException:
            self.close()
            raise

    @property
    def dated(self) -> bool:
        """True if `time` is a TIMESTAMP_NS (UTC); otherwise it is seconds from the log's zero."""
        return self._source.dated

    @property
    def tables(self) -> list[str]:
        """The names of the tables; those of messages are last."""
        found = ["entries", *VIEWS]
        return found if self._signals is None else [*found, "signals", "messages", *self._signals.names]

    @property
    def faults(self) -> list[LogFault]:
        """Parts that could not be read, with their places: damaged files of a trace are left out of the tables."""
        return list(self._source.faults)

    @property
    def fault_count(self) -> int:
        """The number of faults."""
        return len(self._source.faults)

    def sql(self, query: str) -> Any:
        """The rows of a query: a DuckDBPyRelation, which computes them when they are fetched.

        It has `fetchall()`, `df()` for pandas, `to_arrow_table()`, `pl()`, `to_parquet(file)` and more. None for a
        statement without rows. Raises BadValue, in one line with the place and similar names, for invalid SQL
        and for messages and signals that the database does not contain; Closed.

        >>> with open_trace("day/", database="car.dbc") as trace:  # doctest: +SKIP
        ...     slow = trace.sql("select time, value from signals where signal = 'EngineSpeed' and value < 600").df()
        """
        if self._closed:
            raise Closed(f"trace {self.path}")
        if self._signals is not None:
            self._signals.mention(query)
            wrong = unknown_names(query, self._signals.names, self._signals.signal_names)
            if wrong:
                raise BadValue(f"{self._signals.path}: {wrong}")
        try:
            return self.connection.sql(query)
        except self._error as error:
            raise self.mistake(self._placed(error, query), query) from None

    def mistake(self, error: Exception, query: str) -> BadValue:
        """DuckDB's message about a query, in one line: a relation whose rows are fetched raises duckdb.Error itself."""
        return BadValue(one_line(error, query, self.tables))

    def _placed(self, error: Exception, query: str) -> Exception:
        """Return the same error with its place, which DuckDB's `sql` leaves out; the query is not executed for this."""
        try:
            self.connection.execute(f"{EXPLAIN}\n{query}")
        except self._error as placed:
            return placed
        return error

    def close(self) -> None:
        """Remove the tables; a second call does nothing. Relations are invalid afterwards."""
        if not self._closed:
            self._closed = True
            self.connection.close()
            self._home.cleanup()

    def __enter__(self) -> Trace:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        files = "" if self._closed else f", {len(self._source.files)} files"
        return f"<Trace {self.path!r}{files}{', closed' if self._closed else ''}>"


def open_trace(
    path: str | os.PathLike[str],
    *,
    database: _Described | Sequence[tuple[str, _Described]] | None = None,
    memory_bytes: int = _USUAL,
) -> Trace:
    """Open a trace for SQL queries: a folder that `record` or `create_log` wrote, a Parquet file, or any other log.

    A log of another format is written as a trace first, in a temporary folder. `database` gives names to frames: a
    `Database`, or the file of one, or several as pairs: the channel that it describes, "" for all, and the database.
    DuckDB uses at most `memory_bytes` of memory, and the disk for the rest. Needs canwire[query]. Raises BadLog,
    BadDescription, BadValue, ExtraMissing, OSError.

    >>> with open_trace("day/") as trace:  # doctest: +SKIP
    ...     trace.sql("select id, count(*) from frames group by id order by 2 desc").fetchall()
    """
    whole("memory_bytes", memory_bytes, _LEAST, 1 << 50)
    return Trace(os.fspath(path), _databases(database), memory_bytes)


def _databases(
    told: _Described | Sequence[tuple[str, _Described]] | None,
) -> list[tuple[str, Database]]:
    """Return each database with its channel, "" for all channels; raises BadDescription, BadValue."""
    if told is None:
        return []
    if isinstance(told, Database | str | os.PathLike):
        told = [("", told)]
    if not all(isinstance(one, tuple) and len(one) == 2 and isinstance(one[0], str) for one in told):
        raise BadValue(f"database {told!r}: a database, or pairs of a channel and its database")
    return [(channel, one if isinstance(one, Database) else load_database(one)) for channel, one in told]


def _duckdb() -> Any:
    try:
        import duckdb
    except ModuleNotFoundError:
        raise ExtraMissing("duckdb", "query") from None
    return duckdb
