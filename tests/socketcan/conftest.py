"""Hubs for programs that speak SocketCAN."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.socketcan.bench import Bench, on_a_hub_of_its_own


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """On a hub in fast time with the usual boards."""
    yield from on_a_hub_of_its_own(tmp_path)


@pytest.fixture
def real_bench(tmp_path: Path) -> Iterator[Bench]:
    """On one in real time."""
    yield from on_a_hub_of_its_own(tmp_path, "real")
