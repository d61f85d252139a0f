# cython: nonecheck=False
"""The bit level of a CAN bus: every node's clock, sample point and level, edge by edge.

bus.py skips over undisturbed frames in one step. All else happens here: errors, collisions, injected faults, clocks
that disagree, cables that are too long. Each node lives in its own bit time, is synchronised by the edges it sees,
and samples the wired AND of all levels (others' levels arrive `delay_ps` late). Times are picoseconds since
`enter`.

Source: ISO 11898-1:2015 chapter 11.3 (bit timing and synchronisation); reference/can-protocol.md section 8.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.bus.can import phases
from canwire.bus.can.clock import Clock
from canwire.bus.can.coasting import Stretch
from canwire.bus.can.drifting import Apart
from canwire.bus.can.node import QUIET, Node
from canwire.bus.can.station import FRAME, IDLE, SUSPEND, WAITING, Station
from canwire.bus.can.stimulus import FREE, Stimulus
from canwire.bus.can.tally import Tally
from canwire.timeline import NEVER

_FRAME, _IDLE, _SUSPEND, _WAITING = FRAME, IDLE, SUSPEND, WAITING
_NEVER, _QUIET, _FREE = NEVER, QUIET, FREE
_FAR_NS, _MOST = 1 << 40, 1 << 20  # beyond any stretch of time; bits in one step

EVERYBODY, RECEIVERS, SENDER, ONE_NODE = range(4)  # which nodes see a disturbed bit


class BitLevel:
    """Runs the stations of one bus until all of them rest.

    `delay_ps` is the one-way delay between any two nodes. `shorted` holds the bus dominant. `capture`
    is called with (time in ps, level) at every change, unless `capture_many` gets those of many bits together: their
    times in ns, and the level after the first of them. `disturb` is called at the start of each bit that the
    sender drives: it returns which nodes see that bit inverted, or -1. `undisturbed` means that this bit has passed
    already without a disturbance. `spare` is called in advance: it returns how many of the sender's next bits, up to a
    given number, no node will see inverted, and counts them as passed. Both are None if nothing can be disturbed.
    `sender_seen` and `index_seen` are the node and the index of the last bit for which `disturb` was or would have been
    called. `coasts` allows many bits in one step; `aligned` means that no clock prevents that. `watch` is called with
    each clock whose next bit has just begun. A bus that is `pinned` does not rest. `halfway` means that the last step
    was only the end of a frame, and the same instant has another one.
    """

    def __cinit__(self) -> None:
        """Compiled: nothing that C reads is None, not even in what was never initialised."""
        self._take_parts()

    def __init__(self) -> None:
        self._take_parts()
        self.origin_ns = self.origin_ps = self.now_ps = self.delay_ps = 0
        self.shorted = self.undisturbed = self.aligned = self.pinned = self.halfway = False
        self.capture: Callable[[int, int], None] | None = None
        self.capture_many: Callable[[list[int], int], None] | None = None
        self.disturb: Callable[[Node, int], int] | None = None
        self.spare: Callable[[Node, int, int], int] | None = None
        self.watch: Callable[[Clock, int], None] | None = None
        self.coasts = True
        self.victim: Node | None = None
        self.sender_seen: Node | None = None
        self.index_seen = 0
        self._drifts = self._stepping = self._forcing = self._driven = False
        self._latest: Clock | None = None  # of those that are aligned, whose sample point comes last
        self._wire = self._shown = 1
        self._forced, self._change_ps = _FREE, _NEVER
        self._flip_sender: Clock | None = None
        self._flip = self._asked_ps = self._fell_ps = -1

    def _take_parts(self) -> None:
        self.tally = Tally()
        self.clocks: list[Clock] = []
        self._known: list[Clock] = []  # of when the bus was here last
        self.stimuli: list[Stimulus] = []
        self._stretch = Stretch()
        self._apart = Apart()

    def enter(self, nodes: list[Node], origin_ns: int, origin_ps: int) -> None:
        """Start the bit level at an instant when the bus is idle and every node is at a bit boundary."""
        self.origin_ns, self.origin_ps, self.now_ps, self._wire = origin_ns, origin_ps, 0, 1
        self._drifts = self.tally.erring = False
        self._flip = self._asked_ps = self._fell_ps = -1
        self._flip_sender = None
        self.clocks, self._known = self._known, []
        if [clock.node for clock in self.clocks] != nodes:
            self.clocks = [Clock(Station(node, self.tally), 0) for node in nodes]
        for clock in self.clocks:
            clock.station.begin()
            clock.begin(0)
            self._take_in(clock, 0)

    def add(self, node: Node, at_ps: int) -> None:
        """Add a node at this time; `on_bus` and `waiting` of the node determine its first state."""
        clock = Clock(Station(node, self.tally), at_ps)
        if at_ps != 0:
            clock.station.contending = None
        self.clocks.append(clock)
        self._take_in(clock, at_ps)

    def _take_in(self, clock: Clock, at_ps: int) -> None:
        first, node, station = self.clocks[0], clock.node, clock.station
        station.now_ns = self.origin_ns if at_ps == 0 else self.at_ns(at_ps)
        station.counted = at_ps == 0 and node.counted_ns == self.origin_ns
        station.stored = at_ps == 0 and node.stored_ns == self.origin_ns
        if node.bit_ps != first.node.bit_ps:
            self._drifts = True
        if self._forcing:
            self._change_ps = min(self._change_ps, at_ps)  # it sees what is forced already

    def refresh(self, nodes: list[Node], at_ps: int) -> None:
        """Update the stations after nodes were attached, detached, started or stopped."""
        self.aligned = False
        self.now_ps = max(self.now_ps, at_ps)
        # in the middle of a step, nodes that have just left the bus drive their bit to its end
        kept = [clock for clock in self.clocks if self._stepping or clock.node in nodes]
        known = [clock.node for clock in kept]
        self.clocks = kept
        for clock in kept:
            node = clock.node
            if not node.on_bus and clock.station.state != _WAITING:
                clock.go_off(self.now_ps, self._stepping)
            if node.waiting and node.waiting_from_ns == self.at_ns(self.now_ps):
                clock.count_from(self.now_ps)
        self._drifts = any(clock.node.bit_ps != kept[0].node.bit_ps for clock in kept)
        for node in nodes:
            if node not in known:
                self.add(node, self.now_ps)
        if not self._stepping:
            self._settle(self.now_ps)

    def stimulate(self, stimulus: Stimulus, at_ps: int) -> None:
        """Force levels at nodes' receivers, from now (`at_ps`) on at the earliest."""
        if not self._forcing:
            self._forcing = True
            for clock in self.clocks:
                clock.seen = self._undisturbed_level(clock, self.now_ps)
                clock.free = True
        self.stimuli.append(stimulus)
        self._change_ps = min(self._change_ps, max(at_ps, stimulus.next_ps - self.offset_ps()))

    def offset_ps(self) -> int:
        """The time from the start of the timeline to `enter`."""
        return self.origin_ns * 1000 + self.origin_ps

    def at_ns(self, at_ps: int) -> int:
        return self.origin_ns + (self.origin_ps + at_ps) // 1000

    def remainder_ps(self) -> int:
        return (self.origin_ps + self.now_ps) % 1000

    def next_ps(self) -> int:
        soonest = self._change_ps
        for clock in self.clocks:
            soonest = min(soonest, clock.due_ps, clock.edge_ps, clock.check_ps)
            if clock.node.sample_gap_ps:
                soonest = min(soonest, clock.next_ps(self.now_ps))
        return soonest

    def transmits(self, node: Node) -> bool:
        """Whether this node sends a frame, or an error flag that ends its own frame."""
        return any(clock.node is node and clock.station.transmits() for clock in self.clocks)

    def activity(self, node: Node) -> int:
        """The same as Bus.activity."""
        for clock in self.clocks:
            if clock.node is node:
                return clock.station.activity()
        return _QUIET

    def coast(self, limit_ns: int) -> bool:
        """Process in one step a stretch of bits in which no node reports anything; False if none begins here.

        `now_ps` is then the last sample point in the stretch of the node that samples last; it is not after `limit_ns`.
        """
        if not self.coasts or not self.clocks or self._forcing or self.watch is not None:
            return False
        first = self.clocks[0]
        if self.delay_ps or self.shorted or self._forced != _FREE or (first.sampling and not self._drifts):
            return False
        if not self.aligned:
            latest_ps = -1
            for clock in self.clocks:
                if not clock.coasts_with(first):
                    return self._drifts and self._coast_apart(limit_ns)
                sample_ps = clock.node.data_sample_ps if clock.data_rate else clock.node.sample_ps
                if sample_ps > latest_ps:
                    self._latest, latest_ps = clock, sample_ps
            self.aligned = True
        if first.station.finished:
            return False
        assert self._latest is not None
        most = self._bits_until(limit_ns, self._latest)
        bits = self._stretch.look(self.clocks, most, self._wire == 1, self.at_ns(first.due_ps))
        if bits > 0:
            bits = self._calm(self._stretch, bits)
        if bits > 0:
            self._pass(self._stretch, self._latest, bits)
        return bits > 0

    def _coast_apart(self, limit_ns: int) -> bool:
        """`coast` for clocks that are not aligned: each is followed separately, at most up to `limit_ns`."""
        apart = self._apart
        if self._flip >= 0 or apart.is_inside_bit():
            return False
        bits = apart.look_apart(self.clocks, self._wire, self._end_ps(limit_ns), self.disturb is None)
        if bits > 0 and self.disturb is not None:
            bits = apart.cut(self.clocks, self._calm(apart, bits))
        if bits > 0 and apart.lead is not None:
            self._pass(apart, apart.lead, bits)
        return bits > 0

    def _bits_until(self, limit_ns: int, clock: Clock) -> int:
        """The number of further samples of this clock up to `limit_ns`."""
        left_ps = self._end_ps(limit_ns) - clock.due_ps - clock.sample_ps()
        if left_ps <= 0:
            return 0
        bits = (left_ps - 1) // clock.bit_ps() + 1
        return bits if bits < _MOST else _MOST

    def _end_ps(self, limit_ns: int) -> int:
        """The first time in ps after `limit_ns`: all events up to `limit_ns` are before it."""
        if limit_ns <= self.origin_ns:
            return 0
        left_ns = limit_ns - self.origin_ns
        return ((left_ns if left_ns < _FAR_NS else _FAR_NS) + 1) * 1000 - self.origin_ps

    def _calm(self, stretch: Stretch, bits: int) -> int:
        """How many of these bits pass undisturbed; `disturb` must be called for the bit after them."""
        sender = stretch.sender
        if sender is None or self.disturb is None:
            return bits
        return 0 if self.spare is None else self.spare(sender.node, sender.station.index, bits)

    def _pass(self, stretch: Stretch, first: Clock, bits: int) -> None:
        bit_ps, began_ps = first.bit_ps(), first.due_ps
        self._flip = -1
        if self.capture is not None:
            at_ps = self.offset_ps() + began_ps
            stretch.show(bits, at_ps, bit_ps, self._shown, self.capture, self.capture_many)
        fall = stretch.last_fall(self._wire, bits)
        if fall >= 0:
            self._fell_ps = began_ps + fall * bit_ps
        self._wire = self._shown = stretch.level_of(bits - 1)
        last_ps = began_ps + (bits - 1) * bit_ps
        if stretch.sender is not None:
            self._flip_sender, self._asked_ps = stretch.sender, last_ps
            self.sender_seen = stretch.sender.node
            self.index_seen = stretch.sender.station.index + bits - 1
        self.now_ps = stretch.last_ps(began_ps, bits, first)
        stretch.go(self.clocks, bits, began_ps, self.at_ns(self.now_ps))

    def _show(self, wire: int, shown: int, at_ps: int) -> None:
        """Set the undisturbed level of the wire, and the one that is seen on it."""
        if wire == 0 and self._wire == 1:
            self._fell_ps = at_ps
        self._wire = wire
        if shown != self._shown:
            self._shown = shown
            if self.capture is not None:
                self.capture(self.offset_ps() + at_ps, shown)

    def replay(self, now_ns: int) -> None:
        """Run all bits from the start to the present, which have passed without a disturbance: a frame's at most."""
        if now_ns > self.origin_ns + _FAR_NS:
            raise ValueError(f"now_ns {now_ns}: {_FAR_NS} ns at most after the start at {self.origin_ns} ns")
        self.undisturbed = True
        self.aligned = False
        while self.clocks:
            if now_ns > 0 and self.coast(now_ns - 1):
                continue
            at_ps = self.next_ps()
            if self.at_ns(at_ps) >= now_ns:
                break
            self.step_at(at_ps)
        self.undisturbed = False

    def step_at(self, at_ps: int) -> None:
        """Process the instant `at_ps`, which must be the next one: bit boundaries, then edges, then samples."""
        self._stepping = True
        self.halfway = self.aligned and self._deliver(at_ps)
        if not self.halfway:
            self.aligned = False
            self._step(at_ps)
        self._stepping = False

    def _deliver(self, at_ps: int) -> bool:
        """Give all nodes the frame that has just ended, and leave their next bit to another step; else False."""
        for clock in self.clocks:
            if not clock.station.finished or clock.due_ps != at_ps:
                return False
        self.now_ps, at_ns = at_ps, self.at_ns(at_ps)
        for clock in self.clocks:
            clock.station.now_ns = at_ns
            if clock.station.finished and not clock.station.transmitting:
                clock.station.deliver()
        for clock in self.clocks:
            if clock.station.finished:
                clock.station.deliver()  # receivers get a frame before its sender gets the outcome
        return True

    def _step(self, at_ps: int) -> None:
        self.now_ps, at_ns = at_ps, self.at_ns(at_ps)
        self._driven = begun = sent = False
        shown_otherwise = self.shorted or self._flip >= 0
        for clock in self.clocks:
            clock.station.now_ns = at_ns
            if clock.due_ps == at_ps and not clock.sampling:
                begun = True
                if clock.station.finished and clock.station.transmitting:
                    sent = True  # receivers get a frame before its sender gets the outcome
                else:
                    self._begin_bit(clock, at_ps)
        if sent:
            self._begin_bits(at_ps)
        if begun and (shown_otherwise or self._driven):
            self._begin_disturbance()
        if self._change_ps <= at_ps:
            self._force(at_ps)
            self._driven = True
        if self._driven or (begun and shown_otherwise):
            self._settle(at_ps)
        if self._forcing:
            self._look_for_edges(at_ps)
        else:
            for clock in self.clocks:
                if clock.edge_ps <= at_ps:
                    clock.edge_ps = _NEVER
                    clock.edge(at_ps)
        for clock in self.clocks:
            if clock.check_ps <= at_ps:
                clock.check(self._undisturbed_level(clock, at_ps), at_ps)
            if clock.node.sample_gap_ps and clock.looks_before(at_ps):
                clock.look(self._seen_by(clock, at_ps))
            if clock.due_ps == at_ps and clock.sampling:
                clock.station.sample(clock.found(self._seen_by(clock, at_ps)))
                clock.sampled(at_ps)

    def _begin_bits(self, at_ps: int) -> None:
        for clock in self.clocks:
            if clock.due_ps == at_ps and not clock.sampling:
                self._begin_bit(clock, at_ps)

    def _begin_bit(self, clock: Clock, at_ps: int) -> None:
        station, out = clock.station, clock.station.out
        idle = station.state == _IDLE or station.rejoined or (station.state == _SUSPEND and station.left == 0)
        idle = idle and not clock.joins and not station.sof_seen
        if idle and self._dominant_before(clock, at_ps):
            station.sof_seen = True  # whatever became of the edge: no SOF onto a dominant wire
            clock.begin_bit(at_ps)
            station.sof_seen = False
        else:
            clock.begin_bit(at_ps)
        self._driven = self._driven or station.out != out or station.transmitting
        if self.watch is not None:
            self.watch(clock, self.offset_ps() + at_ps)

    def _dominant_before(self, clock: Clock, at_ps: int) -> bool:
        """Whether the last level that the node saw before this instant was dominant."""
        if clock.forced != _FREE:
            return clock.forced == 0
        if self.delay_ps == 0 or self.shorted:
            return self._wire == 0 and self._fell_ps < at_ps
        return self._undisturbed_level(clock, at_ps - 1) == 0

    def resting(self) -> bool:
        """Whether the wire is idle."""
        if self.shorted or self._wire == 0 or self._shown == 0 or self._forcing or self.pinned:
            return False
        common = (
            _NEVER  # where every intermission ends that has not yet ended: no node may send before another
        )
        for clock in self.clocks:
            if not clock.station.resting() or clock.edged or clock.edge_ps != _NEVER:
                return False
            if clock.station.state != _WAITING and not clock.node.listen_only:
                due = clock.due_ps if clock.station.just_free else -1
                if common != _NEVER and due != common:
                    return False
                common = due
        return True

    def leave(self) -> None:
        """Give the nodes what only their stations know: suspend times, and the recessive bits that they counted.

        The bus is free from `now_ps` on: the bit boundary that all nodes are about to reach, or have reached before.
        """
        for clock in self.clocks:
            if clock.station.state == _SUSPEND or clock.station.state == _WAITING:
                phases.hand_back(clock, self.offset_ps())
            if clock.station.just_free and not clock.node.listen_only and clock.due_ps > self.now_ps:
                self.now_ps = clock.due_ps
        self._known, self.clocks = self.clocks, []

    def _settle(self, at_ps: int) -> None:
        """Compute the level of the wire, call `capture` if it changed, and send edges to the clocks."""
        wire = 0 if self.shorted else 1
        for clock in self.clocks:
            wire &= clock.station.out
        shown = wire ^ 1 if self._flip == EVERYBODY else wire
        if self._forced != _FREE:
            shown = self._forced
        falls = wire == 0 and (self._wire == 1 or self.delay_ps)
        self._show(wire, shown, at_ps)
        if falls and self.clocks:
            self._send_edges(at_ps)

    def _send_edges(self, at_ps: int) -> None:
        fallen = 0
        falls = self.clocks[0]
        for clock in self.clocks:
            if self.shorted or (clock.station.out == 0 and clock.echo.changed_at(at_ps)):
                fallen += 1
                falls = clock
        arrives = at_ps if self.shorted else at_ps + self.delay_ps
        for clock in self.clocks:
            # no node sees its own edge, but two see each other's
            sees = self.shorted or fallen > 1 or (fallen == 1 and clock is not falls)
            if sees and arrives < clock.edge_ps:
                clock.edge_ps = arrives

    def _force(self, at_ps: int) -> None:
        """Apply the stimuli; where several force a level, the last one decides."""
        absolute_ps = self.offset_ps() + at_ps
        self._forced = _FREE
        soonest = _NEVER
        for clock in self.clocks:
            clock.forced = _FREE
        for stimulus in self.stimuli:
            stimulus.advance(absolute_ps)
            soonest = min(soonest, stimulus.next_ps)
            if stimulus.level == _FREE:
                continue
            if stimulus.nodes is None:
                self._forced = stimulus.level
            for clock in self.clocks:
                if stimulus.nodes is None or clock.node in stimulus.nodes:
                    clock.forced = stimulus.level
        self.stimuli = [stimulus for stimulus in self.stimuli if not stimulus.over()]
        self._change_ps = soonest - self.offset_ps() if soonest != _NEVER else _NEVER

    def _look_for_edges(self, at_ps: int) -> None:
        """Find the edges that each node sees while levels are forced."""
        for clock in self.clocks:
            arrives = clock.edge_ps <= at_ps
            if arrives:
                clock.edge_ps = _NEVER
            level = self._undisturbed_level(clock, at_ps)
            fell = clock.seen == 1 or (arrives and clock.free)
            clock.seen = level
            clock.free = clock.forced == _FREE
            if level == 0 and fell:
                clock.edge(at_ps)
        if not self.stimuli:
            self._forcing = False

    def _seen_by(self, clock: Clock, at_ps: int) -> int:
        level = self._undisturbed_level(clock, at_ps)
        flipped = self._flip >= 0 and not self.shorted and clock.forced == _FREE
        return level ^ 1 if flipped and self._flipped_for(clock) else level

    def _undisturbed_level(self, clock: Clock, at_ps: int) -> int:
        """The level at a node's receiver, without the inversion of a disturbed bit."""
        if clock.forced != _FREE:
            return clock.forced
        if self.shorted:
            return 0
        if self.delay_ps == 0 and clock.node.loop_ps == 0:
            return self._wire
        level = clock.echo.level_at(at_ps - clock.node.loop_ps)
        for other in self.clocks:
            if other is not clock:
                level &= other.echo.level_at(at_ps - self.delay_ps)
        return level

    def _flipped_for(self, clock: Clock) -> bool:
        if self._flip == EVERYBODY:
            return True
        if self._flip == ONE_NODE:
            return clock.node is self.victim
        return (clock is self._flip_sender) == (self._flip == SENDER)

    def _begin_disturbance(self) -> None:
        """Call `disturb` for the bit that the sender has just begun to drive."""
        sender = self._stretch.first_sender(self.clocks)
        if sender is None:
            driver = self._flip_sender  # an error has ended its frame, but not yet its bit
            if driver is None or driver.start_ps == self.now_ps or driver not in self.clocks:
                self._flip = -1
        elif sender.start_ps == self.now_ps and (
            self._asked_ps != self.now_ps or sender is not self._flip_sender
        ):
            self._asked_ps = self.now_ps  # once, for all clocks that begin a bit now
            self._flip_sender = sender
            index = sender.station.index
            self._flip = -1 if self.disturb is None else self.disturb(sender.node, index)
            self.sender_seen, self.index_seen = sender.node, index
            if self._flip >= 0 and self._flipped_for(sender) and sender.forced == _FREE:
                sender.echo.invert()
