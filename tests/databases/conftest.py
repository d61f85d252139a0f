"""The databases that tests decode by."""

from __future__ import annotations

from pathlib import Path

import pytest

import canwire

pytest.importorskip("cantools")

ROOT = Path(__file__).resolve().parents[2]
ENGINE = ROOT / "examples" / "engine.dbc"
DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="session")
def engine() -> canwire.Database:
    """examples/engine.dbc: start values, texts, a multiplexer, two J1939 messages."""
    return canwire.load_database(ENGINE)
