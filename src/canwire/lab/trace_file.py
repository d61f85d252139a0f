"""The file of a trace: bits are written while time passes, so what goes wrong with it has to name it."""

from __future__ import annotations

from pathlib import Path

from canwire.forks import hear_of_forks, lead_nowhere


class TraceFile:
    """As much of a text file as a trace needs. Raises OSError with the file's name."""

    def __init__(self, path: str | Path) -> None:
        self._path = str(path)
        self._file = Path(path).open("w", encoding="ascii", newline="\n")  # noqa: SIM115 - `close` closes it
        hear_of_forks(self)

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

    def leave_to_parent(self) -> None:
        """In a forked process: the file is the parent's, so what is kept back here, and what comes, goes nowhere."""
        if not self._file.closed:
            lead_nowhere(self._file)

    def _named(self, error: OSError) -> OSError:
        return OSError(error.errno, error.strerror, self._path)
