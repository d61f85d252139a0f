"""Hubs for programs that speak SocketCAN."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire import Unsupported
from tests.hubs import serving
from tests.socketcan.bench import Bench


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """On a hub in fast time with the usual boards."""
    yield from _bench(tmp_path, "fast")


@pytest.fixture
def real_bench(tmp_path: Path) -> Iterator[Bench]:
    """On one in real time."""
    yield from _bench(tmp_path, "real")


def _bench(home: Path, time: str) -> Iterator[Bench]:
    if sys.platform != "linux":
        pytest.skip("SocketCAN programs are Linux's")
    from canwire.socketcan.launch import shim

    try:
        shim()
    except Unsupported as error:
        pytest.skip(str(error))
    with serving(home, time=time) as served:
        made = Bench(served, home)
        try:
            yield made
        finally:
            made.close()
