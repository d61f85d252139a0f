"""The same for LIN lines: VCI V4, VCI V3 and `canwire lin` on one of them, another machine being the master."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager

import pytest

import canwire
from canwire import LinFrame, LinMode
from canwire.boards.config.configuration import Config
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from tests.hubs import connected
from tests.together.players.lin import OTHER_RATE, RATE, LinV3, LinV4, LinVerb
from tests.together.players.player import DONE, NO_CALL, Player

BOARD, MASTER, LINE = "HW000001", "HW000002", 2
CONFIG = Config.parse(
    """
[[bus]]
name = "can0"
[[bus]]
name = "lin0"
type = "lin"
[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"
[[board]]
kind = "usb-to-can-fd"
serial = "HW000002"
"""
)
DENIED = "VCI_E_ACCESSDENIED"
KINDS: tuple[type[Player], ...] = (LinV4, LinV3, LinVerb)
VCI = (LinV4, LinV3)
# what: who, what the actor is answered where the control is free and where the starter holds it, the line afterwards
TABLE: dict[str, dict[type[Player], tuple[str, str, str]]] = {
    "joins": dict.fromkeys(KINDS, (DONE, DONE, f"{RATE} bit/s")),
    "sets another rate": dict.fromkeys(VCI, (DENIED, DENIED, f"{RATE} bit/s"))
    | {LinVerb: ("BadValue", "BadValue", f"{RATE} bit/s")},
    "takes control": dict.fromkeys(VCI, (DONE, DENIED, f"{RATE} bit/s"))
    | {LinVerb: (NO_CALL, NO_CALL, f"{RATE} bit/s")},
    "stops": dict.fromkeys(VCI, (DONE, DENIED, "stopped")) | {LinVerb: (NO_CALL, NO_CALL, f"{RATE} bit/s")},
    "resets": {
        LinV4: (DONE, DENIED, "not set up"),
        LinV3: (DONE, DENIED, "stopped"),
        LinVerb: (NO_CALL, NO_CALL, f"{RATE} bit/s"),
    },
}
DO: dict[str, Callable[[Player], str]] = {
    "joins": lambda _: DONE,
    "sets another rate": lambda actor: actor.set_rate(OTHER_RATE),
    "takes control": lambda actor: actor.take_control(),
    "stops": lambda actor: actor.stop(),
    "resets": lambda actor: actor.reset(),
}


class LinScene:
    """One LIN line, and a master on another board."""

    def __init__(self, connect: Callable[[str], canwire.Hub]) -> None:
        self.connect = connect
        self.hub = connect("another machine")
        self._control = self.hub.open_lin_control(self.hub.board(MASTER).id, LINE)
        self._control.initialise(LinMode(True, RATE))
        self._control.start()
        self._next = 0

    def play(self, kind: type[Player]) -> Player:
        return kind(self.connect(kind.kind), self.hub.board(BOARD))

    def hear(self, *programs: Player) -> bool:
        """A frame of the master comes to each of them."""
        self._next += 1
        self._control.send(LinFrame(self._next, b"lin"))
        self.hub.run_for(0.05)
        return all(self._next in one.received() for one in programs)

    @property
    def line(self) -> canwire.LinLineStatus:
        return self.hub.lin_status(self.hub.board(BOARD).id, LINE).status


@contextmanager
def lin_scene() -> Iterator[LinScene]:
    with ExitStack() as stack:
        engine = stack.enter_context(closing(Engine(World(CONFIG, virtual=True), "virtual")))
        yield LinScene(lambda name: stack.enter_context(connected(engine, name)))


@pytest.mark.parametrize("what", TABLE)
@pytest.mark.parametrize("second", KINDS, ids=lambda kind: kind.kind)
@pytest.mark.parametrize("first", KINDS, ids=lambda kind: kind.kind)
@pytest.mark.conforms("N-01", "N-02", "N-03", "N-06")
def test_lin_cell(first: type[Player], second: type[Player], what: str) -> None:
    free, held, after = TABLE[what][second]
    told = held if first in VCI else free
    with lin_scene() as scene:
        starter, actor = scene.play(first), scene.play(second)
        assert (starter.set_up(), actor.join()) == (DONE, DONE)
        assert scene.hear(starter, actor)
        assert DO[what](actor) == told
        line = after if told == DONE else f"{RATE} bit/s"
        assert (starter.state(), actor.state()) == (line, line)
        assert not scene.line.running or scene.hear(starter, actor)


@pytest.mark.parametrize("second", KINDS, ids=lambda kind: kind.kind)
@pytest.mark.parametrize("first", KINDS, ids=lambda kind: kind.kind)
@pytest.mark.parametrize("killed", [False, True], ids=["ends", "is killed"])
@pytest.mark.conforms("N-04")
def test_a_lin_line_outlives_its_starter_and_rests_without_programs(
    first: type[Player], second: type[Player], killed: bool
) -> None:
    def leaves(program: Player) -> None:
        program.hub._link.close() if killed else program.end()

    with lin_scene() as scene:
        starter, actor = scene.play(first), scene.play(second)
        assert (starter.set_up(), actor.join()) == (DONE, DONE)
        leaves(starter)
        assert scene.hear(actor)
        leaves(actor)
        assert not scene.line.initialised


@pytest.mark.parametrize("second", KINDS, ids=lambda kind: kind.kind)
@pytest.mark.parametrize("first", KINDS, ids=lambda kind: kind.kind)
@pytest.mark.conforms("N-01")
def test_a_board_with_a_lin_line_is_pulled(first: type[Player], second: type[Player]) -> None:
    gone = {LinV4: "VCI_E_DEVICE_NOT_CONNECTED", LinV3: "VCI_E_DEVICE_NOT_CONNECTED", LinVerb: "NoSuchBoard"}
    with lin_scene() as scene:
        starter, actor = scene.play(first), scene.play(second)
        assert (starter.set_up(), actor.join()) == (DONE, DONE)
        scene.hub.unplug(BOARD)
        assert (starter.state(), actor.state()) == (gone[first], gone[second])
        scene.hub.plug("usb-to-can-fd", BOARD)
        again, another = scene.play(first), scene.play(second)
        assert (again.set_up(), another.join()) == (DONE, DONE)
        assert scene.hear(again, another)
