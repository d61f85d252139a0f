"""Dongles without a bus, shut and open."""

from __future__ import annotations

import pytest

from tests.slcan.bench import Bench


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def opened() -> Bench:
    bench = Bench()
    assert bench.ask(b"S4\rO\r") == b"\r\r"
    return bench
