"""Whether a commit is slower than another one, row by row, in the same run.

    python benchmarks/compare.py OLD [NEW]        commits; without NEW this folder as it is, uncommitted changes too
    python benchmarks/compare.py OLD --short      fewer rounds, and only rows that a changed file could touch
    python benchmarks/compare.py --rows           what is measured

Each is built in a folder of its own (compiled files are copied where their sources are the same). Each row has two
processes that stay on one core, and take turns: old, new, new, old, a tenth of a second each, as many times as
`--rounds` says. What else the machine does comes and goes more slowly than that, so it meets both alike. A ratio
above 1 says that NEW is quicker; it is the median of the rounds, and beside it stand the quartiles. A row whose ratio
by processor time is below 0.9 is measured once more, by other processes; the status is 1 if that is below 0.9 too.
Rows that OLD cannot run yet are named.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from compare_rows import ROWS

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
LEAST = 0.9
ROUNDS = {False: 15, True: 7}  # with --short
SLICE_S = 0.1
FEWEST = 10_000  # frames that a slice begins with, before it is known how many make a tenth of a second


class Compared(NamedTuple):
    """NEW's rates over OLD's, one for each round: by processor time and by the wall clock."""

    processor: list[float]
    wall: list[float]


def git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def laid_out(commit: str | None, folder: Path) -> Path:
    """The files of a commit, or of this folder as it is."""
    folder.mkdir()
    if commit is None:
        for name in git("ls-files", "-co", "--exclude-standard").splitlines():
            if (ROOT / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, folder / name)
        return folder
    with subprocess.Popen(["git", "archive", commit], cwd=ROOT, stdout=subprocess.PIPE) as archive:
        subprocess.run(["tar", "-x", "-C", folder], stdin=archive.stdout, check=True)
    if archive.returncode:
        raise SystemExit(f"{commit}: git knows no such commit")
    return folder


def compiled_sources(folder: Path) -> dict[str, bytes]:
    """All that compiled files are made of: declarations, and whatever stands beside one or is named by setup.py."""
    source = folder / "src"
    found = [folder / "setup.py", *source.rglob("*.pxd"), *source.rglob("*.c"), *source.rglob("*.h")]
    found += [path.with_suffix(".py") for path in source.rglob("*.pxd")]
    setup = (folder / "setup.py").read_text("utf-8")
    found += [
        path
        for path in source.rglob("*.py")
        if f'"{".".join(path.relative_to(source).with_suffix("").parts)}"' in setup
    ]
    return {str(path.relative_to(folder)): path.read_bytes() for path in found if path.exists()}


def build(folder: Path, like: Path | None) -> None:
    """Compiled in place; taken from `like` if its compiled files come of the same sources."""
    if like is not None and compiled_sources(folder) == compiled_sources(like):
        for path in (like / "src").rglob("*.so*"):
            shutil.copy2(path, folder / path.relative_to(like))
        return
    print(f"compiling {folder.name}", file=sys.stderr, flush=True)
    environment = {**os.environ, "CANWIRE_BUILD": "require"}
    command = [sys.executable, "setup.py", "-q", "build_ext", "--inplace"]
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if ended.returncode:
        raise SystemExit(f"{folder.name} cannot be compiled:\n{ended.stderr[-3000:]}")


def touched(old: Path, new: Path) -> list[str]:
    """Names of rows that a file which differs could make quicker or slower."""

    def files(folder: Path) -> dict[str, bytes]:
        source = folder / "src" / "canwire"
        return {
            str(path.relative_to(source)): path.read_bytes()
            for path in source.rglob("*.p*")
            if path.is_file()
        }

    before, after = files(old), files(new)
    different = {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)}
    rooms = {Path(name).parts[0].partition(".")[0] for name in different}
    return [name for name, row in ROWS.items() if rooms & set(row.touched)]


class Runner:
    """A process that measures one row in one folder, a slice at a time."""

    def __init__(self, folder: Path, name: str) -> None:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder / "src"), str(HERE)])}
        self.name = f"{folder.name}, {name!r}"
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(HERE / "compare_rows.py"), name],
            env=environment,
            cwd=folder,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        if hasattr(os, "sched_setaffinity"):  # cores have different neighbours
            os.sched_setaffinity(self._process.pid, {max(os.sched_getaffinity(0))})

    def rates(self, count: int) -> tuple[float, float]:
        """By processor time and by the wall clock; raises CannotRun."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(f"{count}\n")
            self._process.stdin.flush()
            processor, wall = json.loads(self._process.stdout.readline())
        except (BrokenPipeError, json.JSONDecodeError):
            raise CannotRun(f"{self.name}: {self._process.communicate()[1].strip()[-300:]}") from None
        return float(processor), float(wall)

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()


class CannotRun(Exception):
    """One of the two commits does not have what this row measures."""


def slice_size(runner: Runner) -> int:
    """How many frames take a tenth of a second."""
    count = FEWEST
    while True:
        began = time.perf_counter()
        runner.rates(count)
        spent = (time.perf_counter() - began) / 2  # one of them by each clock
        if spent >= SLICE_S / 3:
            return max(FEWEST, round(count * SLICE_S / spent))
        count *= 4


def compared(old: Path, new: Path, name: str, rounds: int) -> Compared:
    """Old, new, new, old: what becomes slower meanwhile (a warm machine, a neighbour) does so for both."""
    found = Compared([], [])
    before, after = Runner(old, name), Runner(new, name)
    try:
        count = slice_size(before)
        after.rates(count)
        for _ in range(rounds):
            first, second, third, fourth = (runner.rates(count) for runner in (before, after, after, before))
            found.processor.append((second[0] + third[0]) / (first[0] + fourth[0]))
            found.wall.append((second[1] + third[1]) / (first[1] + fourth[1]))
    finally:
        before.close()
        after.close()
    return found


def told(ratios: list[float]) -> str:
    low, middle, high = statistics.quantiles(ratios)
    return f"{middle:5.2f} ({low:.2f} to {high:.2f})"


def row_by_row(old: Path, new: Path, names: list[str], rounds: int) -> list[str]:
    """Prints each row's ratios; returns those that are slower."""
    print(f"{'new over old; 1 is as quick':36}{'processor time':>24}{'wall clock':>24}")
    slower = []
    for name in names:
        try:
            for _ in range(2):
                ratios = compared(old, new, name, rounds)
                print(f"{name:36}{told(ratios.processor):>24}{told(ratios.wall):>24}", flush=True)
                if statistics.median(ratios.processor) >= LEAST:
                    break
            else:
                slower.append(name)
        except CannotRun as reason:
            print(f"{name:36}{'one of both cannot run it':>24}\n{reason}", flush=True)
    return slower


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("old", metavar="OLD", nargs="?")
    parser.add_argument("new", metavar="NEW", nargs="?")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--rows", action="store_true")
    parser.add_argument("--rounds", type=int, default=0, metavar="N")
    parser.add_argument("--only", default="", metavar="TEXT", help="rows whose names have it")
    given = parser.parse_args()
    if given.rows:
        print("\n".join(ROWS))
        return 0
    if given.old is None:
        parser.error("OLD is missing: a commit to compare with")
    with tempfile.TemporaryDirectory() as scratch:
        old = laid_out(given.old, Path(scratch, "old"))
        new = laid_out(given.new, Path(scratch, "new"))
        names = [name for name in (touched(old, new) if given.short else ROWS) if given.only in name]
        if not names:
            print("no row could be touched by what is different")
            return 0
        build(old, None)
        build(new, old)
        slower = row_by_row(old, new, names, given.rounds or ROUNDS[given.short])
    if slower:
        print(f"slower than {LEAST} of what it was: {', '.join(slower)}", file=sys.stderr)
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
