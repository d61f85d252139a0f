"""Windows' programs for these tests; CANWIRE_WINDOWS is what starts its Python."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

LONG_S = 120  # after which something that should happen never will
PYTHON = os.environ.get("CANWIRE_WINDOWS", "")

Program = subprocess.Popen[str]


class Windows(NamedTuple):
    """`start` begins `python WORDS`, `run` has its output; `path` is what Linux' file is called there."""

    start: Callable[..., Program]
    run: Callable[..., str]

    @staticmethod
    def path(path: Path) -> str:
        return "Z:" + str(path).replace("/", "\\")


@pytest.fixture
def windows() -> Iterator[Windows]:
    """Its programs; those that still run in the end are killed."""
    if not PYTHON:
        pytest.skip("here is no Python of Windows: bash .ci/windows makes one, and runs these tests")
    running: list[Program] = []

    def start(*words: str) -> Program:
        made = subprocess.Popen(  # Wine takes pipes for streams, and neither /dev/null nor files
            [PYTHON, *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        running.append(made)
        return made

    def run(*words: str) -> str:
        said, _ = start(*words).communicate(timeout=LONG_S)
        return said

    yield Windows(start, run)
    for program in running:
        program.kill()
        program.communicate(timeout=LONG_S)
