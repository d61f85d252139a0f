"""SocketCAN programs through a hub: `cangen` into `candump`, unmodified, each under a `canwire run` of its own.

    python benchmarks/socketcan.py [FRAMES]     in fast time; then in real time at 1 Mbit/s

Prints frames a second from cangen's first to candump's last, what was lost, and how much processor time each process
took for a frame: on a machine that others use as well only that can be compared.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

FRAMES = 200_000
REAL_SECONDS = 5


class Usage:
    """Processor time of processes with these words in their command lines, as long as they live."""

    def __init__(self, address: str) -> None:
        self._address = address
        self._first: dict[int, float] = {}
        self._last: dict[int, tuple[str, float]] = {}
        self._others: set[int] = set()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch)

    def __enter__(self) -> Usage:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def begin(self) -> None:
        """Forget what was spent so far."""
        self._first = {pid: spent for pid, (_, spent) in self._last.items()}

    def seconds(self) -> dict[str, float]:
        """By what a process is."""
        found: dict[str, float] = {}
        for pid, (name, spent) in self._last.items():
            found[name] = found.get(name, 0.0) + spent - self._first[pid]
        return found

    def _watch(self) -> None:
        while not self._over.wait(0.05):
            for name in os.listdir("/proc"):
                if name.isdigit() and int(name) not in self._others:
                    self._look(int(name))

    def _look(self, pid: int) -> None:
        try:
            command = Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode()
            environment = Path(f"/proc/{pid}/environ").read_bytes().decode(errors="replace")
            if self._address not in command + environment:
                self._others.add(pid)
                return
            tasks = [task.read_text() for task in Path(f"/proc/{pid}/task").glob("*/schedstat")]
        except (OSError, ValueError):
            return
        spent = (
            sum(int(task.split()[0]) for task in tasks) / 1e9
        )  # the scheduler's own count, not samples of it
        self._first.setdefault(pid, spent)
        served = re.search(r"canwire run.* (can[a-z]+) ", command)
        name = f"server of {served[1]}" if served else command.partition(" ")[0]
        name = "hub" if "canwire serve" in command else name
        self._last[pid] = name, spent


@contextmanager
def hub(time_kind: str) -> Iterator[str]:
    with tempfile.TemporaryDirectory() as home:
        address = f"{home}/hub.sock"
        words = [sys.executable, "-m", "canwire", "serve", "--time", time_kind, "--socket", address]
        process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield address
        finally:
            process.terminate()
            process.wait()


def run(address: str, *words: str, **options: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "canwire", "run", "--bit-rate", "1000000", *words]
    return subprocess.Popen(command, env={**os.environ, "CANWIRE_HUB": address}, text=True, **options)  # type: ignore[call-overload,no-any-return]


def measure(time_kind: str, frames: int) -> None:
    with hub(time_kind) as address, tempfile.TemporaryFile("w+") as output, Usage(address) as usage:
        dump = run(address, "candump", "-d", "-n", str(frames), "-T", "10000", "can0", stdout=output)
        wait_for_listener(address)
        usage.begin()
        begun_s = time.perf_counter()
        run(address, "cangen", "can0", "-g", "0", "-n", str(frames), "-I", "123", "-L", "8", "-D", "i").wait()
        dump.wait()
        took_s = time.perf_counter() - begun_s
        output.seek(0)
        lines = sum(1 for line in output if line.startswith("  can0"))
    print(f"{time_kind}: {lines / took_s:,.0f} frames/s, {frames - lines} of {frames} lost, {took_s:.2f} s")
    for name, spent_s in sorted(usage.seconds().items()):
        print(f"    {name:20} {spent_s / frames * 1e6:6.2f} us a frame, {spent_s / took_s:5.0%} of a core")


def wait_for_listener(address: str) -> None:
    import canwire

    with canwire.connect(address, name="benchmark") as shared:
        while not any(place.status(shared).channels for place in canwire.every_line(shared, "CAN")):
            time.sleep(0.02)


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else FRAMES
    measure("fast", count)
    measure("real", 7500 * REAL_SECONDS if len(sys.argv) < 2 else min(count, 7500 * REAL_SECONDS))
