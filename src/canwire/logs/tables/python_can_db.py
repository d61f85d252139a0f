"""Writes python-can's SQLite: a table `messages`. The format `sqlite` reads it.

Source: python-can 4.6, can/io/sqlite.py."""

from __future__ import annotations

import sqlite3
from typing import TYPE_CHECKING, ClassVar

from canwire.logs.entry import LogKind
from canwire.logs.tables import sqlite_file
from canwire.logs.tables.foreign import FRAMES_AND_ERRORS, python_can_rows
from canwire.logs.tables.sqlite_file import read

if TYPE_CHECKING:
    import numpy

__all__ = ["Writer", "read", "recognises"]


class Writer(sqlite_file.Writer):
    """The table that python-can makes."""

    holds: ClassVar[frozenset[LogKind]] = FRAMES_AND_ERRORS
    table: ClassVar[str] = "messages"
    schema: ClassVar[str] = (
        "create table messages(ts real, arbitration_id integer, extended integer, remote integer, error integer,"
        " dlc integer, data blob);"
    )
    index: ClassVar[str] = ""

    def rows(self, records: numpy.ndarray) -> list[tuple[object, ...]]:
        """Return the rows of the table for these records."""
        return [(row.time_ns / 1e9, *row[1:]) for row in python_can_rows(self, records)]

    def about(self, database: sqlite3.Connection) -> None:
        """Do nothing: python-can's file has one table."""


def recognises(head: bytes) -> bool:
    """Return False: the format `sqlite` reads these files."""
    del head
    return False
