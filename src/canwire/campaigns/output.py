"""The output of runs goes into a file, because a terminal or a log could not show which run printed it."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile

MOST = 1 << 16  # bytes that are kept of a run: its last


class Output:
    """A file without a name that two processes share: one prints to it, and both can read what was printed."""

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115

    def take_over(self) -> None:
        """Redirect standard output and error of this process, and of programs that it starts, to the file."""
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:  # it was closed before the program began
                stream.flush()
        for standard in (1, 2):
            os.dup2(self._file.fileno(), standard)
        sys.stdout = open(1, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115

    def taken(self) -> str:
        """The last 65,536 bytes that were printed since the previous call."""
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(ValueError, AttributeError, OSError):  # a run has closed or replaced it
                stream.flush()
        number = self._file.fileno()
        size = os.fstat(number).st_size
        if not size:
            return ""
        text = os.pread(number, MOST, max(0, size - MOST)).decode("utf-8", "backslashreplace")
        os.lseek(number, 0, os.SEEK_SET)
        os.ftruncate(number, 0)
        return text

    def close(self) -> None:
        self._file.close()
