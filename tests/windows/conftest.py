"""Windows' programs for these tests; CANWIRE_WINDOWS is what starts its Python."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import subprocess
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest

LONG_S = 120  # after which something that should happen never will
PYTHON = os.environ.get("CANWIRE_WINDOWS", "")

Program = subprocess.Popen[str]


class Windows(NamedTuple):
    """`start` begins `python WORDS`, `run` has its output; `path` is what Linux' file is called there."""

    start: Callable[..., Program]
    run: Callable[..., str]

    @staticmethod
    def path(path: Path) -> str:
        return "Z:" + str(path).replace("/", "\\")

    def canwire(self, *words: str) -> str:
        """What this verb says."""
        return self.run("-m", "canwire", *words)

    def done(self, *words: str) -> str:
        """The same of one that has to end well."""
        program = self.start("-m", "canwire", *words)
        said, _ = program.communicate(timeout=LONG_S)
        assert program.returncode == 0, f"canwire {' '.join(words)} ended with {program.returncode}: {said}"
        return said


class Console:
    """A program of Windows in a console of its own, which a pseudo terminal of Linux shows."""

    def __init__(self, *words: str) -> None:
        self._shown, program = pty.openpty()
        self._said = b""
        self.process = subprocess.Popen(
            [PYTHON, *words], stdin=program, stdout=program, stderr=program, preexec_fn=_have_the_terminal
        )
        os.close(program)

    def wait_for(self, text: str) -> str:
        """What was shown, as soon as it has this in it."""
        while text.encode() not in self._said:
            self._said += self._read() or _ended(self._said, text)
        return self._said.decode(errors="replace")

    def type(self, keys: bytes) -> None:
        os.write(self._shown, keys)

    def end(self) -> int:
        """Its exit status, once it has ended by itself; what shows its console may stay a while longer."""
        ended = os.pidfd_open(self.process.pid)
        try:
            while ended not in self._ready(ended):
                self._said += self._read()
        finally:
            os.close(ended)
        return self.process.wait(LONG_S)

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait(LONG_S)
        os.close(self._shown)

    def _read(self) -> bytes:
        self._ready()
        try:
            return os.read(self._shown, 4096)
        except OSError:  # Linux' way to say that nobody has the other end any more
            return b""

    def _ready(self, *others: int) -> list[int]:
        """Those of these and of what is shown that can be read; waits for the first."""
        found, _, _ = select.select([self._shown, *others], [], [], LONG_S)
        if not found:
            raise AssertionError(f"{self.process.args} says no more: {self._said.decode(errors='replace')}")
        return found


def _ended(said: bytes, text: str) -> bytes:
    raise AssertionError(f"it ended without {text!r}: {said.decode(errors='replace')}")


def _have_the_terminal() -> None:
    os.setsid()
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def line_of(program: Program, holds: str) -> str:
    """The first line of its output with these words in it."""
    assert program.stdout is not None
    said = []
    for line in program.stdout:
        said.append(line)
        if holds in line:
            return line
    raise AssertionError(f"{program.args} ended without {holds!r}: {''.join(said)}")


@contextmanager
def programs() -> Iterator[Windows]:
    """Those of Windows; what still runs in the end is killed."""
    if not PYTHON:
        pytest.skip("here is no Python of Windows: bash .ci/windows makes one, and runs these tests")
    running: list[Program] = []

    def start(*words: str) -> Program:
        made = subprocess.Popen(  # Wine takes pipes for streams, and neither /dev/null nor files
            [PYTHON, *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="cp1252",
        )
        running.append(made)
        return made

    def run(*words: str) -> str:
        said, _ = start(*words).communicate(timeout=LONG_S)
        return said

    try:
        yield Windows(start, run)
    finally:
        for program in running:
            program.kill()
            with program:  # its streams are closed: another program may have their other ends
                pass


@pytest.fixture
def windows() -> Iterator[Windows]:
    with programs() as made:
        yield made


@pytest.fixture(scope="package")
def hub(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A hub on Windows, for all tests: its address there."""
    with programs() as made:
        address = made.path(tmp_path_factory.mktemp("windows") / "hub")
        line_of(made.start("-m", "canwire", "serve", "--time", "fast", "--socket", address), "canwire hub on")
        yield address


@pytest.fixture(scope="package")
def page(hub: str) -> Iterator[str]:
    """`canwire web` on this hub: the address of its page, with the token."""
    with programs() as made:
        web = made.start("-m", "canwire", "web", "--port", "0", "--hub", hub)
        found = re.search(r"http://\S+", line_of(web, "canwire web:"))
        assert found is not None
        yield found[0]
