"""SQLite: a table `entries` with the columns of columns.py, indexed by time and identifier; python-can's is read."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, ClassVar

from canwire.errors import BadFrame, BadLog, BadText
from canwire.logs.batch import LogBatch
from canwire.logs.beside import Beside
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.form import FormWriter
from canwire.logs.source import Source
from canwire.logs.tables.columns import COLUMNS, Row, rows_of
from canwire.logs.tables.csv.rows import error_of_python_can, ns_of_float
from canwire.values.frame import Frame

if TYPE_CHECKING:
    import numpy

_ROWS = 1000  # in one step: each may have as many bytes as a line
_TABLE = """
create table entries(time_ns integer not null, channel text not null, direction text, type text not null, id integer,
    extended integer, remote integer, fd integer, brs integer, esi integer, dlc integer, data blob, detail text);
create table canwire(name text primary key, value text);
"""
_INDEX = "create index by_time on entries(time_ns); create index by_id on entries(id, time_ns);"


class Writer(FormWriter):
    """A new database; a row is permanent after `sync` has committed it. Indexes are made at the end."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)
    opens: ClassVar[bool] = False
    table: ClassVar[str] = "entries"
    schema: ClassVar[str] = _TABLE
    index: ClassVar[str] = _INDEX

    def begin(self) -> None:
        if self.path == "-":
            raise BadLog("sqlite: a database cannot be written to standard output")
        with Beside(self.path) as made:
            self._guarded(lambda: self._make(made))
        self._database = sqlite3.connect(self.path, check_same_thread=False)
        self._pending = 0

    def put(self, records: numpy.ndarray) -> None:
        rows = self.rows(records)
        if rows:
            marks = ",".join("?" * len(rows[0]))
            insert = f"insert into {self.table} values({marks})"
            self._guarded(lambda: self._database.executemany(insert, rows))
        self._pending += len(rows)

    def rows(self, records: numpy.ndarray) -> Sequence[tuple[object, ...]]:
        """Return the rows of the table for these records."""
        return rows_of(records, self.channels)

    def about(self, database: sqlite3.Connection) -> None:
        """Write the facts of the log."""
        facts = {"version": "1", "dated": str(int(self.dated)), "clock": self.clock}
        if self.start_ns is not None:
            facts["start_ns"] = str(self.start_ns)
        database.executemany("insert into canwire values(?, ?)", facts.items())

    def sync(self) -> None:
        self._guarded(self._database.commit)
        self.count += self._pending
        self._pending = 0

    def end(self) -> None:
        try:
            self.sync()
            self._guarded(lambda: self._database.executescript(self.index))
        finally:
            self._database.close()

    def give_up(self) -> None:
        self._database.close()

    def leave_to_parent(self) -> None:
        import ctypes  # here alone: SQLite would take back what the parent has begun, whenever this were collected

        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._database))

    def _make(self, path: str) -> None:
        """Make a database without rows."""
        open(path, "wb").close()  # says in the system's words what would be wrong with it
        with closing(sqlite3.connect(path)) as database:
            database.executescript(self.schema)
            self.about(database)
            database.commit()

    def _guarded(self, work: object) -> None:
        """Call `work`; an error of SQLite for a full disk becomes the OSError of the system."""
        try:
            work()  # type: ignore[operator]
        except sqlite3.OperationalError as error:
            if "full" not in str(error) and "disk I/O" not in str(error):
                raise
            import errno

            raise OSError(errno.ENOSPC, str(error)) from error


def recognises(head: bytes) -> bool:
    """Recognises the format by its magic words."""
    return head.startswith(b"SQLite format 3\0")


def read(source: Source) -> Iterator[LogBatch]:
    """Yield batches of rows by time; an invalid row is a fault. Raises BadLog for another database."""
    if source.path == "-":
        raise BadLog("sqlite: a database cannot be read from standard input")
    with ExitStack() as closing_all:
        try:
            database = _opened(source.path, closing_all)
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, source.limits.line_bytes)
            database.execute("pragma trusted_schema = off")
            yield from _read(source, database)
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:  # names in a damaged file, too
            source.fault("database", str(error))


def _opened(path: str, closing_all: ExitStack) -> sqlite3.Connection:
    """Open a database only for reading; if its writer was killed, open a copy, because SQLite must undo unfinished
    writes."""
    database = closing_all.enter_context(closing(_connected(path, "ro")))
    try:
        database.execute("select name from sqlite_master").fetchone()
    except sqlite3.OperationalError as error:
        if not error.sqlite_errorname.startswith("SQLITE_READONLY"):
            raise
        folder = closing_all.enter_context(TemporaryDirectory(prefix="canwire-"))
        for suffix in ("", "-journal"):
            shutil.copy(path + suffix, f"{folder}/log{suffix}")
        database = closing_all.enter_context(closing(_connected(f"{folder}/log", "rw")))
    return database


def _connected(path: str, mode: str) -> sqlite3.Connection:
    return sqlite3.connect(f"file:{_quoted(path)}?mode={mode}", uri=True)


def _read(source: Source, database: sqlite3.Connection) -> Iterator[LogBatch]:
    tables = {name for (name,) in database.execute("select name from sqlite_master where type='table'")}
    if "entries" in tables:
        facts = dict(database.execute("select name, value from canwire")) if "canwire" in tables else {}
        source.clock = facts.get("clock", "")
        source.dated = facts.get("dated") == "1"
        source.start_ns = int(facts["start_ns"]) if "start_ns" in facts else None
        rows = database.execute(f"select rowid, {', '.join(COLUMNS)} from entries order by rowid")
    elif "messages" in tables:
        rows = database.execute(
            "select rowid, ts, arbitration_id, extended, remote, error, dlc, data from messages order by rowid"
        )
    else:
        raise BadLog(
            f"{source.path}: a database without a table of entries; it has {', '.join(sorted(tables)) or 'none'}"
        )
    parse = _of_ours if "entries" in tables else _of_python_can
    while listed := rows.fetchmany(_ROWS):
        found = []
        for number, *values in listed:
            try:
                found.append(parse(values))
            except (BadFrame, BadText, TypeError, ValueError) as error:
                source.fault(f"row {number}", str(error))
        if found:
            source.infer_date(found[0].timestamp_ns)
            yield source.batch(found)


def _quoted(path: str) -> str:
    from urllib.parse import quote

    return quote(path)


def _of_ours(values: list[object]) -> LogEntry:
    row = Row(*values)  # type: ignore[arg-type]
    return row._replace(data=row.data or b"", detail=row.detail or "").entry()


def _of_python_can(values: list[object]) -> LogEntry:
    time_s, id, extended, remote, error, dlc, data = values
    time_ns = ns_of_float(time_s)  # type: ignore[arg-type]
    content = bytes(data or b"")  # type: ignore[call-overload]
    number = int(id)  # type: ignore[call-overload]
    if error:
        return LogEntry(time_ns, "can0", error_of_python_can(number, content, time_ns))
    fd = len(content) > 8
    frame = Frame(number, b"" if remote else content, extended=bool(extended), remote=bool(remote), fd=fd,
                  dlc=None if fd else dlc, timestamp_ns=time_ns)  # type: ignore[arg-type]  # fmt: skip
    return LogEntry(time_ns, "can0", frame)
