"""The file of a trace: bits are written while time passes, so what goes wrong with it has to name it."""

from __future__ import annotations

from pathlib import Path


class TraceFile:
    """As much of a text file as a trace needs. Raises OSError with the file's name."""

    def __init__(self, path: str | Path) -> None:
        self._path = str(path)
        self._file = Path(path).open("w", encoding="ascii", newline="\n")  # noqa: SIM115 - `close` closes it

    def write(self, text: str) -> int:
        try:
            return self._file.write(text)
        except OSError as error:
            raise self._named(error) from error

    def close(self) -> None:
        """Write what was kept back; a second time does nothing."""
        try:
            self._file.close()
        except OSError as error:
            raise self._named(error) from error

    def _named(self, error: OSError) -> OSError:
        return OSError(error.errno, error.strerror, self._path)
