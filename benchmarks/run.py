"""Speed and memory, beside python-can in the same run; prints one table.

    python benchmarks/run.py [--short]

Medians of several runs. Needs canwire[bench,arrays]. The uncompiled figures come from a copy of the installed
package without its extensions, run by the same interpreter. With --short everything is smaller, and the run fails
if the compiled core is less than 20 times as fast as the uncompiled one.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
LEAST_RATIO = 20.0


def child(code: str, package_parent: Path | None = None) -> str:
    """Run a line of Python in a process of its own, with the package from another place if given."""
    paths = [str(HERE), str(package_parent or ""), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path)}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True, cwd=HERE
    )
    return done.stdout.strip()


def uncompiled_copy(target: Path) -> Path:
    """The installed package without its extensions."""
    import canwire

    source = Path(canwire.__file__).parent
    shutil.copytree(source, target / "canwire", ignore=shutil.ignore_patterns("*.so", "*.pyd", "__pycache__"))
    return target


def import_milliseconds(module: str) -> float:
    began = time.perf_counter()
    child(f"import {module}")
    spent = time.perf_counter() - began
    began = time.perf_counter()
    child("pass")
    return 1000 * (spent - (time.perf_counter() - began))


def help_milliseconds(module: str, option: str) -> float:
    """The whole process, the interpreter's own start included."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-m", module, option], capture_output=True, check=True)
    return 1000 * (time.perf_counter() - began)


def core_rows(scale: int, runs: int, pure: Path) -> list[tuple[str, str, str, str]]:
    from workloads import bit_by_bit, hour_at_half_load, median, saturated, with_errors

    classic = median(lambda: saturated(1_000_000 // scale)[0], runs)
    realtime = median(lambda: saturated(1_000_000 // scale)[1], runs)
    fd = median(lambda: saturated(500_000 // scale, fd=True)[0], runs)
    drained = median(lambda: saturated(1_000_000 // scale)[2], runs)
    slow = median(lambda: float(child(_PURE.format(count=20_000 // scale), pure)), runs)
    if classic < LEAST_RATIO * slow:
        print(
            f"the compiled core is only {classic / slow:.1f} times as fast as the uncompiled one",
            file=sys.stderr,
        )
        raise SystemExit(1)
    hour = median(lambda: hour_at_half_load(3600 / scale), 1)
    bits = median(lambda: bit_by_bit(20_000 // scale), runs)
    many = median(lambda: bit_by_bit(5_000 // scale, 64), runs)
    noisy = median(lambda: with_errors(50_000 // scale, 0.1), runs)
    return [
        ("core, 4 nodes, 0-8 bytes, 11/29 bit, filters", f"{classic:,.0f} frames/s", "", "12,000,000"),
        ("  the same against real time, 1 Mbit/s", f"{realtime:,.0f} x", "", "700 x"),
        ("  the same, CAN FD, 8-64 bytes", f"{fd:,.0f} frames/s", "", "6,000,000"),
        ("  the same, uncompiled", f"{slow:,.0f} frames/s", "", "150,000"),
        ("  drained as numpy batches", f"{drained:,.0f} records/s", "", "10,000,000"),
        ("bit by bit (errors, traces), 4 nodes", f"{bits:,.0f} frames/s", "", "200,000"),
        ("  the same, 64 nodes", f"{many:,.0f} frames/s", "", ""),
        ("  errors in 10 % of the frames, 4 nodes", f"{noisy:,.0f} frames/s", "", ""),
        (f"{3600 // scale} s of bus at 50 % load, paced by a timer", f"{hour:,.0f} x real time", "", "1 x"),
    ]


def lab_rows(scale: int, runs: int) -> list[tuple[str, str, str, str]]:
    from workloads import draining, lab_arrays, lab_objects, median, python_can, python_can_draining

    count = 100_000 // scale
    rows = []
    for receivers, least in ((1, 4), (8, 10)):
        ours = median(lambda n=receivers: lab_objects(count, n), runs)
        theirs = median(lambda n=receivers: python_can(count // (2 * n), n), runs)
        rows.append(_beside(f"Frame objects, 1 sender, {receivers} receiver(s)", ours, theirs, f"{least} x"))
    theirs = median(lambda: python_can(count // 2, 1), runs)
    ours = median(lambda: lab_arrays(10 * count), runs)
    rows.append(_beside("numpy records sent, arbitrated and received, 1 to 1", ours, theirs, "50 x"))
    theirs = median(lambda: python_can_draining(count // 2), runs)
    rows.append(
        _beside(
            "taking only: receive_array", median(lambda: draining(10 * count, "arrays"), runs), theirs, "50 x"
        )
    )
    rows.append(
        _beside("taking only: receive_many", median(lambda: draining(count, "objects"), runs), theirs, "")
    )
    return rows


def process_rows(seconds: float, runs: int) -> list[tuple[str, str, str, str]]:
    from workloads import lateness, median, sleep_lateness

    ours, theirs = (median(lambda m=name: import_milliseconds(m), runs) for name in ("canwire", "can"))
    help_ours = median(lambda: help_milliseconds("canwire", "--help"), runs)
    help_theirs = median(lambda: help_milliseconds("can.logger", "-h"), runs)
    memory = median(lambda: float(child("import workloads; print(workloads.resident_megabytes())")), runs)
    p50, p99 = lateness(seconds)
    bare50, bare99 = sleep_lateness(seconds)
    return [
        ("import", f"{ours:.0f} ms", f"{theirs:.0f} ms", "below 120 ms"),
        (
            "canwire --help, beside can.logger -h",
            f"{help_ours:.0f} ms",
            f"{help_theirs:.0f} ms",
            "below 100 ms",
        ),
        ("resident with a Lab of 10 nodes", f"{memory:.0f} MB", "", "below 60 MB"),
        (
            "real time, frame ends late (p50 / p99)",
            f"{p50:.0f} / {p99:.0f} us",
            f"bare sleep {bare50:.0f} / {bare99:.0f} us",
            "p99 < 200 us",
        ),
    ]


def _beside(what: str, ours: float, theirs: float, goal: str) -> tuple[str, str, str, str]:
    return what, f"{ours:,.0f} frames/s = {ours / theirs:.1f} x", f"{theirs:,.0f} frames/s", goal


_PURE = "import workloads; print(workloads.saturated({count})[0])"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="smaller and quicker")
    parser.add_argument("--json", action="store_true", help="one object instead of the table")
    arguments = parser.parse_args()
    scale, runs, seconds = (10, 3, 1.0) if arguments.short else (1, 5, 10.0)
    sys.path.insert(0, str(HERE))
    import candrv
    import lin
    import mcp2515
    import python_can
    import shared
    import sja1000
    import slcan
    import slcan_driver

    import canwire

    with tempfile.TemporaryDirectory() as folder:
        pure = uncompiled_copy(Path(folder))
        rows = [*core_rows(scale, runs, pure), *lab_rows(scale, runs), *process_rows(seconds, runs)]
        rows += [*shared.rows(scale, seconds), *lin.rows(scale, seconds)]
        rows += [*candrv.rows(scale, seconds), *python_can.rows(scale, seconds)]
        rows += [*sja1000.rows(scale, runs), *mcp2515.rows(seconds)]
        rows += [*slcan.rows(scale), *slcan_driver.rows(min(seconds, 3.0))]
    if arguments.json:
        print(
            json.dumps(
                [dict(zip(("what", "canwire", "python-can", "goal"), row, strict=True)) for row in rows]
            )
        )
        return 0
    print(f"canwire {canwire.__version__}, {canwire.core_mode()} core; medians of {runs} runs\n")
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    for row in (("", "canwire", "python-can virtual", "goal"), *rows):
        print(
            "  ".join(
                cell.ljust(width)
                for cell, width in zip(row, [*widths[:2], max(18, widths[2]), 0], strict=True)
            )
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
