"""SocketCAN programs in one time, again and again on a loaded machine: `python -m tests.socketcan.repeated`.

can-utils with an ECU in C; an ECU for every way to wait, beside a log; threads that wait for each other; locks and
children. Each cast is played so many times on a hub of its own beside busy loops; a row says how many different
outcomes there were: what every program printed, candump's log among it. The status is 1 if there was more than one.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from tests.hubs import LONG_S
from tests.socketcan.test_timed import of_can_utils, of_every_way, played
from tests.stress import busy

HERE = Path(__file__).parent


def casts(home: Path) -> dict[str, dict[str, Sequence[str]]]:
    """By name; programs in C are compiled into `home`."""
    made = {name: str(home / name) for name in ("ecu", "workers", "holders")}
    for name, path in made.items():
        subprocess.run(["gcc", "-std=gnu11", "-O2", str(HERE / f"{name}.c"), "-o", path], check=True)
    log = ["candump", "-L", "-T", "500", "can0"]
    return {
        "can-utils and an ECU": of_can_utils(home, made["ecu"]),
        "every way to wait": {"log": log, **of_every_way(made["ecu"])},
        "threads": {"log": log, "workers": [made["workers"]]},
        "locks and children": {"log": log, "holders": [made["holders"]]},
    }


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--times", type=int, default=30, help="how often each cast is played (30)")
    parser.add_argument(
        "--loops", type=int, default=os.cpu_count(), help="busy loops (as many as there are cores)"
    )
    parser.add_argument("casts", nargs="*", metavar="CAST", help="words of the casts' names (all of them)")
    asked = parser.parse_args()
    worst = 1
    with tempfile.TemporaryDirectory() as folder, busy(asked.loops):
        for name, cast in casts(Path(folder)).items():
            if asked.casts and not any(word in name for word in asked.casts):
                continue
            began_s, outcomes = time.monotonic(), []
            for number in range(asked.times):
                outcome = played(
                    Path(folder) / f"{name} {number}", cast, "11 22 33 44 55 66 77 88 99 AA\n", 10 * LONG_S
                )
                if outcome not in outcomes:
                    outcomes.append(outcome)
            worst = max(worst, len(outcomes))
            print(
                f"{name}: {len(cast)} programs, {asked.times} times, {len(outcomes)} different "
                f"(load {os.getloadavg()[0]:.0f}, {time.monotonic() - began_s:.0f} s)",
                flush=True,
            )
            for program in cast:
                if any(one[program] != outcomes[0][program] for one in outcomes):
                    print(
                        f"  {program}: " + " | ".join(repr(one[program]) for one in outcomes[:2]), flush=True
                    )
    return int(worst > 1)


if __name__ == "__main__":
    sys.exit(main())
