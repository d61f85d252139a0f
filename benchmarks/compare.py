"""Whether a commit is slower than another one, row by row, in the same run.

    python benchmarks/compare.py OLD [NEW]        commits; without NEW this folder as it is, uncommitted changes too
    python benchmarks/compare.py OLD --short      fewer frames, and only rows that a changed file could touch
    python benchmarks/compare.py --rows           what is measured

Each is built in a folder of its own (compiled files are copied where their sources are the same). Then each row runs in
turn, old, new, new, old, each in a process of its own, as many times as `--rounds` says. A ratio above 1 says that NEW
is quicker; what stands beside it is the least and the largest of the rounds. The status is 1 if a row's ratio by
processor time is below 0.9 in the median of the rounds. Rows that OLD cannot run yet are named.
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
from pathlib import Path
from typing import NamedTuple

from compare_rows import ROWS

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
LEAST = 0.9
COUNT = {False: 1_000_000, True: 100_000}  # frames of a row; with --short


class Compared(NamedTuple):
    """NEW's rates over OLD's, one for each round: by the wall clock and by processor time."""

    wall: list[float]
    processor: list[float]


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


def rates(folder: Path, name: str, count: int) -> list[float] | None:
    """None where it cannot run there."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder / "src"), str(HERE)])}
    command = [sys.executable, "-P", str(HERE / "compare_rows.py"), name, str(count)]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, cwd=folder)
    if ended.returncode:
        print(f"{folder.name} cannot run {name!r}: {ended.stderr.strip()[-300:]}", file=sys.stderr)
        return None
    return [float(rate) for rate in json.loads(ended.stdout)]


def compared(old: Path, new: Path, name: str, count: int, rounds: int) -> Compared | None:
    """Old, new, new, old: what becomes slower meanwhile (a warm machine, a neighbour) does so for both."""
    found = Compared([], [])
    for _ in range(rounds):
        runs = [rates(folder, name, count) for folder in (old, new, new, old)]
        first, second, third, fourth = runs
        if first is None or second is None or third is None or fourth is None:
            return None
        for ratios, at in ((found.wall, 0), (found.processor, 1)):
            ratios.append((second[at] + third[at]) / (first[at] + fourth[at]))
    return found


def told(ratios: list[float]) -> str:
    return f"{statistics.median(ratios):5.2f} ({min(ratios):.2f} to {max(ratios):.2f})"


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("old", metavar="OLD", nargs="?")
    parser.add_argument("new", metavar="NEW", nargs="?")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--rows", action="store_true")
    parser.add_argument("--rounds", type=int, default=3, metavar="N")
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
        print(f"{'new over old; 1 is as quick':36}{'processor time':>24}{'wall clock':>24}")
        slower = []
        for name in names:
            ratios = compared(old, new, name, COUNT[given.short], given.rounds)
            if ratios is None:
                print(f"{name:36}{'one of both cannot run it':>24}", flush=True)
                continue
            print(f"{name:36}{told(ratios.processor):>24}{told(ratios.wall):>24}", flush=True)
            if statistics.median(ratios.processor) < LEAST:
                slower.append(name)
    if slower:
        print(f"slower than {LEAST} of what it was: {', '.join(slower)}", file=sys.stderr)
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
