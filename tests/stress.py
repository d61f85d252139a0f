"""Tests on a machine that has other work to do: `python -m tests.stress [TESTS...] [--times 10] [--copies 1]`.

The tests (folders, files, names; none: all) run so many times beside a busy loop for each core. A table says which of
them failed and how often; the status is 1 if any did.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

FAILED = 1  # pytest's status where tests failed; others say that the run itself did not succeed
# whatever ends the process that started it, a loop ends soon after
_LOOP = "import os, sys\nwhile os.getppid() == int(sys.argv[1]):\n    for _ in range(100_000): pass"


@contextmanager
def busy(loops: int) -> Iterator[list[subprocess.Popen[bytes]]]:
    """So many processes that do nothing but keep a core busy."""
    command = [sys.executable, "-S", "-c", _LOOP, str(os.getpid())]
    with ExitStack() as stack:
        yield [stack.enter_context(_ended(subprocess.Popen(command))) for _ in range(loops)]


@contextmanager
def _ended(process: subprocess.Popen[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def failures(cache: Path, status: int) -> list[str]:
    """What failed in a run of pytest with this cache and status; a run without results counts as one that failed."""
    last = cache / "v/cache/lastfailed"
    if status == 0:
        return []
    if status == FAILED and last.exists():
        return list(json.loads(last.read_text()))
    return [f"(the run itself: pytest ended with status {status})"]


def repeated(tests: list[str], times: int, copies: int, folder: Path) -> Counter[str]:
    """How often each test failed; the output of each run is a file in this folder."""
    failed: Counter[str] = Counter()
    for turn in range(times):
        with ExitStack() as stack:
            caches = [folder / f"{turn}-{copy}" for copy in range(copies)]
            running = {cache: stack.enter_context(_run(tests, cache)) for cache in caches}
            for cache, process in running.items():
                failed.update(failures(cache, process.wait()))
    return failed


@contextmanager
def _run(tests: list[str], cache: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A run of pytest with this cache, and its output in a file beside it.

    Its tests' files are elsewhere, as the paths of sockets have to be short, and apart from other runs': pytest removes
    what earlier runs have left, and fails where another one does that at the same moment.
    """
    command = [sys.executable, "-m", "pytest", "-q", "-o", f"cache_dir={cache}", *tests]
    with (
        tempfile.TemporaryDirectory(prefix="s", ignore_cleanup_errors=True) as place,
        cache.with_suffix(".txt").open("wb") as output,
        _ended(
            subprocess.Popen(
                command,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PYTEST_DEBUG_TEMPROOT": place},
            )
        ) as process,
    ):
        yield process


def table(failed: Counter[str], runs: int) -> str:
    """Markdown: a row for each test that failed, most often first."""
    rows = [f"| failed in {runs} runs | test |", "|--:|---|"]
    return "\n".join([*rows, *(f"| {count} | {test} |" for test, count in failed.most_common())])


def split(words: list[str]) -> tuple[list[str], list[str]]:
    """Words of ours, and behind -- those of pytest."""
    end = words.index("--") if "--" in words else len(words)
    return words[:end], words[end + 1 :]


def arguments(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.stress", description=__doc__)
    parser.add_argument("tests", nargs="*", help="folders, files, names; after -- options of pytest")
    parser.add_argument("--times", type=int, default=10, help="how many times, one after the other (10)")
    parser.add_argument("--copies", type=int, default=1, help="how many runs at a time (1)")
    parser.add_argument(
        "--loops", type=int, default=os.cpu_count(), help="busy loops (as many as there are cores)"
    )
    return parser.parse_args(words)


def main(words: list[str] | None = None) -> int:
    """The command; its exit status."""
    own, options = split(sys.argv[1:] if words is None else words)
    asked = arguments(own)
    folder = Path(tempfile.mkdtemp(prefix="stress-"))
    with busy(asked.loops):
        failed = repeated([*asked.tests, *options], asked.times, asked.copies, folder)
    print(table(failed, asked.times * asked.copies))
    print(f"what each run printed: {folder}")
    return int(bool(failed))


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))  # what was started ends with us
    sys.exit(main())
