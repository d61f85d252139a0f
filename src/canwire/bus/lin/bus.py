# cython: boundscheck=True
"""The LIN bus: one wire, on which the master sends headers and slaves answer.

A plain frame takes two steps: its header, then its response or the silence in its place. Everything else (two nodes
that answer, two masters, a clock that does not follow, a fault, a sleeping node, a trace of levels) runs bit by bit
in bit_level.py until the bus rests again. Both ways give the same times and events; tests compare them. Times are
picoseconds inside and the nearest nanosecond outside.
Source: LIN 2.2A 2; reference/lin-protocol.md.
"""

from __future__ import annotations

from canwire.bus.lin.bit_level import FREE, LinBitLevel
from canwire.bus.lin.bits import last_edge_bits
from canwire.bus.lin.idle import Idleness
from canwire.bus.lin.node import LinMedium, LinNode, LinOffer, LinResponse
from canwire.bus.lin.station import nanoseconds
from canwire.bus.load import BusLoad
from canwire.timeline import NEVER, Timeline
from canwire.values.lin.frame import protected_id
from canwire.values.lin.timing import (
    BREAK_THRESHOLD_BITS,
    FIELD_BITS,
    IDLE_NS,
    follows,
    longest_response_bits,
)

_REST, _HEADER, _RESPONSE, _SILENCE, _BITWISE = range(5)
_NEVER = NEVER
_PS_A_NS = 1000  # an object in the compiled form, too: after 106 days picoseconds need more than 64 bits
_LONGEST_RESPONSE = longest_response_bits(0)


class LinBus(LinMedium):
    """A wired AND between any number of nodes, on a timeline.

    After `idle_ns` without an edge it calls `quiet` of its nodes (None: never). `bitwise`: always bit by bit.
    """

    def __init__(self, timeline: Timeline, name: str = "", *, idle_ns: int | None = IDLE_NS) -> None:
        self.name = name
        self.timeline = timeline
        self.nodes: list[LinNode] = []
        self.load = BusLoad()
        self.bits = LinBitLevel()
        self.wire = self.bits.wire
        self.bitwise = False
        self._state = _REST
        self._due_ns = _NEVER
        self._running = False
        self._members: list[LinNode] = []
        self._offering: list[LinNode] = []
        self._followed: dict[LinNode, bool] = {}
        self._subscribers: dict[int, list[LinNode]] = {}
        self._drowsy = False
        self._deaf_until_ns = 0
        self._sender = self._owner = LinNode()
        self._offer = LinOffer(0)
        self._response: LinResponse | None = None
        self._phase_ps = 0
        self._end_ps = 0
        self._busy_from_ns = 0
        self._counted_ps = 0
        self._last_octet = (0, 0, 0)
        self._idleness = Idleness(timeline, idle_ns, self.last_edge_ns)
        timeline.add(self)

    # nodes

    def attach(self, node: LinNode) -> None:
        """Put a controller on the wire."""
        self.interrupt()
        node.bus = self
        self.nodes.append(node)
        self.changed()

    def detach(self, node: LinNode) -> None:
        """Disconnect a controller from the wire; the other nodes see its output go recessive at this moment."""
        self.interrupt()
        self.nodes.remove(node)
        node.bus = None
        self.changed()

    def now_ns(self) -> int:
        return self.timeline.now_ns

    def load_percent(self) -> float:
        return self.account().percent(self.timeline.now_ns)

    def poll(self, node: LinNode) -> None:
        if node not in self._offering:
            self._offering.append(node)
        if self._state == _HEADER and self._phase_ps == self.timeline.now_ns * _PS_A_NS:
            self.interrupt()  # two who begin at the same moment
        if self._state == _REST:
            self._due_ns = self.timeline.now_ns
        elif self._state == _BITWISE and not self._running:
            self._request()
        if not self._running:
            self.timeline.interrupted = True

    def changed(self) -> None:
        members = [node for node in self.nodes if node.on_bus]
        self._members = members
        self._offering = [node for node in self._offering if node in members]
        self._followed = {}
        self._drowsy = bool([node for node in members if node.asleep or node.searching])
        self._deaf_until_ns = max([node.ready_ns for node in members], default=0)
        self._subscribers = {}
        for node in members:
            for id, length in enumerate(node.lengths):
                if length:
                    self._subscribers.setdefault(id, []).append(node)
        if self._state == _BITWISE:
            self.bits.refresh(members, self._now_ps())
            if not self._running:
                self._go_on()
        self._idleness.watch(members)
        self.timeline.interrupted = True

    def on_wire(self, node: LinNode) -> bool:
        if self._state == _BITWISE:
            station = self.bits.station(node)
            return station is not None and (station.offer is not None or station.sender.active)
        sending = self._state != _REST and node is self._sender
        return sending or (self._state == _RESPONSE and node is self._owner)

    def resting(self) -> bool:
        """Whether the wire is idle and no node waits for a response."""
        return self._state == _REST

    def short(self, level: int) -> None:
        """Short the wire to ground (0) or to the supply (1), or remove the short (FREE)."""
        self.interrupt()
        if self._state == _REST:
            self._go_bitwise(self._now_ps())
        self.bits.short(level, self._now_ps())
        self._go_on()
        self.timeline.interrupted = True

    def interrupt(self) -> None:
        """Change to the bit level in the middle of a frame, so that a change takes effect at the present bit."""
        if self._state in (_HEADER, _RESPONSE, _SILENCE):
            disturber, self.wire.disturber = self.wire.disturber, None  # it did not concern what has begun
            self._take_apart()
            self.wire.disturber = disturber
            while (next_ps := self.bits.next_ps()) < self._end_ps:
                if nanoseconds(next_ps) > self.timeline.now_ns:
                    break
                self.bits.step()
            self._schedule()

    # load and idleness

    def account(self) -> BusLoad:
        """The load, with the frame on the wire counted up to this moment."""
        now_ns = self.timeline.now_ns
        if self._state == _BITWISE:
            self.bits.pass_to(self._now_ps())
            self._count_bits()
        elif self._state in (_HEADER, _RESPONSE) and now_ns > self._busy_from_ns:
            self.load.add(self._busy_from_ns, now_ns)
            self._busy_from_ns = now_ns
        return self.load

    def busy_ns(self) -> int:
        """The busy time of the bus up to now, in ns."""
        return self.account().busy_ns

    def last_edge_ns(self) -> int:
        """When the level of the wire last changed; this moment while a plain frame is on it."""
        if self._state in (_HEADER, _RESPONSE):
            return self.timeline.now_ns
        end_ps, octet, bit_ps = self._last_octet
        last_ps = end_ps - (FIELD_BITS - last_edge_bits(octet)) * bit_ps if end_ps else 0
        return nanoseconds(max(self.bits.last_edge_ps, last_ps))

    # the timeline's side

    def next_ns(self) -> int:
        return self._due_ns

    def wake_ns(self) -> int:
        """When a program can next see an event: the end of a header counts only together with the response after it."""
        if self._state != _HEADER:
            return self._due_ns
        found = self._foreseen(self._offer.id)
        return (
            self._due_ns
            if found is None
            else (self._end_ps + found.bits * self._sender.bit_ps + 500) // _PS_A_NS
        )

    def foreseen_ns(self, sender: LinNode, id: int) -> int:
        """The same as `LinMedium.foreseen_ns`."""
        found = self._foreseen(id)
        return 0 if found is None else ((sender.header_bits + found.bits) * sender.bit_ps + 500) // _PS_A_NS

    def _foreseen(self, id: int) -> LinResponse | None:
        """The response to this identifier, if exactly one node has one; else None."""
        found = None
        for node in self._members:
            response = node.responses[id]
            if response is not None:
                if found is not None:
                    return None
                found = response
        return found

    def run(self, limit_ns: int) -> None:
        timeline = self.timeline
        self._running = True
        try:
            while not timeline.interrupted and self._due_ns <= limit_ns:
                timeline.now_ns = self._due_ns
                state = self._state
                if state == _HEADER:
                    self._answer()
                elif state == _RESPONSE:
                    self._deliver()
                elif state == _REST:
                    self._begin()
                elif state == _SILENCE:
                    self._expire()
                else:
                    self._step()
        finally:
            self._running = False

    # plain frames

    def _begin(self) -> None:
        """Start the nodes that have something to send."""
        now_ns = self.timeline.now_ns
        waiting, self._offering = self._offering, []
        self._due_ns = _NEVER
        if len(waiting) != 1 or waiting[0].offer is None:
            waiting = [node for node in waiting if node.offer is not None]
            if not waiting:
                return
        sender = waiting[0]
        offer = sender.offer
        assert offer is not None
        if len(waiting) > 1 or not self._is_plain(sender, offer):
            self._go_bitwise(now_ns * _PS_A_NS)
            self._request()
            return
        self._sender, self._offer = sender, offer
        self._phase_ps = now_ns * _PS_A_NS
        self._busy_from_ns = now_ns
        self._end_ps = self._phase_ps + sender.header_bits * sender.bit_ps
        self._state = _HEADER
        self._due_ns = (self._end_ps + 500) // _PS_A_NS

    def _is_plain(self, sender: LinNode, offer: LinOffer) -> bool:
        if offer.wake_up or self.bitwise or self._drowsy or self._deaf_until_ns > self.timeline.now_ns:
            return False
        disturber = self.wire.disturber
        if disturber is not None and disturber.concerns(offer.id):
            return False
        followed = self._followed.get(sender)
        if followed is None:
            followed = not [
                node for node in self._members if node is not sender and not _keeps_up(node, sender)
            ]
            self._followed[sender] = followed
        return followed

    def _answer(self) -> None:
        """End the header: find the nodes that answer, and start the response or the silence."""
        offer, sender = self._offer, self._sender
        id, own = offer.id, offer.response
        owner, found, rivals = sender, own, False
        for node in self._members:
            node.headers += 1
            response = node.responses[id]
            if response is not None and (own is None or node is not sender):
                rivals = rivals or found is not None
                owner, found = node, response
        self._owner, self._response = owner, found
        self._phase_ps = self._end_ps
        if rivals:
            self._response = None
        disturber = self.wire.disturber
        disturbed = disturber is not None and disturber.concerns(id)
        if rivals or disturbed or (id in self._subscribers and not self._is_expected(id, found)):
            self._state = _RESPONSE
            self._take_apart()
            self._schedule()
        elif found is None:
            self._fall_silent()
        else:
            self._state = _RESPONSE
            self._end_ps += found.bits * sender.bit_ps
            self._due_ns = (self._end_ps + 500) // _PS_A_NS
            if found.bits > _LONGEST_RESPONSE or (own is None and offer.length and self._misses(found)):
                self._take_apart()
                self._schedule()

    def _deliver(self) -> None:
        """End the response: report it to its sender and to the other nodes."""
        owner, response, sender = self._owner, self._response, self._sender
        assert response is not None
        at_ns = self.timeline.now_ns
        self.load.add(self._busy_from_ns, at_ns)
        self._last_octet = (self._end_ps, response.octets[response.length], sender.bit_ps)
        self._state = _REST
        self._due_ns = at_ns if self._offering else _NEVER
        for node in self._members:
            if node is owner:
                node.transmitted(response, at_ns)
            elif node.on_bus:
                node.received(response, at_ns)
        wire = self.wire
        wire.frames += 1
        if wire.tap is not None:
            wire.tap.transmitted(owner, response, at_ns)
        sender.finished(self._offer, at_ns)

    def _fall_silent(self) -> None:
        offer, sender = self._offer, self._sender
        self.load.add(self._busy_from_ns, self.timeline.now_ns)
        self._busy_from_ns = self.timeline.now_ns
        self._last_octet = (self._end_ps, protected_id(offer.id), sender.bit_ps)
        self._end_ps += longest_response_bits(offer.length) * sender.bit_ps
        self._state = _SILENCE
        self._due_ns = (self._end_ps + 500) // _PS_A_NS

    def _expire(self) -> None:
        """End the silence: no node answered in time."""
        offer, sender = self._offer, self._sender
        at_ns = self.timeline.now_ns
        self._rest()
        for node in self._members:
            if node is sender or node.lengths[offer.id]:
                node.unanswered(offer.id, 0, at_ns)
        sender.finished(offer, at_ns)

    def _is_expected(self, id: int, response: LinResponse | None) -> bool:
        """Whether all subscribers expect this length; in silence, whether they expect the length that the master
        expects.
        """
        for node in self._subscribers[id]:
            length = node.lengths[id]
            if response is None:
                if node is not self._sender and length != self._offer.length:
                    return False
            elif length != response.length or response.bits > longest_response_bits(length):
                return False
        return True

    def _misses(self, response: LinResponse) -> bool:
        """Whether the sender of the header expects another length, or an earlier end of the response."""
        length = self._offer.length
        return length != response.length or response.bits > longest_response_bits(length)

    def _rest(self) -> None:
        self._state = _REST
        self._due_ns = self.timeline.now_ns if self._offering else _NEVER

    # bit by bit

    def _now_ps(self) -> int:
        """The present time in ps; the bit level may be less than a nanosecond ahead of the timeline."""
        return max(self.timeline.now_ns * _PS_A_NS, self.bits.now_ps)

    def _go_bitwise(self, at_ps: int) -> None:
        self._state = _BITWISE
        self.bits.begin(self._members, at_ps)

    def _take_apart(self) -> None:
        """Continue the present frame at the bit level, from the beginning of its present half."""
        state, began_ns = self._state, nanoseconds(self._phase_ps)
        if state == _RESPONSE and began_ns > self._busy_from_ns:
            self.load.add(self._busy_from_ns, began_ns)
            self._busy_from_ns = began_ns
        self._go_bitwise(self._phase_ps)
        self._counted_ps += max(0, self._busy_from_ns * _PS_A_NS - self._phase_ps)
        if state == _HEADER:
            station = self.bits.station(self._sender)
            assert station is not None
            station.begin(self._offer, self._phase_ps)
            return
        for station in self.bits.stations:
            node = station.node
            offer = self._offer if node is self._sender else None
            bit_ps = self._sender.bit_ps if node.synchronises else node.bit_ps
            own = self._response_of(node) if state == _RESPONSE else None
            station.enter(self._offer.id, offer, own, bit_ps, self._phase_ps)

    def _response_of(self, node: LinNode) -> LinResponse | None:
        """The node's answer to the present header; if several nodes answer, the response that each had at that time."""
        if self._response is not None:
            return self._response if node is self._owner else None
        if node is self._sender and self._offer.response is not None:
            return self._offer.response
        return node.responses[self._offer.id]

    def _step(self) -> None:
        self.bits.step()
        self._go_on()

    def _go_on(self) -> None:
        """Return to plain frames once the bit level rests; then the nodes that wait for a free wire begin."""
        self._count_bits()
        if self.bits.at_rest():
            self._offering = [node for node in self._members if node.offer is not None]
            self._rest()
        elif self._offering:
            self._request()
        else:
            self._schedule()

    def _request(self) -> None:
        self.bits.request(self._now_ps())
        waiting = self.bits.waiting()
        self._offering = [node for node in self._offering if node in waiting]
        self._schedule()

    def _schedule(self) -> None:
        next_ps = self.bits.next_ps()
        self._due_ns = NEVER if next_ps >= NEVER else max(nanoseconds(next_ps), self.timeline.now_ns)

    def _count_bits(self) -> None:
        """Add the busy time of the bit level since the last call."""
        spent_ns = (self.bits.busy_ps - self._counted_ps) // _PS_A_NS
        if spent_ns > 0:
            now_ns = self.timeline.now_ns
            self.load.add(now_ns - spent_ns, now_ns)
            self._counted_ps += spent_ns * _PS_A_NS


def _keeps_up(node: LinNode, sender: LinNode) -> bool:
    """Whether the node reads all frames of this sender, and answers at the same bit rate."""
    if sender.break_bits * sender.bit_ps < BREAK_THRESHOLD_BITS * node.bit_ps:
        return False
    return node.bit_ps == sender.bit_ps or (node.synchronises and follows(node.bit_ps, sender.bit_ps))


__all__ = ["FREE", "LinBus"]
