"""A hub in the process and time of a lab: through it, code for other interfaces uses the buses of the lab."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import partial

from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BusConfig
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.errors import HubLost
from canwire.held_time import HeldTime
from canwire.hub.handles.hub import Hub
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.bench import Bench
from canwire.hub.owner.engine import REAL, VIRTUAL, Engine
from canwire.hub.owner.pace import BenchPace
from canwire.hub.owner.world import World
from canwire.lab.can.bus import LabBus
from canwire.lab.lin.bus import LabLinBus
from canwire.pacing import Pacer
from canwire.timeline import Timeline


class LabHub:
    """`handle` is the connection to the hub. It has no boards at first; `add` makes new buses known to it."""

    def __init__(self, timeline: Timeline, held: HeldTime, pacer: Pacer | None) -> None:
        self._wires: dict[str, CanBus | LinBus] = {}
        self._faults: dict[str, Faults | LinFaults] = {}
        bench = Bench(timeline, held, self._wires, self._faults)
        if pacer is None:
            self._world = World(Config(), virtual=True, bench=bench)
            self._engine = Engine(self._world, VIRTUAL)
        else:
            with pacer.holding():
                self._world = World(Config(), bench=bench)
            self._engine = Engine(self._world, REAL, BenchPace(self._world, pacer))
        self.handle = Hub(LocalLink(self._engine, "lab"))

    def add(self, buses: Mapping[str, LabBus | LabLinBus]) -> None:
        """Add the buses that the hub does not know yet."""
        for name, bus in buses.items():
            if name not in self._wires:
                self._wires[name], self._faults[name] = bus.wire, bus.faults
                known = BusConfig(name=name, type="can" if isinstance(bus, LabBus) else "lin")
                self._engine.call(partial(self._world.add_bus, known))

    def kick(self) -> None:
        """Send what programs have queued, before time passes."""
        with suppress(HubLost):
            self._engine.call(self._world.kick_all)

    def close(self) -> None:
        """End the hub: its boards leave the buses, and its handles raise HubLost from now on."""
        with suppress(HubLost):
            self._engine.call(self._unplug)
        self.handle.close()
        self._engine.close()

    def _unplug(self) -> None:
        for info in self._world.infos():
            self._world.unplug(info.hardware_id)
