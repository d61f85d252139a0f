"""Things in the middle of their work: of each compiled class the first that a lab and a hub in virtual time have.

Nothing here has a thread or a connection, so a forked process has its own of all of them.
"""

from __future__ import annotations

import gc
from collections import deque
from typing import Any

import canwire
from canwire.boards.config.configuration import Config
from canwire.bus.can.stimulus import Stimulus
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.held.bells import Bells
from canwire.hub.owner.lockstep.pace import LockstepPace
from canwire.hub.owner.lockstep.turns import Turns
from canwire.hub.owner.loop import Loop
from canwire.hub.owner.pace import FastPace, RealPace
from canwire.hub.owner.world import World
from tests.walk.names import classes_of, compiled, loaded

_MOST = 400_000  # objects that are looked at


def scene() -> list[Any]:
    """What keeps all of it alive: hold it as long as the things are used."""
    lab = canwire.Lab()
    bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
    nodes = [
        bus.node("a", oscillator_ppm=100.0),
        bus.node("b", oscillator_ppm=-3_000.0),
        bus.node("c", controller="sja1000", filters=[(0x100, 0x700)]),
    ]
    bus.faults.flip(bit=30)
    bus.faults.noise(0.001)
    for node in nodes:
        node.send(canwire.Frame(0x123, b"\x11\x22"))
    lab.run_for(0.000_3)  # in the middle of a frame
    hub = canwire.connect(time="virtual")
    place = canwire.find_lines(hub, "can0")[0]
    timing = canwire.BitTiming.for_bit_rate(500_000, clock_hz=8_000_000)
    lease = canwire.start_line(hub, place, canwire.LineMode(timing))
    channel = hub.open_channel(place.board.id, place.line)
    channel.set_up(canwire.ChannelMode(receive=16, transmit=16))
    channel.activate()
    channel.send(canwire.Frame(0x10, b"\x01"))
    frame = canwire.Frame(0x123, b"\x11")
    return [
        lab,
        bus,
        nodes,
        hub,
        lease,
        channel,
        frame,
        canwire.BitLayout(frame),
        canwire.SlcanReader(),
        *_beneath(),
    ]


def _beneath() -> list[Any]:
    """What a hub with a thread has beneath it, without its thread."""
    world, turns = World(Config.default()), Turns()
    world.bells = Bells()
    pace = RealPace(world)
    engine = Engine(World(Config.default(), virtual=True), "virtual")
    loop = Loop(engine, pace, deque())
    lockstep = LockstepPace(World(Config.default(), turns=turns), 1.0)
    return [
        loop,
        pace,
        FastPace(World(Config.default())),
        turns,
        lockstep,
        Stimulus([100, 200], [0, 1], None),
    ]


def found_in(things: list[Any]) -> dict[type, Any]:
    """The first of each compiled class that these things lead to."""
    wanted = {kind for name in compiled() for kind in classes_of(loaded(name))}
    found: dict[type, Any] = {}
    seen: set[int] = set()
    waiting: deque[Any] = deque(things)
    while waiting and len(seen) < _MOST and len(found) < len(wanted):
        thing = waiting.popleft()
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        if type(thing) in wanted:
            found.setdefault(type(thing), thing)
        if not isinstance(thing, type) and not hasattr(thing, "__spec__"):
            waiting.extend(gc.get_referents(thing))
    return found
