"""Reading a network's description, of whatever kind its file is."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from canwire.errors import BadDescription

if TYPE_CHECKING:
    from canwire.databases.database import Database

KINDS = (".dbc", ".arxml", ".kcd", ".sym", ".ldf")


def load_database(path: str | PathLike[str], *, encoding: str | None = None, strict: bool = True) -> Database:
    """The messages that this DBC, ARXML, KCD, SYM or LDF file describes; its ending tells which it is.

    `encoding` is the text's (None: what is usual for its kind). `strict` refuses signals that overlap or do not fit
    into their message. Needs canwire[databases], LDF files canwire[lin]. Raises BadDescription with the file's name,
    ExtraMissing.
    """
    from canwire.databases.can_file import CanFile
    from canwire.databases.database import Database
    from canwire.databases.lin_file import LinFile

    file = Path(path)
    kind = file.suffix.lower()
    if kind not in KINDS:
        raise BadDescription(f"{file}: no network description by its ending; there are {', '.join(KINDS)}")
    if not file.exists():
        raise BadDescription(f"{file}: No such file or directory")
    if kind == ".ldf":
        return Database(str(file), LinFile(file, encoding))
    return Database(str(file), CanFile(file, encoding, strict))
