"""Reads a network description from a file of any known kind."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from canwire.errors import BadDescription
from canwire.values.checks import instance
from canwire.values.mistakes.calls import answers_wrong_calls

if TYPE_CHECKING:
    from canwire.databases.database import Database

MOST_SECONDS = 600.0
MOST_BYTES = 1 << 26
"""Of a file: parsers of text take some hundred times as much memory."""
KINDS = (".dbc", ".arxml", ".kcd", ".sym", ".ldf")


@answers_wrong_calls
def load_database(
    path: str | PathLike[str],
    *,
    encoding: str | None = None,
    strict: bool = True,
    j1939: bool | None = None,
    most_bytes: int = MOST_BYTES,
    seconds: float = MOST_SECONDS,
) -> Database:
    """Load a DBC, ARXML, KCD, SYM or LDF file; its suffix gives the kind.

    `encoding` is that of the text (None: the default of the kind). `strict` refuses signals that overlap or do not fit
    into their message. `j1939` says whether messages with 29-bit identifiers are J1939 messages, recognised by their
    PGN (None: those that the file marks so, which only DBC files can). A file of more than `most_bytes`, or one that
    needs more than `seconds` to read, is refused. Needs canwire[databases], for LDF files canwire[lin].
    Raises BadDescription with the file's name, ExtraMissing.
    """
    from canwire.databases.can_file import CanFile
    from canwire.databases.database import Database
    from canwire.databases.lin_file import LinFile
    from canwire.platform.foreign_reader import foreign_reader

    instance("path", path, str, PathLike)
    file = Path(path)
    kind = file.suffix.lower()
    if kind not in KINDS:
        raise BadDescription(f"{file}: no network description by its ending; there are {', '.join(KINDS)}")
    if not file.exists():
        raise BadDescription(f"{file}: No such file or directory")
    with foreign_reader(file, most_bytes, seconds, "it means nothing here"):
        described = LinFile(file, encoding) if kind == ".ldf" else CanFile(file, encoding, strict, j1939)
        return Database(str(file), described)
