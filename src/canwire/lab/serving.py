"""Shares the buses of a lab with other programs: a hub whose boards are on these buses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial

from canwire.boards import catalogue
from canwire.boards.board import CAN
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BusConfig
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.errors import HubLost
from canwire.held_time import HeldTime
from canwire.hub.links.answering import Server
from canwire.hub.owner.bench import Bench
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.pace import BenchPace
from canwire.hub.owner.world import World
from canwire.hub.usual import default_address
from canwire.lab.can.bus import LabBus
from canwire.lab.lin.bus import LabLinBus
from canwire.pacing import Pacer
from canwire.timeline import Timeline


class Serving:
    """A hub at `address` with boards of these kinds, until `close`; raises NoSuchBoard, HubError."""

    def __init__(
        self,
        pacer: Pacer,
        timeline: Timeline,
        buses: Mapping[str, LabBus],
        lin_buses: Mapping[str, LabLinBus],
        address: str | None,
        boards: Sequence[str],
    ) -> None:
        wires: dict[str, CanBus | LinBus] = {name: bus.wire for name, bus in buses.items()}
        wires |= {name: bus.wire for name, bus in lin_buses.items()}
        faults: dict[str, Faults | LinFaults] = {name: bus.faults for name, bus in buses.items()}
        faults |= {name: bus.faults for name, bus in lin_buses.items()}
        rates = [BusConfig(name=name, bit_rate=bus.timing.bit_rate) for name, bus in buses.items()]
        slow = [BusConfig(name=name, type="lin") for name in lin_buses]
        with pacer.holding():
            self._world = World(Config(bus=(*rates, *slow)), bench=Bench(timeline, HeldTime(), wires, faults))
        self._engine = Engine(self._world, pace=BenchPace(self._world, pacer))
        with ExitStack() as on_failure:
            on_failure.callback(self._engine.close)
            on_failure.callback(self._engine.call, self._unplug)
            for kind in boards:
                self._engine.call(partial(self._plug, kind, next(iter(buses), ""), next(iter(lin_buses), "")))
            self._server = Server(self._engine, default_address() if address is None else address)
            on_failure.pop_all()
        self.address = self._server.path
        pacer.when_failed = lambda: self._engine.post(self._engine.close)  # time no longer passes

    def close(self) -> None:
        """Disconnect all programs, and remove the boards from the buses."""
        with suppress(HubLost):  # it ended by itself
            self._engine.call(self._unplug)
        self._server.close()
        self._engine.close()

    def _plug(self, kind: str, can: str, lin: str) -> None:
        connectors = catalogue.kind(kind).connectors
        self._world.plug(kind, buses=tuple(can if each.bus_type == CAN else lin for each in connectors))

    def _unplug(self) -> None:
        for info in self._world.infos():
            self._world.unplug(info.hardware_id)
