"""Every parser under inputs without end: atheris, whose mutations follow the code that they reach.

python benchmarks/fuzz.py --inputs 10000000          shared among all parsers (tests/attacks/parsers.py)
python benchmarks/fuzz.py --inputs 100000 LDF        one alone

A process each, one after the other; a row says how many inputs it took, how long, and what came out that it should
not. Status 1 if anything did: the input stands in --output, and belongs into a test. Needs atheris (canwire[fuzz]).
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parent.parent
_WEIGHTS = {"LDF": 0.02}  # of what a parser has as its share: one that is a hundred times as slow


def attack(name: str, inputs: int, output: Path, seed: int) -> None:
    """In a process of its own, which libFuzzer ends; an exception that is not the parser's own ends it sooner."""
    import atheris

    sys.path.insert(0, str(ROOT))
    with atheris.instrument_imports(include=["canwire"], enable_loader_override=False):
        from tests.attacks.parsers import PARSERS

        parser = PARSERS[name]

        def one(data: bytes) -> None:
            try:
                parser.run(data)
            except parser.refuses:
                return

        for good in parser.seeds:  # what it imports is instrumented, too
            one(good)

    corpus = output / "corpus" / _file_name(name)
    corpus.mkdir(parents=True, exist_ok=True)
    for number, good in enumerate(parser.seeds):
        (corpus / f"seed{number}").write_bytes(good)
    options = [f"-runs={inputs}", f"-seed={seed}", f"-artifact_prefix={output / _file_name(name)}-", "-timeout=20",
               "-rss_limit_mb=4096", "-print_final_stats=1", "-verbosity=0", "-max_len=4096"]  # fmt: skip
    atheris.Setup([sys.argv[0], *options, str(corpus)], one)
    atheris.Fuzz()


def row(name: str, inputs: int, output: Path, seed: int) -> tuple[int, str]:
    """What one parser was given, as a line of the table; its exit status."""
    began = time.monotonic()
    words = [
        sys.executable,
        __file__,
        "--one",
        name,
        "--inputs",
        str(inputs),
        "--output",
        str(output),
        "--seed",
        str(seed),
    ]
    ended = subprocess.run(words, capture_output=True, text=True, errors="replace")
    took = time.monotonic() - began
    done = re.search(r"stat::number_of_executed_units: (\d+)", ended.stderr)
    fault = re.search(r"=== Uncaught Python exception: ===\n(.*)", ended.stderr + ended.stdout)
    said = "" if ended.returncode == 0 else (fault[1] if fault else (ended.stderr or ended.stdout)[-300:])
    count = int(done[1]) if done else 0
    return ended.returncode, f"| {name} | {count:,} | {took:,.0f} s | {said or 'nothing'} |"


def _file_name(name: str) -> str:
    return re.sub(r"\W+", "-", name)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--inputs", type=int, default=100_000, metavar="N", help="in total (default: 100000)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=Path("fuzz"), metavar="FOLDER", help="default: ./fuzz")
    parser.add_argument("--one", metavar="PARSER", help=argparse.SUPPRESS)
    parser.add_argument("parsers", nargs="*", metavar="PARSER", help="default: all")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    try:
        import atheris  # noqa: F401
    except ImportError:
        print("fuzz.py: atheris is missing: pip install 'canwire[fuzz]'; nothing was tried", file=sys.stderr)
        return 0
    if arguments.one:
        attack(arguments.one, arguments.inputs, arguments.output, arguments.seed)
        return 0
    sys.path.insert(0, str(ROOT))
    from tests.attacks.parsers import PARSERS

    names = arguments.parsers or list(PARSERS)
    worst = 0
    print("| parser | inputs | took | came out that should not |\n|---|---|---|---|", flush=True)
    for name in names:
        share = int(arguments.inputs / len(names) * _WEIGHTS.get(name, 1.0))
        status, line = row(name, share, arguments.output, arguments.seed)
        worst = worst or status
        print(line, flush=True)
    return 1 if worst else 0


if __name__ == "__main__":
    sys.exit(main())
