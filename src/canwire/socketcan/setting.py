"""What everything in a server has in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub, WantedMode
    from canwire.socketcan.interfaces import Interfaces
    from canwire.socketcan.loop import Loop
    from canwire.socketcan.table import Table


class Setting:
    """The hub, the loop, the table; `say` puts one line in front of people, `epoch_ns` makes hub time the wall's."""

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
        self.deserted: Callable[[], object] = lambda: None  # a socket has lost its last program
        self.stir: Callable[[], object] = lambda: None  # there is something for a program, or room

    def gather_s(self, seconds: float) -> float:
        """How long to wait for more frames before looking again; not at all where programs keep one time."""
        return 0.0 if self.timed else seconds
