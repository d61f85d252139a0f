"""How long a hub with thousands of boards takes to start, and `canwire devices` to list them (issue 35: 4 s and 3 s).

    python benchmarks/many_boards.py [--boards 5000] [--runs 3]

The clock's seconds, and processor time of the hub and of the command; of each the least of several runs. Ten boards
share a bus. The load of the machine is printed because the clock's figures depend on it. Linux only (/proc).
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

_ON_A_BUS = 10


class Took(NamedTuple):
    """Seconds."""

    start: float
    start_busy: float
    devices: float
    devices_busy: float
    hub_busy: float  # during `canwire devices`


def config_of(boards: int) -> str:
    buses = [f'[[bus]]\nname = "can{number}"\n' for number in range(-(-boards // _ON_A_BUS))]
    lines = [
        f'[[board]]\nkind = "usb-to-can-fd"\nbuses = ["can{k // _ON_A_BUS}", "", ""]\n' for k in range(boards)
    ]
    return "".join(buses + lines)


def busy_s(process: int) -> float:
    """Processor time of a process so far."""
    words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measured(home: Path, boards: int) -> Took:
    address, config = str(home / "hub.sock"), home / "hub.toml"
    config.write_text(config_of(boards))
    canwire = [sys.executable, "-m", "canwire"]
    begun = time.monotonic()
    words = [*canwire, "serve", "--socket", address, "--config", str(config)]
    hub = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        assert hub.stdout is not None
        if "canwire hub on" not in hub.stdout.readline():
            raise SystemExit("the hub did not start")
        start, start_busy = time.monotonic() - begun, busy_s(hub.pid)
        begun, children = time.monotonic(), children_s()
        listed = subprocess.run(
            [*canwire, "devices", "--hub", address], capture_output=True, text=True, check=True
        )
        devices = time.monotonic() - begun
        found = sum(line.startswith("HW") for line in listed.stdout.splitlines())
        if found != boards:
            raise SystemExit(f"`canwire devices` listed {found} of {boards} boards")
        return Took(start, start_busy, devices, children_s() - children, busy_s(hub.pid) - start_busy)
    finally:
        hub.terminate()
        hub.communicate()


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--boards", type=int, default=5000)
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as home:
        every = [measured(Path(home), given.boards) for _ in range(given.runs)]
    least = Took(*(min(one) for one in zip(*every, strict=True)))
    load = f"load average {os.getloadavg()[0]:.0f} on {os.cpu_count()} processors"
    print(f"{given.boards} boards, least of {given.runs}; {load}")
    print(f"start    {least.start:6.2f} s   busy: hub {least.start_busy:.2f} s")
    print(
        f"devices  {least.devices:6.2f} s   busy: command {least.devices_busy:.2f} s, hub {least.hub_busy:.2f} s"
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
