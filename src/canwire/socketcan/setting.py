"""The objects that all parts of a server share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.socketcan.loop import Gathering

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub, WantedMode
    from canwire.socketcan.interfaces import Interfaces
    from canwire.socketcan.loop import Loop
    from canwire.socketcan.table import Table


class Setting:
    """The hub, the loop, the table; `say` shows one line to the user; hub time + `epoch_ns` is ns since 1970."""

    def __init__(
        self,
        hub: Hub,
        loop: Loop,
        table: Table,
        interfaces: Interfaces,
        wanted: WantedMode,
        epoch_ns: int,
        say: Callable[[str], object],
    ) -> None:
        self.hub = hub
        self.loop = loop
        self.table = table
        self.interfaces = interfaces
        self.wanted = wanted
        self.epoch_ns = epoch_ns
        self.fast = hub.time == "fast"
        self.timed = hub.timed
        self.say = say
        self._faults: set[str] = set()
        self.deserted: Callable[[], object] = lambda: None  # a socket has lost its last program
        self.comes_back = False  # the hub is waited for when it is gone: boards/boards.py
        self.hub_gone: Callable[[], object] = lambda: None
        self.came_up: Callable[[], object] = lambda: None  # an interface that was down
        self.stir: Callable[[], object] = lambda: None  # there is something for a program, or room

    def fault(self, where: str, error: Exception) -> None:
        """Report a fault of the server itself, found in a request of this program, once."""
        what = f"{where}: {type(error).__name__}: {error}; this is canwire's own fault, please report it"
        if what not in self._faults:
            self._faults.add(what)
            self.say(what)

    def gathering(self) -> Gathering | None:
        """The Gathering for a reader of frames; None in lockstep, where no reader waits by the clock."""
        return None if self.timed else Gathering(self.loop.clock_s)
