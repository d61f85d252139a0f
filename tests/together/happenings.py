"""What happens in the cells of table.py: played by any scene, on boards of any kind."""

from __future__ import annotations

from collections.abc import Callable

from tests.together import table
from tests.together.players.every import PLAYERS
from tests.together.players.player import DONE, OTHER_RATE, RATE, Player
from tests.together.scene import Scene
from tests.together.table import SEES, Cell, Line


def _sees(scene: Scene, cell: Cell, line: Line, starter: Player, actor: Player | None = None) -> None:
    scene.settle(line)
    _comes_to_see(scene, starter, SEES[cell.starter][line])
    if actor is not None:
        _comes_to_see(scene, actor, SEES[cell.actor][line])


def _comes_to_see(scene: Scene, program: Player, state: str) -> None:
    """A program's library may hear of a change in a thread of its own."""
    seen = ""

    def sees() -> bool:
        nonlocal seen
        seen = program.state()
        return seen == state

    scene.until(sees)
    assert seen == state


def _join_running(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    holder = scene.status().control_holder
    told = actor.join()
    assert told == cell.told
    assert scene.status().control_holder == holder
    programs = [starter, actor] if told == DONE else [starter]
    assert scene.hear(*programs)
    assert [scene.send(one) for one in programs] == [DONE] * len(programs)
    _sees(scene, cell, cell.after, starter, actor if told == DONE else None)


def _join_stopped(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert starter.stop() == DONE
    told = actor.join()
    assert told == cell.told
    _sees(scene, cell, cell.after, starter, actor if told == DONE else None)
    assert scene.status().running == (cell.after is Line.ON)
    mode = scene.status().mode
    assert mode is not None
    assert mode.timing is not None
    assert mode.timing.bit_rate == RATE


def _act(call: Callable[[Player], str]) -> Callable[[Scene, Cell, Player, Player], None]:
    def happen(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
        assert actor.join() == DONE
        assert call(actor) == cell.told
        _sees(scene, cell, cell.after, starter, actor)
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
        scene.settle(Line.ON)
        assert starter.state() == SEES[cell.starter][Line.ON].replace("250", "500")
        return
    assert scene.status().mode == before
    _sees(scene, cell, Line.ON, starter, actor)
    assert scene.hear(starter, actor)


def _recover(scene: Scene, cell: Cell, starter: Player, actor: Player) -> None:
    assert actor.join() == DONE
    scene.bus_off()
    _sees(scene, cell, Line.BUS_OFF, starter, actor)
    assert actor.recover() == cell.told
    _sees(scene, cell, cell.after, starter, actor)
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
    scene.settle(Line.ON)
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
    _sees(scene, cell, Line.GONE, starter, actor)
    assert actor.send(0x123) != DONE
    scene.plug()
    again, another = scene.play(PLAYERS[cell.starter]), scene.play(PLAYERS[cell.actor])
    assert (again.set_up(), another.join()) == (DONE, DONE)
    scene.settle(Line.ON)
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
