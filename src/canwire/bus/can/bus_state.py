"""The state of a bus, readable at any moment, even in the middle of a bit.

bus.py changes the state. The values read here are the same for frames processed whole and bit by bit.
"""

from __future__ import annotations

from functools import partial

from canwire.bus.can.bit_level import BitLevel
from canwire.bus.can.joining import Joining
from canwire.bus.can.node import FAILED, QUIET, Bus, Mailbox, Node
from canwire.bus.can.stepped import SteppedFrame
from canwire.bus.load import BusLoad
from canwire.timeline import Timeline

REST, SENDING, BITWISE, ERRING = range(4)
_REST, _SENDING, _BITWISE, _ERRING = REST, SENDING, BITWISE, ERRING
_FAILED, _QUIET = FAILED, QUIET
_INTERMISSION = 3


class BusState(Bus):
    """REST between frames, SENDING one as a whole, ERRING after one without an acknowledge, or BITWISE.

    At REST the bus is free from `_free_ns` and `_free_ps` on, which may be in the future: the intermission is part of
    REST. `load` is complete up to `_busy_from_ns`; the busy time from there on, at REST up to `_free_ns`, is missing.
    """

    def __init__(self, timeline: Timeline) -> None:
        self.timeline = timeline
        self.nodes: list[Node] = []
        self.load = BusLoad()
        self.bits = BitLevel()
        self.tally = self.bits.tally
        self._state = _REST
        self._free_ns = 0
        self._free_ps = 0
        self._start_ns = 0
        self._busy_since_ns = 0
        self._busy_from_ns = 0
        self._pause_ns = 0
        self._end_ns = 0
        self._end_ps = 0
        self._inside = SteppedFrame()
        self._joining = Joining(self.nodes)
        self._nobody = Node()
        self._sender = self._nobody
        self._box = Mailbox()
        self._first: Node | None = None
        self._rivals = 0

    def on_wire(self, node: Node) -> bool:
        """Whether this node has been the sender since SOF, or still takes part in arbitration."""
        if self._state == _SENDING:
            return self._look_inside().transmits(node, self.timeline.now_ns)
        if self._state == _ERRING:
            return node is self._sender and self._look_inside().fails(self.timeline.now_ns)
        return self._state == _BITWISE and self.bits.transmits(node)

    def activity(self, node: Node) -> int:
        now_ns = self.timeline.now_ns
        if not node.on_bus:
            return _QUIET
        if self._state == _BITWISE:
            return self.bits.activity(node)
        if self._state == _SENDING:
            return self._look_inside().activity(node, now_ns)
        if self._sender is self._nobody or (self._state == _REST and now_ns >= self._free_ns):
            return _QUIET
        inside = self._look_inside()
        if self._state == _ERRING and inside.fails(now_ns):
            return _FAILED
        return inside.activity_behind(node, now_ns)

    def catch_up(self, node: Node) -> None:
        if self._state == _SENDING and node.contending is not None:
            self._look_inside().catch_up(node, self.timeline.now_ns)

    def recessive_groups(self, node: Node) -> int:
        if self._state == _REST and node.waiting:
            return self._joining.groups(node, self.timeline.now_ns, 0)
        return node.sequences

    def resting(self) -> bool:
        """Whether the wire is idle."""
        return self.idle()

    def idle(self) -> bool:
        return self._state == _REST and self.timeline.now_ns >= self._free_ns

    def account(self) -> BusLoad:
        """The load, which includes the frame on the wire or the intermission after it, up to this moment."""
        upto_ns = self.timeline.now_ns
        if self._state == _REST and upto_ns > self._free_ns:
            upto_ns = self._free_ns
        if upto_ns > self._busy_from_ns:
            self.load.add(self._busy_from_ns, upto_ns)
            self._busy_from_ns = upto_ns
        return self.load

    def busy_ns(self) -> int:
        """The busy time of the bus up to now, in ns."""
        return self.account().busy_ns

    def busy_since_ns(self) -> int:
        """The time in ns since which the bus has not rested: this moment while it rests, even if a frame waits."""
        now_ns = self.timeline.now_ns
        rests = self._state == _REST and now_ns > self._free_ns + self._pause_ns
        return now_ns if rests else self._busy_since_ns

    def _look_inside(self) -> SteppedFrame:
        """The frame on the wire, or the last one if there is none."""
        inside = self._inside
        inside.take(self._start_ns, self._free_ps, self._end_ps, self._sender, self._box)
        inside.first = self._first
        if self._state == _REST:
            inside.end_ps += _INTERMISSION * self._sender.bit_ps
        return inside

    def _contend(self) -> None:
        """Mark the frames on the wire as visible; arbitration losses are counted at the losing bit."""
        node = self._first
        while node is not None:
            if node.contends:
                node.contends = False
                node.contending = node.offer
                if node is not self._sender:
                    node.arbitration_losses -= 1
                    self._rivals += 1
            node = node.next_member

    def _begin_late(self, start_ns: int) -> None:
        """Note that the bus rested until this SOF, even if only for a moment."""
        if self._free_ns > self._busy_from_ns:
            self.load.add(self._busy_from_ns, self._free_ns)
        self._busy_from_ns = start_ns
        self._free_ps = 0
        if start_ns > self._free_ns + self._pause_ns:
            self._busy_since_ns = start_ns

    def _forget_contenders(self) -> None:
        for node in self.nodes:
            if node.contending is not None:
                node.contending = None

    def _rouse(self, at_ns: int) -> None:
        """Wake the sleeping nodes at this time, before anything else happens on the bus."""
        for node in self.nodes:
            if node.asleep:
                self.timeline.at(at_ns, partial(node.woken, at_ns))

    def _elapsed_ps(self) -> int:
        if self.timeline.now_ns <= self.bits.origin_ns:
            return 0
        return (self.timeline.now_ns - self.bits.origin_ns) * 1000 - self.bits.origin_ps
