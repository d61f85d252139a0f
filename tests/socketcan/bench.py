"""Programs under `canwire run` on a hub of this test's own, and the bus as `canwire dump` shows it."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import LinePlace, LineStatus, every_line, lines_now
from tests import warm
from tests.hubs import LONG_S, Served, serving
from tests.missing import find_program, supported

Process = subprocess.Popen[str]


class Bench:
    """`home` is the programs' working directory."""

    def __init__(self, served: Served, home: Path) -> None:
        self.address = served.address
        self.home = home
        self.hub = canwire.connect(self.address, name="bench")
        self._served = served
        self._processes: list[Process] = []

    def close(self) -> None:
        for process in self._processes:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # what it has forked, too
            process.communicate(timeout=LONG_S)
        self.hub.close()

    def start(self, *words: str, options: tuple[str, ...] = (), **more: Any) -> Process:
        """`canwire run` with a program."""
        need(words[0])
        return self._started(["run", *options, "--", *words], more)

    def listening(self, *words: str, options: tuple[str, ...] = (), ports: int = 1, **more: Any) -> Process:
        """The same, once it hears so many interfaces more, and has given back the controls that it started them by.

        A channel is there before it is active, and before the program's call that asked for it has returned.
        """
        before = self._lines()

        def hears() -> bool:
            now = self._lines()
            return (
                channels_of(now) >= channels_of(before) + ports
                and held_of(now) <= held_of(before)
                and self.servers_wait()
            )

        process = self.start(*words, options=options, **more)
        self.until(lambda: hears() or process.poll() is not None)
        if process.poll() is not None:
            raise AssertionError(f"{words[0]} has ended: {process.communicate()}")
        return process

    def run(self, *words: str, options: tuple[str, ...] = (), status: int = 0, stdin: str = "") -> str:
        """Its output, once it has ended with this status."""
        process = self.start(*words, options=options, stdin=subprocess.PIPE)
        output, errors = process.communicate(stdin, timeout=LONG_S)
        assert process.returncode == status, (words, output, errors)
        return output

    def dump(self, *words: str) -> Process:
        """`canwire dump`, once it listens."""
        process = self._started(["dump", *words], {})
        assert process.stderr is not None
        line = process.stderr.readline()
        assert "listening" in line, line
        return process

    def stop_hub(self) -> None:
        self._served.process.terminate()
        self._served.process.wait(LONG_S)

    def kill_hub(self) -> None:
        self._served.process.kill()
        self._served.process.wait(LONG_S)

    def channels(self) -> int:
        """Of all CAN lines together."""
        return channels_of(self._lines())

    def _lines(self) -> list[tuple[LinePlace, LineStatus]]:
        return lines_now(self.hub, every_line(self.hub, "CAN"))

    def servers_wait(self) -> bool:
        """Whether the servers of all programs wait for requests: what was asked of them before is done."""
        others = {os.getpid(), *(process.pid for process in self._processes)}
        for process in map(int, filter(str.isdigit, os.listdir("/proc"))):
            with suppress(OSError):  # it has ended, or is another user's
                place = Path("/proc", str(process))
                if process in others or os.getsid(process) != process:
                    continue
                # else it works, or waits for the hub's answer
                waits = "poll" in (place / "wchan").read_text()
                if not waits and os.readlink(place / "cwd") == str(self.home):
                    return False
        return True

    @staticmethod
    def until(condition: Callable[[], bool]) -> None:
        end_s = time.monotonic() + LONG_S
        while not condition():
            assert time.monotonic() < end_s, "it never came"
            select.select([], [], [], 0.005)  # what is waited for is in another process, and tells nobody

    def _started(self, words: list[str], more: dict[str, Any]) -> Process:
        environment = {**os.environ, "CANWIRE_HUB": self.address}
        usual = {"env": environment, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        process = warm.Popen(
            [sys.executable, "-m", "canwire", *words],
            cwd=self.home,
            start_new_session=True,
            text=True,
            **{**usual, **more},
        )
        self._processes.append(process)
        return process


def on_a_hub_of_its_own(home: Path, time: str = "fast") -> Iterator[Bench]:
    """For a fixture; the hub has the usual boards. Skips the test where `canwire run` cannot be."""
    if sys.platform != "linux":
        pytest.skip("SocketCAN programs are Linux's")
    from canwire.socketcan.launch import shim

    supported(shim)
    with serving(home, time=time) as served:
        made = Bench(served, home)
        try:
            yield made
        finally:
            made.close()


def channels_of(lines: list[tuple[LinePlace, LineStatus]]) -> int:
    """Of all these lines together."""
    return sum(status.channels for _, status in lines)


def held_of(lines: list[tuple[LinePlace, LineStatus]]) -> set[str]:
    """The ones whose control somebody has."""
    return {place.address for place, status in lines if status.control_holder}


def finished(process: Process) -> str:
    """Its output; it has to end by itself, and well."""
    output, errors = process.communicate(timeout=LONG_S)
    assert process.returncode == 0, (output, errors)
    return output


def need(program: str) -> None:
    """Skip where it is not installed."""
    if not Path(program).exists():
        find_program(program)


def frames(log: str) -> list[str]:
    """The frames alone, of candump's default lines or of log lines."""
    found = []
    for line in log.splitlines():
        parts = line.split()
        if line.startswith("("):
            found.append(parts[2])
        elif line.startswith("  "):
            found.append(" ".join(parts[1:]))
    return found
