"""Every log and every database of a folder that other people made, read by us and by the usual library.

python -m tests.others.folder FOLDER [--outcome differs] [--seconds 60]

prints a line for each file: what came of it (`told.OUTCOMES`), its name, and the numbers, the difference or the reason.
The counts stand at the end. The status is 1 where something crashed, hung or differed without a word.
"""

from __future__ import annotations

import argparse
import logging
import multiprocessing
import signal
import sys
import traceback
import warnings
from collections import Counter
from hashlib import sha256
from pathlib import Path
from typing import Any

from tests.others import database_comparison, log_comparison
from tests.others.told import OUTCOMES, Told

KINDS = {
    "log": (log_comparison.SUFFIXES, log_comparison.compare_log),
    "database": (database_comparison.SUFFIXES, database_comparison.compare_database),
}
WRONG = ("differs", "crash", "too long")


def main(arguments: list[str]) -> int:
    """Print the table and the counts."""
    options = _parsed(arguments)
    files = _files(Path(options.folder))
    counts: Counter[tuple[str, str]] = Counter()
    with multiprocessing.Pool(1, _prepare, maxtasksperchild=50) as pool:
        jobs = [(path, kind, options.seconds) for path, kind in files]
        for (path, kind), told in zip(files, pool.imap(_told, jobs), strict=True):
            counts[kind, told.outcome] += 1
            if options.outcome in (None, told.outcome):
                print(
                    f"{kind:9}{told.outcome:9}{path.relative_to(options.folder)}: {told.detail}", flush=True
                )
    for kind in KINDS:
        print(kind, *(f"{outcome} {counts[kind, outcome]}" for outcome in OUTCOMES), sep=", ")
    return int(any(counts[kind, outcome] for kind in KINDS for outcome in WRONG))


def _parsed(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.others.folder", description=__doc__)
    parser.add_argument("folder")
    parser.add_argument("--outcome", choices=OUTCOMES, help="print only these lines")
    parser.add_argument("--seconds", type=int, default=60, help="time limit for each file (60)")
    return parser.parse_args(arguments)


def _files(folder: Path) -> list[tuple[Path, str]]:
    """Each file once, however often it lies there, and its kind."""
    found: dict[bytes, tuple[Path, str]] = {}
    for path in sorted(folder.rglob("*")):
        kind = next((kind for kind, (suffixes, _) in KINDS.items() if path.suffix.lower() in suffixes), None)
        if kind is not None and path.is_file():
            content = path.suffix.lower().encode() + sha256(path.read_bytes()).digest()
            found.setdefault(content, (path, kind))
    return list(found.values())


def _prepare() -> None:
    warnings.simplefilter("ignore")
    logging.disable()


def _told(job: tuple[Path, str, int]) -> Told:
    path, kind, seconds = job
    signal.signal(signal.SIGALRM, _end)
    signal.alarm(seconds)
    try:
        return KINDS[kind][1](path)
    except TimeoutError:
        return Told("too long", f"more than {seconds} s")
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return Told("crash", f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})")
    finally:
        signal.alarm(0)


def _end(*_: Any) -> None:
    raise TimeoutError


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
