"""What beside.py measures, as it comes."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import threading
from pathlib import Path

from soaking.crowd import Running

_SCRIPT = Path(__file__).with_name("beside.py")


class Meter:
    """One process of beside.py; a thread takes its lines."""

    def __init__(self, what: str, address: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(_SCRIPT), what, address],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        Running.everybody.add(self._process)
        self._times: list[float] = []
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def take(self) -> list[float]:
        """Milliseconds that came since the last time."""
        with self._lock:
            times, self._times = self._times, []
        return times

    def end(self) -> None:
        """Raises AssertionError if it ended otherwise than it was told."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        assert self._process.wait(90) == 0, self._process.args
        self._thread.join()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with self._lock:
                self._times.append(float(line))
