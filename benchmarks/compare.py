"""Whether a commit is slower than another one, row by row, in the same run.

    python benchmarks/compare.py OLD [NEW]        commits; without NEW this folder as it is, uncommitted changes too
    python benchmarks/compare.py OLD --short      .ci/run's form: only what a changed file could touch
    python benchmarks/compare.py --rows           what is measured

Each is built in a folder of its own: the core alone, and an extension is copied from the other one, or from the folder
of packages that `--built` names, where it is made of the same sources. Each row has two processes that stay on one
core, and take turns: old, new, new, old, a tenth of a second each, as many times as `--rounds` says. What else the
machine does comes and goes more slowly than that, so it meets both alike. A ratio above 1 says that NEW is quicker; it
is the median of the rounds, and beside it stand the quartiles. A row whose ratio by processor time is below 0.9 is
measured again by other processes; the status is 1 if that is so three times. Rows that OLD cannot run are named.

`--short` has no wall clock, and ends a row after three rounds if none of them is below 0.95. If OLD is not in a clone
without its whole history, it says so and nothing is compared.
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

from comparing.builds import Compiled, build, recipes
from comparing.rows import ROWS

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
LEAST = 0.9
ROUNDS = {False: 15, True: 7}  # with --short
ENOUGH, CLEAR = 3, 0.95  # rounds that are enough in the short form if none of them is below this
TRIES = 3  # a row that is below LEAST each time is slower
SLICE_S = 0.1
FEWEST = 10_000  # frames that a slice begins with, before it is known how many make a tenth of a second


class Compared(NamedTuple):
    """NEW's rates over OLD's, one for each round: by processor time and, but for the short form, the wall clock."""

    processor: list[float]
    wall: list[float]


def git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def cut_off(commit: str) -> bool:
    """Whether the commit may be missing because this clone is shallow; SystemExit for one that git does not know."""
    found = subprocess.run(["git", "cat-file", "-e", f"{commit}^{{commit}}"], cwd=ROOT, capture_output=True)
    if found.returncode and git("rev-parse", "--is-shallow-repository").strip() == "false":
        raise SystemExit(f"{commit}: git knows no such commit")
    return found.returncode != 0


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
        raise SystemExit(f"{commit}: git cannot take it out")
    return folder


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
    made = [set(recipes(folder / "src", folder / "setup.py").items()) for folder in (old, new)]
    rooms |= {name.split(".")[1] for name, _ in made[0] ^ made[1]}  # setup.py may say something else of them
    return [name for name, row in ROWS.items() if rooms & set(row.touched)]


class Runner:
    """A process that measures one row in one folder, a slice at a time."""

    def __init__(self, folder: Path, name: str, *, short: bool = False) -> None:
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder / "src"), str(HERE)])}
        self.name = f"{folder.name}, {name!r}"
        self._process = subprocess.Popen(
            [
                sys.executable,
                "-P",
                str(HERE / "comparing" / "rows.py"),
                name,
                *(["--processor"] if short else []),
            ],
            env=environment,
            cwd=folder,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        if hasattr(os, "sched_setaffinity"):  # cores have different neighbours
            os.sched_setaffinity(self._process.pid, {max(os.sched_getaffinity(0))})

    def rates(self, count: int) -> list[float]:
        """By processor time and, except in the short form, by the wall clock; raises CannotRun."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(f"{count}\n")
            self._process.stdin.flush()
            found: list[float] = json.loads(self._process.stdout.readline())
        except (BrokenPipeError, json.JSONDecodeError):
            raise CannotRun(f"{self.name}: {self._process.communicate()[1].strip()[-300:]}") from None
        return found

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
        clocks = len(runner.rates(count))
        spent = (time.perf_counter() - began) / clocks
        if spent >= SLICE_S / 3:
            return max(FEWEST, round(count * SLICE_S / spent))
        count *= 4


def compared(old: Path, new: Path, name: str, rounds: int, *, short: bool = False) -> Compared:
    """Old, new, new, old: what becomes slower meanwhile (a warm machine, a neighbour) does so for both."""
    found = Compared([], [])
    before, after = Runner(old, name, short=short), Runner(new, name, short=short)
    try:
        count = slice_size(before)
        after.rates(count)
        for _ in range(rounds):
            turns = zip(*(runner.rates(count) for runner in (before, after, after, before)), strict=True)
            for ratios, (first, second, third, fourth) in zip(found, turns, strict=False):
                ratios.append((second + third) / (first + fourth))
            if short and len(found.processor) >= ENOUGH and min(found.processor) >= CLEAR:
                break
    finally:
        before.close()
        after.close()
    return found


def told(ratios: list[float]) -> str:
    if len(ratios) < 2:
        return " ".join(f"{ratio:.2f}" for ratio in ratios)
    low, middle, high = statistics.quantiles(ratios)
    return f"{middle:5.2f} ({low:.2f} to {high:.2f})"


def row_by_row(old: Path, new: Path, names: list[str], rounds: int, *, short: bool = False) -> list[str]:
    """Prints each row's ratios; returns those that are slower."""
    print(f"{'new over old; 1 is as quick':36}{'processor time':>24}{'wall clock':>24}")
    slower = []
    for name in names:
        try:
            for _ in range(TRIES):
                ratios = compared(old, new, name, rounds, short=short)
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
    parser.add_argument(
        "--built", type=Path, metavar="FOLDER", help="has the package canwire as NEW compiles it"
    )
    given = parser.parse_args()
    if given.rows:
        print("\n".join(ROWS))
        return 0
    if given.old is None:
        parser.error("OLD is missing: a commit to compare with")
    if cut_off(given.old):
        message = f"{given.old} is not in this clone, which is shallow: nothing is compared"
        if not given.short:
            raise SystemExit(message)
        print(message)
        return 0
    with tempfile.TemporaryDirectory() as scratch:
        old = laid_out(given.old, Path(scratch, "old"))
        new = laid_out(given.new, Path(scratch, "new"))
        names = [name for name in (touched(old, new) if given.short else ROWS) if given.only in name]
        if not names:
            print(f"no row could be touched by what is different from {given.old}: nothing is compared")
            return 0
        build(new, [Compiled(given.built, new / "setup.py")] if given.built else [])
        build(old, [Compiled(new / "src", new / "setup.py")])
        slower = row_by_row(old, new, names, given.rounds or ROUNDS[given.short], short=given.short)
    if slower:
        print(f"slower than {LEAST} of what it was: {', '.join(slower)}", file=sys.stderr)
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
