"""Hubs inside this process: the one that its plain `connect()` calls share, and private ones."""

from __future__ import annotations

import atexit
import os
import threading
from collections.abc import Callable

from canwire.boards.config.configuration import Config
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.engine import LOCKSTEP, REAL, VIRTUAL, Engine
from canwire.hub.owner.lockstep.turns import Turns
from canwire.hub.owner.world import World
from canwire.hub.usual import usual_config


def fresh_link(time: str, config: str | os.PathLike[str] | Config | None, name: str) -> LocalLink:
    """A link to a new private hub, which ends with the link."""
    turns = Turns() if time == LOCKSTEP else None
    engine = Engine(World(usual_config(config), virtual=time == VIRTUAL, turns=turns), time)
    _RUNNING.add(engine)
    return _local(engine, name, lambda: _end(engine))


def _end(engine: Engine) -> None:
    _RUNNING.discard(engine)
    engine.close()


class _Common:
    """The hub that a program's plain `connect()` calls share; it exists while a link to it is open."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._engine: Engine | None = None
        self._users = 0

    def connect(self, name: str) -> LocalLink:
        with self._lock:
            if self._engine is None or self._engine.closed:
                self._engine, self._users = Engine(World(usual_config()), REAL), 0
                _RUNNING.add(self._engine)
            self._users += 1
            engine = self._engine
        return _local(engine, name, lambda: self._release(engine))

    def _release(self, engine: Engine) -> None:
        """One user less; the last one takes the hub along."""
        with self._lock:
            if engine is not self._engine:
                return
            self._users -= 1
            if self._users:
                return
            self._engine = None
        _end(engine)


def _local(engine: Engine, name: str, released: Callable[[], object]) -> LocalLink:
    try:
        return LocalLink(engine, name, released)
    except BaseException:
        released()
        raise


def _end_all() -> None:
    """At the process's end: threads that still wait for their hub need no error any more."""
    for engine in list(_RUNNING):
        engine.close(tell=False)


_RUNNING: set[Engine] = set()
common_link = _Common().connect
"""A link to the common hub, for a program of that name."""
atexit.register(_end_all)
