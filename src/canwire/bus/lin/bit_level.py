"""All stations of a LIN bus on one wire, bit by bit: for everything but plain frames.

Each station keeps its own time; the wire is low while any station drives it low. Collisions, two masters, bit rates
that disagree, wake-up pulses and shorts need no special rules here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from canwire.bus.lin.node import LinNode
from canwire.bus.lin.station import LinStation
from canwire.bus.lin.wire import NO_RESPONSE, Wire
from canwire.timeline import NEVER

FREE = -1


class LinBitLevel:
    """`level` is the wire's level, `shorted` a level that it is forced to (FREE: none).

    `capture` gets every change as (time in ps, level). `now_ps` is the time up to which it has run, `busy_ps` how long
    a node has been sending, or the level low, so far.
    """

    def __init__(self) -> None:
        self.wire = Wire()
        self.stations: list[LinStation] = []
        self.level = 1
        self.shorted = FREE
        self.capture: Callable[[int, int], None] | None = None
        self.last_edge_ps = 0
        self.busy_ps = 0
        self._fell_ps = -1
        self.now_ps = 0

    def begin(self, nodes: Iterable[LinNode], at_ps: int) -> None:
        """Start with these nodes at rest."""
        self.now_ps = at_ps
        self.wire.planned = NO_RESPONSE
        self.stations = [LinStation(node, self.wire, at_ps) for node in nodes]

    def refresh(self, nodes: Iterable[LinNode], at_ps: int) -> None:
        """Update the stations after nodes were attached, detached, fell asleep or woke up."""
        self.pass_to(at_ps)
        there = {station.node: station for station in self.stations}
        wanted = list(nodes)
        for node, station in there.items():
            if node not in wanted:
                station.leave()
        self.stations = [there.get(node) or LinStation(node, self.wire, at_ps) for node in wanted]
        for station in self.stations:
            station.obey(at_ps)
        self._settle(at_ps)

    def station(self, node: LinNode) -> LinStation | None:
        return next((station for station in self.stations if station.node is node), None)

    def request(self, at_ps: int) -> None:
        """Start every node that has something to send and finds the wire free."""
        self.pass_to(at_ps)
        for station in self.stations:
            offer = station.node.offer
            if offer is not None and station.offer is None and station.at_rest() and self._is_free(at_ps):
                station.begin(offer, at_ps)

    def waiting(self) -> list[LinNode]:
        """The nodes that have something to send and have not begun."""
        return [
            station.node
            for station in self.stations
            if station.node.offer is not None and station.offer is None
        ]

    def next_ps(self) -> int:
        next_ps = NEVER
        for station in self.stations:  # not min(): this is asked at each bit
            if station.sender.due_ps < next_ps:
                next_ps = station.sender.due_ps
            if station.receiver.due_ps < next_ps:
                next_ps = station.receiver.due_ps
        return next_ps

    def step(self) -> None:
        """Do everything that is due at the next moment."""
        at_ps = self.next_ps()
        self.pass_to(at_ps)
        while True:
            senders, readers = [], []
            for station in self.stations:
                if station.sender.due_ps <= at_ps:
                    senders.append(station)
                elif station.receiver.due_ps <= at_ps:
                    readers.append(station)
            if not (senders or readers):
                break
            for station in senders or readers:
                station.act(self.level, at_ps)
            self._settle(at_ps)

    def pass_to(self, at_ps: int) -> None:
        """Advance the time to `at_ps`, without any event."""
        if at_ps > self.now_ps:
            if self.busy():
                self.busy_ps += at_ps - self.now_ps
            self.now_ps = at_ps

    def short(self, level: int, at_ps: int) -> None:
        """Force the wire to a level, or FREE it."""
        self.pass_to(at_ps)
        self.shorted = level
        self._settle(at_ps)

    def busy(self) -> bool:
        """True if a node sends, or the wire is low."""
        if self.level == 0:
            return True
        for station in self.stations:  # not any(): this is asked at each bit
            if station.sender.active:
                return True
        return False

    def at_rest(self) -> bool:
        """Whether no node is sending or reading a frame, and no node must wait for a response."""
        if self.level == 0 or self.shorted != FREE:
            return False
        return all(station.at_rest() or station.stands_by() for station in self.stations)

    def _is_free(self, at_ps: int) -> bool:
        return self.level == 1 or self.shorted != FREE or self._fell_ps == at_ps

    def _settle(self, at_ps: int) -> None:
        """Compute the level of the wire; all stations receive a change."""
        level = self.shorted
        if level == FREE:
            level, flipping = 1, False
            for station in self.stations:
                sender = station.sender
                level &= sender.out
                flipping |= sender.flipping
            if flipping:
                level ^= 1
        if level == self.level:
            return
        self.level = level
        self.last_edge_ps = at_ps
        if level == 0:
            self._fell_ps = at_ps
        if self.capture is not None:
            self.capture(at_ps, level)
        for station in self.stations:
            station.receiver.edge(level, at_ps)
