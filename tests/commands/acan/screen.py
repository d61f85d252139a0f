"""A program on a pseudo terminal of 24 lines of 80, as a person sees it; with pyte. Waits for what is shown."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import struct
import sys
import termios
import time
from collections.abc import Callable, Sequence

import pyte

from tests import warm

LINES, COLUMNS = 24, 80
DEADLINE_S = 60.0  # of one wait, on a busy machine
ON_DOUBLE = ("-m", "tests.commands.acan.on_double")  # Python's arguments for on_double.py beside this


def environment() -> dict[str, str]:
    """For a Python that is to find what this one finds."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


class Screen:
    """`python *words` with the terminal as its only input and output."""

    def __init__(self, words: Sequence[str], folder: str = ".") -> None:
        self._screen = pyte.Screen(COLUMNS, LINES)
        self._stream = pyte.ByteStream(self._screen)
        self._keyboard, inside = pty.openpty()
        fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("HHHH", LINES, COLUMNS, 0, 0))
        self.process = warm.Popen(
            [sys.executable, *words],
            stdin=inside,
            stdout=inside,
            stderr=inside,
            cwd=folder,
            env={**environment(), "TERM": "xterm-256color"},
            start_new_session=True,
        )
        os.close(inside)

    def type(self, keys: bytes) -> None:
        os.write(self._keyboard, keys)

    @property
    def text(self) -> str:
        """What stands there, without blanks at the ends of lines."""
        return "\n".join([line.rstrip() for line in self._screen.display])

    def wait(self, what: str) -> str:
        """Until that is shown; the whole screen."""
        end_s = time.monotonic() + DEADLINE_S
        while what not in self.text:
            assert self._read(end_s - time.monotonic()), f"{what!r} is not shown, but:\n{self.text}"
        return self.text

    def end(self) -> int:
        """Its exit status, once it has ended by itself."""
        end_s = time.monotonic() + DEADLINE_S
        while self._read(end_s - time.monotonic()):
            pass
        return self.process.wait(DEADLINE_S)

    def close(self) -> None:
        self.process.kill()
        self.process.wait(DEADLINE_S)
        os.close(self._keyboard)

    def _read(self, timeout_s: float) -> bool:
        if not select.select([self._keyboard], [], [], max(0.0, timeout_s))[0]:
            return False
        try:
            data = os.read(self._keyboard, 65536)
        except OSError:  # EIO: nobody has the terminal open any more
            return False
        self._stream.feed(data)
        return bool(data)


OpenScreen = Callable[..., Screen]  # the words of a program
