"""A program that is started again when it ends, as systemd would do it, and what it has said."""

from __future__ import annotations

import contextlib
import json
import os
import select
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

_PAUSE_S = 0.5  # before it is started again


class Kept:
    """`words` makes its command for its how-manieth life. `speaks`: it answers `account`; else its output is text."""

    def __init__(
        self,
        name: str,
        words: Callable[[int], list[str]],
        home: Path,
        environment: dict[str, str],
        speaks: bool,
    ) -> None:
        self.name, self.speaks = name, speaks
        self.text, self.log = home / f"{name}.out", home / f"{name}.err"
        self.lives = -1
        self.ends: list[str] = []
        self.over: list[dict[str, Any]] = []
        self._words, self._environment = words, {**os.environ, **environment}
        self._again_s = 0.0
        self.start()

    def start(self) -> None:
        """Its next life."""
        self.lives += 1
        self.since_s = time.monotonic()
        with self.log.open("a") as said, self.text.open("ab") as output:
            self.process = subprocess.Popen(
                self._words(self.lives),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE if self.speaks else output,
                stderr=said,
                env=self._environment,
            )

    def look(self) -> bool:
        """Has it ended? Then it is started again, after a pause."""
        if self.process.poll() is None:
            return False
        if not self._again_s:
            self._again_s = time.monotonic() + _PAUSE_S
            self._account_of_its_end()
        elif time.monotonic() >= self._again_s:
            self._again_s = 0.0
            self.start()
        return True

    def _account_of_its_end(self) -> None:
        last = ""
        if self.process.stdout is not None:
            lines = self.process.stdout.read().decode().splitlines()
            for line in lines:
                if '"over"' in line:
                    self.over.append(json.loads(line))
                    last = str(self.over[-1]["over"])
            self.process.stdout.close()
        if self.process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                self.process.stdin.close()
        if not last:
            last = (self.log.read_text(errors="replace").splitlines() or [""])[-1]
        self.ends.append(f"{self.process.returncode}: {last}"[:160])

    def account(self, patience_s: float = 10.0) -> dict[str, Any] | None:
        """What it says of itself; None if it has ended or does not answer in time."""
        if self.process.poll() is not None:
            return None
        self.say("account")
        ends = time.monotonic() + patience_s
        text = b""
        assert self.process.stdout is not None
        while time.monotonic() < ends:
            if not select.select([self.process.stdout], [], [], 0.2)[0]:
                continue
            part = os.read(self.process.stdout.fileno(), 1 << 16)
            if not part:
                return None
            text += part
            for line in text[: text.rfind(b"\n") + 1].splitlines():
                if line.startswith(b"{") and b'"over"' not in line:
                    found: dict[str, Any] = json.loads(line)
                    return found
        return None

    def say(self, word: str) -> None:
        """A word on its input, if it has ears left."""
        if self.process.stdin is not None:
            with contextlib.suppress(BrokenPipeError, ValueError):
                self.process.stdin.write(f"{word}\n".encode())
                self.process.stdin.flush()

    def kill(self) -> None:
        """For good."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):
                    pipe.close()
