"""A part of table.py on a hub in a process of its own: what goes over its socket, and a connection that breaks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack

import pytest

import canwire
from canwire import NoSuchBoard
from tests.hubs import serving
from tests.together import table
from tests.together.players.player import DONE
from tests.together.scene import BOARD, Scene, config_of
from tests.together.table import CELLS, FD, Cell
from tests.together.test_matrix import HAPPENINGS, PLAYERS, program_settings

__all__ = ["program_settings"]  # pytest finds the fixture by its name here

EVENTS = (table.JOIN_RUNNING, table.SET_RATE, table.STOP, table.KILLED, table.PULLED)
STARTERS = {FD: (table.V4, table.PYTHON), "inducan104": (table.V3, table.ACAN, table.CANDRV, table.VERBS)}
PROCESS_CELLS = [
    cell for cell in CELLS if cell.event in EVENTS and cell.starter in STARTERS.get(cell.board, ())
]


@pytest.fixture(scope="module")
def addresses(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """One hub for each board."""
    with ExitStack() as stack:
        yield {
            kind: stack.enter_context(serving(tmp_path_factory.mktemp("hub"), config_of(kind))).address
            for kind in STARTERS
        }


@pytest.mark.parametrize("cell", PROCESS_CELLS, ids=str)
@pytest.mark.conforms("N-01", "N-02", "N-03", "N-04", "N-06")
def test_cell(addresses: dict[str, str], cell: Cell) -> None:
    with ExitStack() as stack:
        address = addresses[cell.board]

        def connect(name: str) -> canwire.Hub:
            return stack.enter_context(canwire.connect(address, name=name))

        scene = Scene(connect, cell.board)
        stack.callback(_reset, scene)
        stack.callback(scene.close)
        starter = scene.play(PLAYERS[cell.starter])
        assert starter.set_up() == DONE
        HAPPENINGS[cell.event](scene, cell, starter, scene.play(PLAYERS[cell.actor]))


def _reset(scene: Scene) -> None:
    """As it was before, for the next cell."""
    try:
        scene.hub.board(BOARD)
    except NoSuchBoard:
        scene.plug()
    with scene.hub.open_control(scene.board.id, 0) as control:
        control.reset()
