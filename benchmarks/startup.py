"""How long `canwire send` and `canwire dump` take to their first frame, beside other programs' starts.

python benchmarks/startup.py [ROUNDS]

Each round starts each program once, in turn, so that a busy machine is as busy for all of them. Wall time is to the end
of the process (`send`: its frame was acknowledged; `dump -n 1`: it has shown a frame that somebody sends every
millisecond), processor time is the process's own, user and system, and says more where others work beside it. All of
them find their sources compiled, as after an installation, whatever PYTHONDONTWRITEBYTECODE says.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROUNDS = 15
PYTHON = sys.executable


def programs(address: str) -> dict[str, list[str]]:
    canwire = [PYTHON, "-m", "canwire"]
    return {
        "python -c pass": [PYTHON, "-c", "pass"],
        "can.logger -h": [PYTHON, "-m", "can.logger", "-h"],
        "canwire --version": [*canwire, "--version"],
        "canwire send": [*canwire, "send", "HW000001:0", "123#11", "--hub", address],
        "canwire dump -n 1": [*canwire, "dump", "HW000002:0", "-n", "1", "--hub", address],
    }


@contextmanager
def busy_hub(folder: Path) -> Iterator[str]:
    """A hub, and a program that sends every millisecond."""
    address = str(folder / "hub.sock")
    serve = [PYTHON, "-m", "canwire", "serve", "--socket", address]
    with subprocess.Popen(serve, stdout=subprocess.PIPE, text=True) as hub:
        assert hub.stdout is not None
        hub.stdout.readline()
        listen = [PYTHON, "-m", "canwire", "up", "HW000002:1", "--hub", address]
        subprocess.run(listen, check=True, stdout=subprocess.DEVNULL)
        generate = [
            PYTHON,
            "-m",
            "canwire",
            "gen",
            "HW000002:1",
            "--rate",
            "1000",
            "--timeout",
            "600",
            "--hub",
            address,
        ]
        with subprocess.Popen(generate, stderr=subprocess.DEVNULL) as generator:
            time.sleep(1)
            yield address
            generator.terminate()
        hub.terminate()


def taken(command: list[str], environment: dict[str, str]) -> tuple[float, float]:
    """Wall and processor time in ms."""
    began_s = time.perf_counter()
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - began_s
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, command
    return wall_s * 1000, (used.ru_utime + used.ru_stime) * 1000


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else ROUNDS
    with tempfile.TemporaryDirectory() as folder, busy_hub(Path(folder)) as address:
        commands = programs(address)
        environment = os.environ | {
            "PYTHONDONTWRITEBYTECODE": "",
            "PYTHONPYCACHEPREFIX": f"{folder}/compiled",
        }
        for command in commands.values():
            taken(command, environment)
        found: dict[str, list[tuple[float, float]]] = {name: [] for name in commands}
        for _ in range(rounds):
            for name, command in commands.items():
                found[name].append(taken(command, environment))
    print(f"{'':20} {'wall ms':>9} {'least':>7} {'processor ms':>14}   (medians of {rounds})")
    for name, times in found.items():
        wall = [one[0] for one in times]
        used = statistics.median(one[1] for one in times)
        print(f"{name:20} {statistics.median(wall):9.1f} {min(wall):7.1f} {used:14.1f}")


if __name__ == "__main__":
    main()
