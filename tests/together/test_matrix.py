"""Every cell of table.py, on a hub in this process, in virtual time."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path

import pytest

from canwire.acan import service
from canwire.candrv.device import device
from canwire.python_can import line
from tests.together import table
from tests.together.players.acan import AcanApi, AcanInt2d
from tests.together.players.candrv import REGISTRY, CandrvHandle, CandrvWin32
from tests.together.players.dongle import DongleHost
from tests.together.players.player import DONE, OTHER_RATE, Player
from tests.together.players.python_can import PythonCan
from tests.together.players.vci_v3 import VciV3
from tests.together.players.vci_v4 import VciV4
from tests.together.players.verbs import Verbs
from tests.together.scene import Scene, virtual_scene
from tests.together.table import CELLS, REFUSES, SEES, SPREAD, Cell, Line

PLAYERS: dict[str, type[Player]] = {
    made.kind: made
    for made in (
        VciV4,
        VciV3,
        AcanApi,
        AcanInt2d,
        CandrvHandle,
        CandrvWin32,
        PythonCan,
        Verbs,
        DongleHost,
    )
}


@pytest.fixture(autouse=True)
def program_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """CID1: is the shared line; nobody waits long for a control that stays taken."""
    path = tmp_path / "canwire.toml"
    path.write_text(REGISTRY)
    monkeypatch.setenv("CANWIRE_CONFIG", str(path))
    monkeypatch.setattr(line, "_PATIENCE_S", 0.0)
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


@pytest.mark.parametrize("cell", CELLS, ids=str)
@pytest.mark.conforms("N-01", "N-02", "N-03", "N-04", "N-05", "N-06")
@pytest.mark.finding("acan A1", "acan A2", "acan A3")
def test_cell(cell: Cell) -> None:
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


def _sees(cell: Cell, line: Line, starter: Player, actor: Player | None = None) -> None:
    assert starter.state() == SEES[cell.starter][line]
    if actor is not None:
        assert actor.state() == SEES[cell.actor][line]


def _join_running(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    holder = scene.status().control_holder
    told = actor.join()
    assert told == cell.told
    assert scene.status().control_holder == holder
    programs = [starter, actor] if told == DONE else [starter]
    assert scene.hear(*programs)
    assert [scene.send(one) for one in programs] == [DONE] * len(programs)
    _sees(cell, cell.after, starter, actor if told == DONE else None)


def _join_stopped(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert starter.stop() == DONE
    told = actor.join()
    assert told == cell.told
    _sees(cell, cell.after, starter, actor if told == DONE else None)
    assert scene.status().running == (cell.after is Line.ON)


def _act(call: Callable[[Player], str]) -> Callable[[Scene, Cell, Player, Player], None]:
    def happen(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
        assert actor.join() == DONE
        assert call(actor) == cell.told
        _sees(cell, cell.after, starter, actor)
        assert scene.status().running == (cell.after is Line.ON)
        if cell.after is Line.ON:
            assert scene.hear(starter, actor)

    return happen


def _set_rate(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert actor.join() == DONE
    before = scene.status().mode
    assert actor.set_rate(OTHER_RATE) == cell.told
    if cell.told == DONE:
        mode = scene.status().mode
        assert mode is not None
        assert mode.timing is not None
        assert mode.timing.bit_rate == OTHER_RATE
        assert starter.state() == SEES[cell.starter][Line.ON].replace("250", "500")
        return
    assert scene.status().mode == before
    _sees(cell, Line.ON, starter, actor)
    assert scene.hear(starter, actor)


def _recover(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert actor.join() == DONE
    scene.bus_off()
    _sees(cell, Line.BUS_OFF, starter, actor)
    assert actor.recover() == cell.told
    _sees(cell, cell.after, starter, actor)
    if cell.told == DONE:
        assert scene.hear(starter, actor)


def _ends(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert actor.join() == DONE
    starter.end()
    _left(scene, cell, actor, actor.end)


def _killed(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert actor.join() == DONE
    scene.kill(starter)
    _left(scene, cell, actor, lambda: scene.kill(actor))


def _left(scene: Scene, cell: Cell, actor: Player, end: Callable[[], None]) -> None:
    """The last program has the line to itself; once it has gone the line is at rest, though some stay set up."""
    assert scene.hear(actor)
    assert scene.send(actor) == DONE
    assert actor.state() == SEES[cell.actor][Line.ON]
    end()
    assert scene.until(lambda: not scene.status().channels)
    status = scene.status()
    assert not status.running
    assert status.initialised == (table.KIN.get(cell.starter) in ("ACAN", "CANDRV"))
    assert (status.channels, status.control_holder) == (0, "")


def _pulled(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert actor.join() == DONE
    scene.pull()
    _sees(cell, Line.GONE, starter, actor)
    assert actor.send(0x123) != DONE
    scene.plug()
    again, another = scene.play(PLAYERS[cell.starter]), scene.play(PLAYERS[cell.actor])
    assert (again.set_up(), another.join()) == (DONE, DONE)
    assert scene.hear(again, another)


HAPPENINGS: dict[str, Callable[[Scene, Cell, Player, Player], None]] = {
    table.JOIN_RUNNING: _join_running,
    table.JOIN_STOPPED: _join_stopped,
    table.SET_RATE: _set_rate,
    table.TAKE_CONTROL: _act(lambda actor: actor.take_control()),
    table.STOP: _act(lambda actor: actor.stop()),
    table.RESET: _act(lambda actor: actor.reset()),
    table.RECOVER: _recover,
    table.ENDS: _ends,
    table.KILLED: _killed,
    table.PULLED: _pulled,
}
