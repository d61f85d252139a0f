"""A process that has loaded the command line, and runs it in a fork of itself as often as asked: see `Warm`.

What differs from `python -m canwire` is that nothing has to be loaded. Each fork has the streams it is given, makes
Python's own of them as the interpreter does, and ends as an interpreter ends.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

NOTHING = os.devnull
CLOSED = None
Streams = tuple[str | None, str | None, str | None]  # the files that are stdin, stdout and stderr


class Ended(NamedTuple):
    """What a command has come to."""

    returncode: int
    stderr: str


class Warm:
    """The process, from the outside."""

    def __init__(self, *verbs: str) -> None:
        command = [sys.executable, "-m", "tests.attacks.warm", *verbs]
        root = Path(__file__).parents[2]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=root
        )

    def run(self, words: list[str], streams: Streams) -> Ended:
        """`canwire WORDS`; the text is that of stderr, if it went to a file."""
        told, answers = self._process.stdin, self._process.stdout
        assert told is not None
        assert answers is not None
        print(json.dumps([words, streams]), file=told, flush=True)
        status = int(answers.readline())
        errors = Path(streams[2]) if streams[2] is not None else None
        return Ended(status, errors.read_text() if errors is not None and errors.is_file() else "")

    def close(self) -> None:
        """End it, and wait for its end."""
        self._process.communicate()


def become(streams: Streams) -> None:
    """From now on these are the streams of this process."""
    for number, path in enumerate(streams):
        if path is not CLOSED:
            opened = os.open(path, os.O_WRONLY | os.O_CREAT if number else os.O_RDONLY, 0o600)
            os.dup2(opened, number)
            os.close(opened)
    for number, path in enumerate(streams):
        if path is CLOSED:
            os.close(number)
    kinds: list[dict[str, Any]] = [{"mode": "r"}, {"mode": "w"}, {"mode": "w", "errors": "backslashreplace"}]
    sys.stdin, sys.stdout, sys.stderr = (
        None if path is CLOSED else open(number, closefd=False, encoding="utf-8", **kinds[number])  # noqa: SIM115
        for number, path in enumerate(streams)
    )
    sys.__stdin__, sys.__stdout__, sys.__stderr__ = sys.stdin, sys.stdout, sys.stderr  # type: ignore[misc]


def main() -> int:
    from canwire.__main__ import main as run
    from canwire.commands import VERBS

    for verb in sys.argv[1:]:
        importlib.import_module(VERBS[verb].module)
    for line in sys.stdin:
        words, streams = json.loads(line)
        child = os.fork()
        if not child:
            become(streams)
            sys.argv[1:] = words
            return run()
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
