"""The cells of adapter_table.py: what table.py's programs are told on real adapters that they share, in real time.

Each time every program starts and acts once in everything that happens; every pair with CANWIRE_WHOLE_MATRIX=1.
"""

from __future__ import annotations

import itertools
import os
from pathlib import Path

import pytest

from canwire.drivers.slcan_dongle.driver import SlcanDriver
from tests.cases import hold_for_each
from tests.together.adapter_table import (
    ADAPTER_REFUSES,
    ADAPTERS,
    NOT_APPLICABLE,
    adapter_cells,
)
from tests.together.adapters import adapter_scene
from tests.together.happenings import HAPPENINGS
from tests.together.players.every import PLAYERS
from tests.together.players.player import DONE
from tests.together.table import (
    CAN_STOP,
    DONGLE,
    EVENTS,
    JOIN_STOPPED,
    KINDS,
    VERBS,
    Cell,
    Line,
    by_starter,
)
from tests.together.test_matrix import program_settings

__all__ = ["program_settings"]  # pytest finds the fixture by its name here


@pytest.fixture(autouse=True)
def quick_polls(monkeypatch: pytest.MonkeyPatch) -> None:
    """A dongle's status, of which the cells wait for five changes each, is asked for more often than usually."""
    monkeypatch.setitem(SlcanDriver.__init__.__kwdefaults__, "poll_ns", 20_000_000)


WHOLE = os.environ.get("CANWIRE_WHOLE_MATRIX") == "1"
CELLS = adapter_cells(every=WHOLE)
STARTED = by_starter(CELLS)


def test_no_cell_is_empty() -> None:
    """Every program starts, and acts, in everything that happens to an adapter; or the table says why it cannot."""
    for adapter, event in itertools.product(ADAPTERS, EVENTS):
        found = [cell for cell in CELLS if (cell.board, cell.event) == (adapter, event)]
        there = {kind for kind in KINDS if kind != DONGLE and (kind, adapter) not in ADAPTER_REFUSES}
        if (adapter, event) in NOT_APPLICABLE:
            assert not found
            continue
        assert {cell.actor for cell in found} == there
        assert {cell.starter for cell in found} == (there & CAN_STOP if event == JOIN_STOPPED else there)


@pytest.mark.realtime
@pytest.mark.parametrize("cells", STARTED.values(), ids=STARTED)
@pytest.mark.conforms("N-01", "N-02", "N-03", "N-04", "N-06")
@pytest.mark.finding("acan A2")
def test_cells(tmp_path: Path, cells: list[Cell]) -> None:
    """All that happens on an adapter to a starter's line."""
    hold_for_each(cells, lambda cell: _play(tmp_path, cell))


def _play(tmp_path: Path, cell: Cell) -> None:
    with adapter_scene(cell.board, tmp_path / "tty", str(cell)) as scene:
        starter = scene.play(PLAYERS[cell.starter])
        assert starter.set_up() == DONE
        scene.settle(Line.ON)
        HAPPENINGS[cell.event](scene, cell, starter, scene.play(PLAYERS[cell.actor]))


@pytest.mark.realtime
@pytest.mark.parametrize(("kind", "adapter"), ADAPTER_REFUSES)
@pytest.mark.conforms("N-06")
def test_an_adapter_that_an_interface_cannot_drive(tmp_path: Path, kind: str, adapter: str) -> None:
    """It is refused in its own terms, and whoever is there goes on."""
    with adapter_scene(adapter, tmp_path / "tty", kind) as scene:
        first, second = scene.play(PLAYERS[VERBS]), scene.play(PLAYERS[kind])
        assert first.set_up() == DONE
        scene.settle(Line.ON)
        assert second.join() == ADAPTER_REFUSES[kind, adapter]
        assert scene.hear(first)
