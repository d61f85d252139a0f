"""Draws mutants, judges each of them, writes a line of JSON for each and prints the shares.

python -m tests.mutants --seed 26 --count 150 --out before.jsonl
python -m tests.mutants --folders bus chips --count 40 --out two.jsonl             # some folders alone
python -m tests.mutants --only before.jsonl --out after.jsonl                     # the same ones once more
python -m tests.mutants --only before.jsonl --status survived --out rest.jsonl
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

from tests.mutants.drawing import PACKAGE, Mutant, draw, found_again
from tests.mutants.judging import Judge

FIRST = ("bus", "chips", "boards", "hub", "ring.py", "timeline.py")  # whose survivors are worked on
ROOT = Path(__file__).resolve().parents[2]


def main() -> int:
    arguments = options().parse_args()
    known = (
        {mutant_of(row) for row in read(arguments.out)} if arguments.out.exists() else set()
    )  # it was interrupted
    if arguments.only:
        rows = [row for row in read(arguments.only) if arguments.status in (None, row["status"])]
        wanted = [found_again(ROOT, mutant_of(row)) for row in rows]
        print(f"{wanted.count(None)} of {len(wanted)} stand in source that is no more", file=sys.stderr)
        mutants = [mutant for mutant in wanted if mutant]
    else:
        mutants = draw(ROOT, arguments.count, arguments.seed, arguments.folders)
    mutants.sort(key=lambda mutant: folder_of(mutant.file) not in FIRST)
    with tempfile.TemporaryDirectory(prefix="cwm") as home, arguments.out.open("a") as out:
        judge = Judge(ROOT, Path(home))
        for mutant in mutants:
            if mutant not in known:
                print(judged(judge, mutant), file=out, flush=True)
        rows = read(arguments.out)
        killed = [(mutant_of(row), row["by"]) for row in rows if row["status"] == "killed"]
        wrong = set(judge.failing_anyway(killed))
        lines = [judged(judge, one) if (one := mutant_of(row)) in wrong else json.dumps(row) for row in rows]
    arguments.out.write_text("\n".join(lines) + "\n", "utf-8")
    print(table(read(arguments.out)))
    return 0


def judged(judge: Judge, mutant: Mutant) -> str:
    """A line of the result."""
    return json.dumps({**mutant._asdict(), **judge.verdict(mutant)._asdict()})


def options() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tests.mutants", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=26)
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument(
        "--folders", nargs="+", default=(), metavar="NAME", help="draw only there: bus, ring.py ..."
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="where results are added")
    parser.add_argument("--only", type=Path, metavar="FILE", help="judge the mutants of this former result")
    parser.add_argument("--status", choices=["killed", "survived"], help="of --only those that were this")
    return parser


def read(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


def mutant_of(row: dict[str, Any]) -> Mutant:
    return Mutant(**{name: row[name] for name in Mutant._fields})


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown: how many of each top folder were killed."""
    counts = Counter((folder_of(row["file"]), row["status"]) for row in rows)
    lines = ["| folder | mutants | killed | share |", "|---|--:|--:|--:|"]
    for folder in [*sorted({folder for folder, _ in counts}), "all"]:
        killed, survived = (
            sum(
                number
                for (name, status), number in counts.items()
                if folder in (name, "all") and status == which
            )
            for which in ("killed", "survived")
        )
        every = killed + survived
        lines.append(f"| {folder} | {every} | {killed} | {killed / max(every, 1):.0%} |")
    return "\n".join([*lines, "", f"{sum(row['seconds'] for row in rows) / 60:.0f} minutes"])


def folder_of(file: str) -> str:
    inner = Path(file).relative_to(PACKAGE)
    return inner.parts[0] if len(inner.parts) > 1 else inner.name


if __name__ == "__main__":
    sys.exit(main())
