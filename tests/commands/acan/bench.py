"""Two machines on one bus: a hub in a process of its own with two INduCAN104, and `canwire acan` on them."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from tests import hubs, warm
from tests.commands.acan.screen import Screen

ONE, TWO = "HW000104", "HW000105"
CONFIG = f"""
[[bus]]
name = "can0"

[[board]]
kind = "inducan104"
serial = "{ONE}"
base = 0x280
irq = 5
buses = ["can0"]

[[board]]
kind = "inducan104"
serial = "{TWO}"
base = 0x300
irq = 7
buses = ["can0"]
"""
LONG_S = 60.0


class Bench:
    """`board` is the machine, ONE or TWO; everything ends with the bench."""

    def __init__(self, address: str, hub: subprocess.Popen[str], closing: ExitStack) -> None:
        self.address = address
        self._hub = hub
        self._closing = closing

    def words(self, program: str, board: str, *words: str) -> list[str]:
        place = ["--board", board] if board else []
        return ["-m", "canwire", "acan", program, *words, *place, "--hub", self.address]

    def screen(self, program: str, board: str, *words: str) -> Screen:
        """On a pseudo terminal."""
        screen = Screen(self.words(program, board, *words))
        self._closing.callback(screen.close)
        return screen

    def start(self, program: str, board: str, *words: str) -> subprocess.Popen[str]:
        """With pipes."""
        process = warm.Popen(
            [sys.executable, *self.words(program, board, *words)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._closing.callback(_end, process)
        return process

    def end_hub(self) -> None:
        _end(self._hub)

    def run(self, program: str, board: str, *words: str, typed: str = "") -> tuple[int, str, str]:
        """Until its end: exit status, stdout, stderr."""
        process = self.start(program, board, *words)
        out, err = process.communicate(typed, timeout=LONG_S)
        return process.returncode, out, err


@contextmanager
def serving(home: Path) -> Iterator[Bench]:
    """In real time."""
    with hubs.serving(home, CONFIG, time="real") as (address, hub), ExitStack() as closing:
        yield Bench(address, hub, closing)


def _end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    process.wait(LONG_S)
    for pipe in (process.stdin, process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
