"""python -m tests.fuzz [TARGET ...] --seconds N: mutations of good inputs, N seconds of processor time for each target.

A row for each target says how many inputs it took and what came out that should not; status 1 if anything did. Each
such input is kept in --output, one for each place: mend it, and move it to tests/fuzz/corpus/, which CI reads again.
`--minutes N` shares the time among all targets instead.
"""

from __future__ import annotations

import argparse
import hashlib
import random
import re
import signal
import sys
import time
import traceback
from pathlib import Path

from tests.attacks.parsers import Parser
from tests.fuzz.mutator import mutated
from tests.fuzz.targets import targets

CORPUS = Path(__file__).parent / "corpus"
PATIENCE_S = 20  # of processor time, for one input


class TooLongError(BaseException):
    """An input that takes far longer than its size."""


def folder_of(name: str) -> str:
    """A target's name as that of a folder."""
    return re.sub(r"\W+", "-", name).strip("-")


def saved(name: str) -> list[bytes]:
    """The inputs in the corpus."""
    return [path.read_bytes() for path in sorted((CORPUS / folder_of(name)).glob("*"))]


def attack(parser: Parser, name: str, seconds: float, seed: int) -> tuple[int, dict[str, bytes]]:
    """How many inputs there were, and by what came out and where, the shortest that brought it."""
    chance, count, found = random.Random(f"{name} {seed}"), 0, dict[str, bytes]()
    seeds = [*parser.seeds, *saved(name)]
    end = time.process_time() + seconds
    while time.process_time() < end:
        data = mutated(chance, seeds)
        count += 1
        place = outcome(parser, data)
        if place and len(found.get(place, data)) >= len(data):
            found[place] = data
    return count, found


def outcome(parser: Parser, data: bytes) -> str:
    """What came out that the parser does not say, and where; "" for nothing."""
    signal.setitimer(signal.ITIMER_PROF, PATIENCE_S)
    try:
        parser.run(data)
    except parser.refuses:
        pass
    except (Exception, TooLongError) as error:
        cause = error.__cause__ or error
        frames = traceback.extract_tb(cause.__traceback__)
        mine = [frame for frame in frames if "canwire" in frame.filename] or frames
        return f"{type(error).__name__} {type(cause).__name__}: {mine[-1].filename}:{mine[-1].lineno}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    return ""


def _too_long(_signal: int, _frame: object) -> None:
    raise TooLongError(f"over {PATIENCE_S} s of processor time")


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help="default: all")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--minutes", type=float, help="for all targets together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=Path("fuzz"))
    arguments = parser.parse_args()
    signal.signal(signal.SIGPROF, _too_long)
    known = targets()
    names = arguments.targets or list(known)
    if unknown := [name for name in names if name not in known]:
        parser.error(f"no target {', '.join(unknown)}; there are {', '.join(known)}")
    seconds = arguments.minutes * 60 / len(names) if arguments.minutes else arguments.seconds
    total, wrong = 0, 0
    for name in names:
        count, found = attack(known[name], name, seconds, arguments.seed)
        total, wrong = total + count, wrong + len(found)
        print(f"{name}: {count:,} inputs, {len(found)} kinds of wrong answers", flush=True)
        for place, data in found.items():
            path = arguments.output / folder_of(name) / hashlib.sha256(data).hexdigest()[:12]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
            print(f"    {place}\n        {path}, {len(data)} bytes", flush=True)
    print(f"{total:,} inputs in all, {wrong} kinds of wrong answers")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
