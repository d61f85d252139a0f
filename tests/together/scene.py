"""A hub with one board that several programs share, and another machine on its bus."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from typing import Protocol

import canwire
from canwire import BitTiming, ChannelMode, ErrorState, Event, Frame, LineMode, LineStatus
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from tests.hubs import LONG_S, connected, parsed
from tests.together.players.player import Player
from tests.together.table import Line

BOARD, PEER_BOARD = "HW000001", "HW000002"
PEER_ID, PROVOKED = 0x700, 0x7FE
_TIMING = BitTiming.from_btr(0x01, 0x1C)  # RATE
_STEP_S, _STEPS, _REAL_STEPS = 0.005, 100, 4000


def config_of(kind: str) -> str:
    """One board of this kind, and that of the other machine."""
    lin = ', ""' if kind == "usb-to-can-fd" else ""
    buses = {"usb-to-can-fd": f'"can0", ""{lin}', "usb-to-can": '"can0", ""'}.get(kind, '"can0"')
    return f"""
[[bus]]
name = "can0"

[[board]]
kind = "{kind}"
serial = "{BOARD}"
buses = [{buses}]

[[board]]
kind = "usb-to-can"
serial = "{PEER_BOARD}"
buses = ["can0", ""]
"""


class OtherMachine(Protocol):
    """Another machine on the bus, which hears and acknowledges everything."""

    def send(self, identifier: int) -> None: ...
    def hears(self, identifier: int) -> bool: ...


class Peer:
    """Another machine on the bus, which hears and acknowledges everything."""

    def __init__(self, hub: canwire.Hub) -> None:
        board = hub.board(PEER_BOARD)
        self._control = hub.open_control(board.id, 0)
        self._control.initialise(LineMode(_TIMING))
        self._channel = hub.open_channel(board.id, 0)
        self._channel.set_up(ChannelMode(500, 500))
        self._channel.activate()
        self._control.start()
        self.heard: set[int] = set()

    def send(self, identifier: int) -> None:
        self._channel.send(Frame(identifier))

    def hears(self, identifier: int) -> bool:
        self.heard |= {frame.id for frame in self._channel.receive_many(500)}
        return identifier in self.heard


class Scene:
    """`connect` makes a program's own connection to the hub, which may be in this process or in one of its own."""

    def __init__(
        self,
        connect: Callable[[str], canwire.Hub],
        kind: str,
        peer: OtherMachine | None = None,
    ) -> None:
        self.connect = connect
        self.kind = kind
        self.hub = connect("bench")
        self.peer = peer or Peer(connect("another machine"))
        self.players: list[Player] = []
        self._identifiers = itertools.count(0x100)

    @property
    def board(self) -> canwire.BoardInfo:
        return self.hub.board(BOARD)

    def play(self, kind: type[Player]) -> Player:
        """A program of this kind, which has opened nothing yet."""
        self.players.append(kind(self.connect(kind.kind), self.board))
        return self.players[-1]

    def status(self) -> LineStatus:
        return self.hub.line_status(self.board.id, 0)

    def until(self, ready: Callable[[], bool]) -> bool:
        """Let time pass until then, or for longer than anything here takes."""
        for _ in range(_STEPS if self.hub.virtual else _REAL_STEPS):
            if ready():
                return True
            if self.hub.virtual:
                self.hub.run_for(_STEP_S)
            else:
                time.sleep(_STEP_S)
        return ready()

    def hear(self, *programs: Player) -> bool:
        """A frame of the other machine comes to each of them."""
        identifier = next(self._identifiers)
        waiting = list(programs)
        self.peer.send(identifier)

        def all_have() -> bool:
            waiting[:] = [one for one in waiting if identifier not in one.received()]
            return not waiting

        return self.until(all_have)

    def send(self, program: Player) -> str:
        """A frame of this program comes to the other machine; "lost", or what the program was told, if it does not."""
        identifier = next(self._identifiers)
        told = program.send(identifier)
        if told != "done":
            return told
        return told if self.until(lambda: self.peer.hears(identifier)) else "lost"

    def bus_off(self) -> None:
        """Disturb what the line sends until it leaves the bus."""
        fault = self.hub.bus("can0").faults.inject("bit", frame_id=PROVOKED, times=None)
        with self.hub.open_channel(self.board.id, 0) as channel:
            channel.set_up(ChannelMode(1, 8, frames=False))
            channel.activate()
            channel.send(Frame(PROVOKED))
            assert self.until(lambda: self.status().state == ErrorState.BUS_OFF)
            fault.cancel()
            channel.cancel()

    def settle(self, line: Line) -> None:
        """Return once the line is so, where that takes a while after the call."""

    def kill(self, program: Player) -> None:
        """The program is gone without a word."""
        program.hub._link.close()

    def pull(self) -> None:
        """The board is gone, and every program's connection has told it so: the list's change comes behind that."""
        with ExitStack() as stack:
            told = [stack.enter_context(_watched(program.hub)) for program in self.players]
            self.hub.unplug(BOARD)
            assert all(event.wait(LONG_S) for event in told)

    def plug(self) -> None:
        buses = ("can0", "") if self.kind.startswith("usb") else ("can0",)
        self.hub.plug(self.kind, BOARD, buses)

    def close(self) -> None:
        for program in self.players:
            with suppress(canwire.HubLost, canwire.Unplugged):
                program.end()
        self.players.clear()  # and what they still held goes with them
        del self.peer


@contextmanager
def _watched(hub: canwire.Hub) -> Iterator[Event]:
    """Signalled when the hub has told this connection that its list of boards changed."""
    with closing(Event()) as event:
        hub.watch(event)
        yield event
        hub.unwatch(event)


@contextmanager
def virtual_scene(kind: str) -> Iterator[Scene]:
    """In this process, in virtual time."""
    with ExitStack() as stack:
        engine = stack.enter_context(closing(Engine(World(parsed(config_of(kind)), virtual=True), "virtual")))
        scene = Scene(lambda name: stack.enter_context(connected(engine, name)), kind)
        stack.callback(scene.close)
        yield scene
