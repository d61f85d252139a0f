"""The file of a trace. It is written while time passes, so its errors name the file."""

from __future__ import annotations

from pathlib import Path

from canwire.errors import CanwireError
from canwire.forks import hear_of_forks, lead_nowhere


class TraceFile:
    """A text file for a trace. Raises OSError with the name of the file.

    `left` in a forked process: the file is the parent's, `write` raises CanwireError and `close` does nothing.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = str(path)
        self.left = False
        self._file = Path(path).open("w", encoding="ascii", newline="\n")  # noqa: SIM115 - `close` closes it
        hear_of_forks(self)

    def write(self, text: str) -> int:
        if self.left:
            raise CanwireError(
                f"{self._path}: this trace belongs to the process that was forked; in this one call `end_trace`, "
                f"or `trace_levels` with another file"
            )
        try:
            return self._file.write(text)
        except OSError as error:
            raise self._named(error) from error

    def close(self) -> None:
        """Write buffered text and close the file; a second call does nothing."""
        try:
            self._file.close()
        except OSError as error:
            raise self._named(error) from error

    def leave_to_parent(self) -> None:
        """In a forked process: discard buffered text."""
        if not self._file.closed:
            self.left = True
            lead_nowhere(self._file)

    def _named(self, error: OSError) -> OSError:
        return OSError(error.errno, error.strerror, self._path)
