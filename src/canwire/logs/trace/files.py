"""The files of a trace in its folder: 00001.parquet, 00002.parquet, ..., the growing one as 00003.parquet.journal."""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO

from canwire.errors import BadLog
from canwire.logs.journal import SUFFIX

PARQUET = ".parquet"


def file_name(number: int) -> str:
    """The name of the file with this number, from 1 on."""
    return f"{number:05d}{PARQUET}"


def files_of(folder: str) -> list[Path]:
    """Return complete files and journals in their order, by name; a journal whose file is complete is left out.

    Raises BadLog for a folder that is no trace, OSError.
    """
    if not os.path.isdir(folder):
        raise BadLog(f"{folder}: no folder, so no trace")
    names = set(os.listdir(folder))
    whole = {name for name in names if name.endswith(PARQUET)}
    growing = {
        name for name in names if name.endswith(PARQUET + SUFFIX) and name.removesuffix(SUFFIX) not in whole
    }
    if not whole and not growing:
        raise BadLog(f"{folder}: a folder without Parquet files, so no trace")
    return [Path(folder, name) for name in sorted(whole | growing)]


def opened(path: Path) -> tuple[BinaryIO, Path]:
    """Open the file, and return its present name: a journal may have become a complete file since it was listed."""
    try:
        return path.open("rb"), path
    except FileNotFoundError:
        if not is_journal(path):
            raise
        whole = path.with_name(path.name.removesuffix(SUFFIX))
        return whole.open("rb"), whole


def is_journal(path: Path) -> bool:
    """Whether the file is a journal, because it grows or its writer was killed."""
    return path.name.endswith(SUFFIX)
