"""Where a program's hub is: at an address, at the user's usual one, or in the program itself."""

from __future__ import annotations

import atexit
import os
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.boards.config.configuration import Config
from canwire.errors import BadValue
from canwire.hub.handles.hub import Hub
from canwire.hub.links.local import LocalLink
from canwire.hub.links.unix_socket.client import SocketLink
from canwire.hub.links.unix_socket.sockets import somebody_listens
from canwire.hub.owner.engine import REAL, VIRTUAL, Engine
from canwire.hub.owner.world import World
from canwire.hub.usual import default_address, usual_config

if TYPE_CHECKING:
    from canwire.hub.protocol.link import Link


def connect(
    address: str | None = None,
    *,
    time: str | None = None,
    config: str | os.PathLike[str] | Config | None = None,
    name: str | None = None,
) -> Hub:
    """The hub at `address`, else at CANWIRE_HUB, else at this user's usual socket if somebody listens there.

    Else one inside this process, which all such calls share, in real time, until the last of their hubs is closed.
    With `time` ("real", "fast", "virtual") or `config` (a file, or what was made of one): always a fresh one
    inside this process, of its own. `name` is shown to others where this program holds something. A hub that nobody
    holds any more, nor anything opened on it, is closed by itself; `with` or `close` says when.

    Raises HubLost if nobody listens at a given address, BadConfig for a bad configuration.
    """
    name = name or _name_of_program()
    if time is not None or config is not None:
        if address is not None:
            raise BadValue(f"the hub at {address} has its own time and boards: leave time and config out")
        return _fresh(REAL if time is None else time, config, name)
    address = address or os.environ.get("CANWIRE_HUB")
    if address:
        return _hub(SocketLink(address, name))
    usual = default_address()
    if somebody_listens(usual):
        return _hub(SocketLink(usual, name))
    return _COMMON.connect(name)


def _fresh(time: str, config: str | os.PathLike[str] | Config | None, name: str) -> Hub:
    engine = Engine(World(usual_config(config), virtual=time == VIRTUAL), time)
    _RUNNING.add(engine)
    return _local(engine, name, lambda: _end(engine))


def _end(engine: Engine) -> None:
    _RUNNING.discard(engine)
    engine.close()


class _Common:
    """The hub that a program's plain `connect()` calls share: there while somebody uses it."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._engine: Engine | None = None
        self._users = 0

    def connect(self, name: str) -> Hub:
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


def _local(engine: Engine, name: str, released: Callable[[], object]) -> Hub:
    try:
        link = LocalLink(engine, name, released)
    except BaseException:
        released()
        raise
    return _hub(link)


def _hub(link: Link) -> Hub:
    try:
        return Hub(link)
    except BaseException:
        link.close()
        raise


def _name_of_program() -> str:
    return os.path.basename(sys.argv[0] if sys.argv else "") or "python"


def _end_all() -> None:
    """At the process's end: threads that still wait for their hub need no error any more."""
    for engine in list(_RUNNING):
        engine.close(tell=False)


_RUNNING: set[Engine] = set()
_COMMON = _Common()
atexit.register(_end_all)
