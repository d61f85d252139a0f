"""A hub that runs as a separate process, in the foreground."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from canwire.boards.wiring import config_warnings
from canwire.errors import BadValue, HubError
from canwire.hub.links.answering import Server
from canwire.hub.owner.engine import LOCKSTEP, REAL, Engine
from canwire.hub.owner.lockstep.pace import PATIENCE_S, LockstepPace
from canwire.hub.owner.lockstep.turns import Turns
from canwire.hub.owner.world import World
from canwire.hub.usual import default_address, usual_config
from canwire.platform import raise_descriptor_limit, signals_end_waits
from canwire.values.checks import finite, whole
from canwire.values.checks import pace as checked_pace

if TYPE_CHECKING:
    from canwire.boards.config.configuration import Config
    from canwire.hub.handles.event import Event

_MOST_PROGRAMS = 4096


def serve(
    address: str | None = None,
    config: str | os.PathLike[str] | Config | None = None,
    time: str = REAL,
    *,
    programs: int | Sequence[str] = 1,
    patience_s: float = PATIENCE_S,
    pace: float | None = None,
    ready: Callable[[str], object],
    stop: Event,
    warn: Callable[[str], object] | None = None,
) -> None:
    """Run a hub on a socket (None: the user's default socket) until `stop` is set.

    `ready` gets one line about the hub once clients can connect. Before that, `warn` gets a line for each unusual
    setting of the buses, and later a line whenever lines of a bus run at different rates. `time` is "real", "fast" or
    "lockstep". Lockstep begins once this number of `programs` takes part, or all programs of these names, which then
    have their turns in this order; `warn` gets a line about a program that computes for longer than `patience_s`. With
    a `pace`, lockstep time passes this many times as fast as the computer's clock; Hub.set_pace changes it. Raises
    HubError if another hub listens there, BadConfig for a bad configuration.
    """
    config = usual_config(config)
    raise_descriptor_limit()
    engine = _engine(config, time, programs, patience_s, checked_pace(pace))
    with contextlib.ExitStack() as closing:
        closing.callback(engine.close)
        server = Server(engine, default_address() if address is None else address)
        closing.callback(server.close)
        engine.when_closed(stop.set)
        if warn is not None:
            for unusual in config_warnings(config):
                warn(unusual)
            engine.world.warn = warn
        ready(_introduction(engine, server.path))
        with signals_end_waits():
            stop.wait()
        if engine.closed:
            raise HubError("the hub's engine stopped; see the traceback above")


def _engine(
    config: Config, time: str, programs: int | Sequence[str], patience_s: float, pace: float
) -> Engine:
    if time != LOCKSTEP:
        if pace:
            raise BadValue(f"a pace is for lockstep: {time} time has its own")
        return Engine(World(config), time)
    finite("patience_s", patience_s, 0.001, 1e9)
    if isinstance(programs, int):
        turns = Turns(whole("programs", programs, 1, _MOST_PROGRAMS))
    else:
        turns = Turns(len(programs), programs)
    world = World(config, turns=turns)
    assert world.lockstep is not None
    world.lockstep.held.hold(pace)
    return Engine(world, time, LockstepPace(world, patience_s))


def _introduction(engine: Engine, path: str) -> str:
    world = engine.world
    buses, boards = engine.call(lambda: (len(world.buses), len(world.boards)))
    what = f"{_count(buses, 'bus', 'buses')}, {_count(boards, 'board', 'boards')}"
    return f"canwire hub on {path}: {what}, {engine.time} time"


def _count(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}"
