"""table.py on a hub in a process of its own: what goes over its socket, and a connection that breaks.

Each time as much of it as has every program start and act in everything that happens on every board; every pair of
programs with CANWIRE_WHOLE_MATRIX=1.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest

import canwire
from canwire import NoSuchBoard
from tests import warm
from tests.cases import hold_for_each
from tests.hubs import LONG_S, serving
from tests.together import table
from tests.together.happenings import HAPPENINGS
from tests.together.players.every import PLAYERS
from tests.together.players.player import DONE
from tests.together.scene import BOARD, Scene, config_of
from tests.together.table import CELLS, SPREAD, Cell, by_starter
from tests.together.test_matrix import program_settings

__all__ = ["program_settings"]  # pytest finds the fixture by its name here

WHOLE = os.environ.get("CANWIRE_WHOLE_MATRIX") == "1"
PROCESS_CELLS = CELLS if WHOLE else SPREAD
STARTED = by_starter(PROCESS_CELLS)
BOARDS = sorted({cell.board for cell in PROCESS_CELLS})


@pytest.fixture(scope="module")
def addresses(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """One hub for each board."""
    with ExitStack() as stack:
        yield {
            kind: stack.enter_context(serving(tmp_path_factory.mktemp("hub"), config_of(kind))).address
            for kind in BOARDS
        }


@pytest.mark.parametrize("cells", STARTED.values(), ids=STARTED)
@pytest.mark.conforms("N-01", "N-02", "N-03", "N-04", "N-06")
def test_cells(addresses: dict[str, str], cells: list[Cell]) -> None:
    """All that happens on a board to a starter's line."""
    hold_for_each(cells, lambda cell: _play(addresses[cell.board], cell))


def _play(address: str, cell: Cell) -> None:
    with ExitStack() as stack:

        def connect(name: str) -> canwire.Hub:
            return stack.enter_context(canwire.connect(address, name=name))

        scene = Scene(connect, cell.board)
        stack.callback(_reset, scene)
        stack.callback(scene.close)
        starter = scene.play(PLAYERS[cell.starter])
        assert starter.set_up() == DONE
        HAPPENINGS[cell.event](scene, cell, starter, scene.play(PLAYERS[cell.actor]))


KILLED_BY_THE_SYSTEM = [kind for kind in table.KINDS if kind != table.DONGLE]


@pytest.mark.parametrize("kind", KILLED_BY_THE_SYSTEM)
@pytest.mark.conforms("N-04")
def test_a_starter_is_killed_by_the_system(addresses: dict[str, str], kind: str) -> None:
    """SIGKILL: nothing of the program runs any more, and the hub alone gives back what it held."""
    address = addresses["inducan104"]
    with ExitStack() as stack:

        def connect(name: str) -> canwire.Hub:
            return stack.enter_context(canwire.connect(address, name=name))

        scene = Scene(connect, "inducan104")
        stack.callback(_reset, scene)
        stack.callback(scene.close)
        starter = stack.enter_context(_program(kind, address))
        other = scene.play(PLAYERS[table.VERBS])
        assert other.join() == DONE
        assert scene.hear(other)
        assert (scene.status().channels, bool(scene.status().control_holder)) == (2, kind in table.HOLDS)
        starter.kill()
        assert starter.wait(LONG_S) == -signal.SIGKILL
        assert scene.until(lambda: scene.status().channels == 1)
        assert scene.status().control_holder == ""
        assert scene.hear(other)
        assert scene.send(other) == DONE
        other.end()
        assert scene.until(lambda: not scene.status().running)


@contextmanager
def _program(kind: str, address: str) -> Iterator[subprocess.Popen[str]]:
    """tests/together/program.py, once it has set its line up."""
    command = [sys.executable, "-m", "tests.together.program", kind, address]
    with warm.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == f"{DONE}\n"
            yield process
        finally:
            process.kill()


def _reset(scene: Scene) -> None:
    """As it was before, for the next cell."""
    try:
        scene.hub.board(BOARD)
    except NoSuchBoard:
        scene.plug()
    with scene.hub.open_control(scene.board.id, 0) as control:
        control.reset()
