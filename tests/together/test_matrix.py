"""Every cell of table.py, on a hub in this process, in virtual time."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from canwire.acan import service
from canwire.candrv.device import device
from canwire.hub.bring_up import bring_up
from tests.cases import hold_for_each
from tests.together import table
from tests.together.happenings import HAPPENINGS
from tests.together.players.candrv import REGISTRY
from tests.together.players.every import PLAYERS
from tests.together.players.player import DONE
from tests.together.players.verbs import Verbs
from tests.together.scene import virtual_scene
from tests.together.table import CELLS, REFUSES, SEES, SPREAD, Cell, Line, by_starter

STARTED = by_starter(CELLS)


@pytest.fixture(autouse=True)
def program_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """CID1: is the shared line; nobody waits long for a control that stays taken."""
    path = tmp_path / "canwire.toml"
    path.write_text(REGISTRY)
    monkeypatch.setenv("CANWIRE_CONFIG", str(path))
    monkeypatch.setitem(bring_up.__kwdefaults__, "patience_s", 0.0)
    monkeypatch.setattr(service, "_PAUSES_S", (0.0,))
    monkeypatch.setattr(device, "_PAUSES_S", (0.0,))


def test_the_table_is_whole() -> None:
    """No empty cell, and no kind of program or line that is not played."""
    assert set(PLAYERS) == set(table.KINDS) == set(SEES)
    assert all(set(sees) == set(Line) for sees in SEES.values())
    for event, rows in table.EVENTS.items():
        assert set(rows) >= set(table.KINDS) - {table.DONGLE}, event
    assert len(set(CELLS)) == len(CELLS)


def test_no_cell_is_empty() -> None:
    """On every board every program starts, and acts, in everything that happens; or the table says why it cannot."""
    assert set(SPREAD) <= set(CELLS)
    for board, event in itertools.product(table.BOARDS, table.EVENTS):
        found = [cell for cell in SPREAD if (cell.board, cell.event) == (board, event)]
        kinds = {kind for kind in table.KINDS if (kind, board) not in REFUSES}
        first = {table.DONGLE} if board == table.DONGLES_OWN else kinds - {table.DONGLE}
        if event == table.JOIN_STOPPED:
            first &= table.CAN_STOP
        assert {cell.starter for cell in found} == first
        guests = kinds if board == table.DONGLES_OWN else kinds - {table.DONGLE}
        assert {cell.actor for cell in found} == (guests & set(table.EVENTS[event]) if first else set())


@pytest.mark.parametrize("cells", STARTED.values(), ids=STARTED)
@pytest.mark.conforms("N-01", "N-02", "N-03", "N-04", "N-05", "N-06")
@pytest.mark.finding("acan A1", "acan A2", "acan A3")
def test_cells(cells: list[Cell]) -> None:
    """All that happens on a board to a starter's line."""
    hold_for_each(cells, _play)


def _play(cell: Cell) -> None:
    with virtual_scene(cell.board) as scene:
        starter = scene.play(PLAYERS[cell.starter])
        assert starter.set_up() == DONE
        actor = scene.play(PLAYERS[cell.actor])
        HAPPENINGS[cell.event](scene, cell, starter, actor)


@pytest.mark.parametrize(("kind", "board"), REFUSES)
@pytest.mark.conforms("N-06")
def test_a_board_that_an_interface_cannot_drive(kind: str, board: str) -> None:
    with virtual_scene(board) as scene:
        assert scene.play(PLAYERS[kind]).set_up() == REFUSES[kind, board]
        assert not scene.status().channels
        starter, actor = scene.play(Verbs), scene.play(PLAYERS[kind])
        assert (starter.set_up(), actor.join()) == (DONE, REFUSES[kind, board])
        assert scene.hear(starter)
