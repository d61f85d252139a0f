"""Programs on pseudo terminals, and machines on one bus."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.commands.acan.bench import Bench, serving
from tests.commands.acan.screen import OpenScreen, Screen


@pytest.fixture
def open_screen() -> Iterator[OpenScreen]:
    """Opens terminals, which are closed in the end."""
    with ExitStack() as closing:

        def begin(*words: str) -> Screen:
            screen = Screen(words)
            closing.callback(screen.close)
            return screen

        yield begin


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with serving(tmp_path) as made:
        yield made
