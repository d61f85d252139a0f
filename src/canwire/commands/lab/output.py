"""A file that is written to: its errors are reported with its name."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TextIO


class Output:
    """Text for one file."""

    def __init__(self, file: TextIO, path: str) -> None:
        self._file = file
        self._path = path

    def write(self, text: str) -> None:
        """Raises OSError with the file's name."""
        with naming(self._path):
            self._file.write(text)


@contextlib.contextmanager
def opened(path: str) -> Iterator[Output]:
    """A new file, or one made empty; also what was kept back until it is closed may not fit."""
    with naming(path), open(path, "w", encoding="utf-8", newline="\n") as file:
        yield Output(file, path)


@contextlib.contextmanager
def naming(path: str) -> Iterator[None]:
    """Add this file's name to an OSError that names no file."""
    try:
        yield
    except OSError as error:
        if error.filename is not None:
            raise
        raise OSError(error.errno, error.strerror, path) from error
