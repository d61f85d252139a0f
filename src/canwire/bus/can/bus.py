"""The CAN bus: arbitration, the length of each frame, and its delivery to receivers.

Each undisturbed frame is processed in one step: arbitration by the lowest key, exact length, delivery. stepped.py
computes what happens inside such a frame, for the nodes that can notice it. Everything else (errors, collisions,
faults, clocks that disagree, a trace of levels) runs bit by bit in bit_level.py until the bus rests again. Both ways
give the same times, counters, events and registers at any moment; tests compare them.
Source: ISO 11898-1:2015; reference/can-protocol.md sections 5 to 8.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.bus.can import bits as can_bits
from canwire.bus.can import node as seam
from canwire.bus.can import phases
from canwire.bus.can.bus_state import BITWISE, ERRING, REST, SENDING, BusState
from canwire.bus.can.in_step import in_step
from canwire.bus.can.node import Mailbox, Node
from canwire.bus.can.stimulus import Stimulus
from canwire.timeline import NEVER, Timeline

_NEVER = NEVER
_ACK_ERROR = 3
_FD = 1 << 10
_NO_RULE, _TRANSMIT_ERROR = seam.NO_RULE, seam.TRANSMIT_ERROR
_NOBODY = 1 << 32
_REST, _SENDING, _BITWISE, _ERRING = REST, SENDING, BITWISE, ERRING
_INTERMISSION = 3
_EOF_END_TO_ACK = 8  # bits from the end of the ACK slot to the end of EOF
_ACK_DELIMITER_TO_EOF_END = 8
_ERROR_FRAME = 14
_ACK_SLOT_TO_FREE = 18  # where nobody filled it: the slot itself, error frame, intermission
_ACK_SLOT = 0x19


class CanBus(BusState):
    """A wired AND between any number of nodes, on a timeline."""

    def __init__(self, timeline: Timeline, name: str = "") -> None:
        super().__init__(timeline)
        self.name = name
        self.collisions = 0
        self.delay_ps = 0
        self.bitwise = False
        self.noise_left = -1  # undisturbed bits before the next one that noise inverts; -1: no noise
        self.scripted: Callable[[Mailbox], bool] | None = None
        self._next_ns = 0
        self._flag_passive, self._slot = False, 0  # of the last frame that nobody acknowledged
        self._sleeping = self._waiting = self._acknowledged = False
        self._members: list[Node] = []
        self._stations: list[Node] = []  # members, and those who wait for the bus: the bit level's
        self._in_step = self._in_step_fd = self._in_step_switching = True
        self._acknowledgers = self._listeners = self._noise_taken = 0
        self._early_ps = 0  # first sample point of the nodes that store a frame before its end; 0: none do
        timeline.add(self)

    def attach(self, node: Node) -> None:
        """Connect a controller to the bus; in the middle of a frame it sees the rest of that frame."""
        self.descend()
        node.bus = self
        if node.waiting_from_ns < self.timeline.now_ns:
            node.waiting_from_ns, node.waiting_from_ps = self.timeline.now_ns, 0
        self.nodes.append(node)
        if node.on_bus or node.waiting or self._state == _BITWISE:
            self.changed()
        else:  # it takes no part yet, so the others need no look, of which thousands of nodes would make millions
            self._sleeping = self._sleeping or node.asleep
            self.timeline.interrupted = True

    def detach(self, node: Node) -> None:
        """Disconnect a controller from the bus; the other nodes see its output go recessive at this moment."""
        self.interrupt()
        self.nodes.remove(node)
        node.bus = node.contending = None
        self.changed()

    def poll(self, node: Node) -> None:
        if self._state == _BITWISE:
            phases.request(self.bits.clocks, node, self._elapsed_ps())
        self.timeline.interrupted = True

    def changed(self) -> None:
        """Update the list of nodes that take part, and whether whole frames can be processed in one step."""
        members = [node for node in self.nodes if node.on_bus]
        waiting = [node for node in self.nodes if node.waiting and not node.on_bus]
        self._stations = [node for node in self.nodes if node.on_bus or node.waiting]
        self._listeners = len([node for node in members if node.listen_only])
        self._acknowledgers = len(members) - self._listeners
        asleep = [node for node in self.nodes if node.asleep and not node.on_bus and not node.waiting]
        self._link(members)
        self._waiting, self._sleeping = bool(waiting), bool(asleep)
        self._early_ps = min([node.sample_ps for node in members if node.validates_early], default=0)
        self._pause_ns = max([0] + [16 * node.bit_ps // 1000 for node in members])
        self._in_step, self._in_step_fd, self._in_step_switching = in_step(members, waiting, self.delay_ps)
        if self._state == _BITWISE:
            self.bits.refresh(self._stations, self._elapsed_ps())
        self.timeline.interrupted = True

    def _link(self, members: list[Node]) -> None:
        """Link the members in a chain, which the frame path follows without type checks."""
        self._members = members
        self._first = members[0] if members else None
        for k, node in enumerate(members):
            node.next_member = members[k + 1] if k + 1 < len(members) else None

    def descend(self) -> None:
        """Change to the bit level if anything is on the wire, an intermission included."""
        self.interrupt()
        if self._state == _REST and self.timeline.now_ns < self._free_ns:
            self._leave_rest()

    def interrupt(self) -> None:
        """Change to the bit level in the middle of a frame, so that a change takes effect at the present bit."""
        if self._state == _SENDING:
            for node in self._members:
                self.catch_up(node)
            self._enter_bitwise()
            phases.resume_frame(self.bits.clocks)
            if self.noise_left >= 0:
                self.noise_left += self._noise_taken
            self._replay()
        elif self._state == _ERRING:
            self._enter_at(self._end_ps - _ACK_SLOT_TO_FREE * self._sender.bit_ps)
            phases.fail_unacknowledged(self.bits.clocks, self._sender, self._slot, self._flag_passive)
            self._replay()
            self._rest_if_over()
        elif self._state == _REST and len(self._members) == 1 and self.timeline.now_ns < self._free_ns:
            self._leave_rest()  # if this node leaves, no intermission continues
            self._rest_if_over()

    def _rest_if_over(self) -> None:
        """Leave the bit level after the sample point of the last bit of an intermission."""
        if self.bits.resting():
            self._leave_bitwise()

    def _replay(self) -> None:
        """Run the bit level up to now; everything before now went well."""
        self._inside.over = True
        self.bits.replay(self.timeline.now_ns)

    def short(self, shorted: bool) -> None:
        """Short the two wires (the bus is dominant for all nodes), or remove the short."""
        self.interrupt()
        if self._state == _REST and shorted:
            self._leave_rest()
        self.bits.shorted = shorted
        self.bits.refresh(self._stations if self._state == _BITWISE else [], self._elapsed_ps())
        self.timeline.interrupted = True

    def stimulate(self, stimulus: Stimulus) -> None:
        """Force levels at nodes' receivers, from now on at the earliest."""
        self.interrupt()
        if self._state == _REST:
            self._leave_rest()
        self.bits.stimulate(stimulus, self._elapsed_ps())
        self.timeline.interrupted = True

    def _leave_rest(self) -> None:
        """Change to the bit level while no frame is on the wire, if necessary during an intermission."""
        now_ns = self.timeline.now_ns
        self.account()
        sender, self._sender = self._sender, self._nobody
        self._forget_contenders()
        self._rouse(now_ns)
        if now_ns >= self._free_ns or not self._members:
            self._start_ns = max(now_ns, self._free_ns)
            self._busy_from_ns = now_ns
            if now_ns > self._free_ns:
                self._begin_late(now_ns)
            self._enter_bitwise()
            phases.resume(self.bits.clocks, self.bits.offset_ps(), self._joining.quiet_from())
            return
        self._start_ns = self._free_ns
        bit_ps = self._members[0].bit_ps if sender is self._nobody else sender.bit_ps
        self._enter_at(self._free_ps - _INTERMISSION * bit_ps)
        phases.resume(self.bits.clocks, self.bits.offset_ps(), self._joining.quiet_from())
        phases.resume_intermission(self.bits.clocks, sender)
        self._replay()

    def busy(self) -> bool:
        """Whether a frame or an error is on the wire, or a frame waits for transmission."""
        return not self.idle() or self._next_start() != _NEVER

    def next_ns(self) -> int:
        if self._state == _SENDING:
            return self._next_ns
        if self._state == _ERRING:
            return self._end_ns
        if self._state == _BITWISE:
            return self.bits.at_ns(self.bits.next_ps()) if self._anything_left() else self.timeline.now_ns
        start = self._next_start()
        if self._waiting:
            joining = self._joining.next_ns(_NEVER, 0)
            return joining if joining < start else start
        return start

    def run(self, limit_ns: int) -> None:
        timeline = self.timeline
        while not timeline.interrupted:
            if self._state == _SENDING:
                if self._next_ns > limit_ns:
                    return
                timeline.now_ns = self._next_ns
                if self._next_ns != self._end_ns:
                    self._happen()
                elif self._acknowledged:
                    self._succeed()
                else:
                    self._fail_unacknowledged(self._sender, self._box)
            elif self._state == _BITWISE:
                if not self._run_bits(limit_ns):
                    return
            elif self._state == _ERRING:
                if self._end_ns > limit_ns:
                    return
                timeline.now_ns = self._end_ns
                self._end_error_frame()
            elif self._waiting or not self._go_on(limit_ns):
                start = self._next_start()
                if self._waiting:
                    start_ps = self._free_ps if start == self._free_ns else 0
                    joining = self._joining.next_ns(start, start_ps)
                    if joining != _NEVER:
                        if joining > limit_ns:
                            return
                        timeline.now_ns = joining
                        self._joining.join(joining, start_ps if joining == start else 999)
                        continue
                if start > limit_ns:
                    return
                if start < timeline.now_ns:
                    start = timeline.now_ns  # somebody who has only just come has waited for long
                timeline.now_ns = start
                self._start(start, limit_ns)

    def _go_on(self, limit_ns: int) -> bool:
        """Start the next frame directly after the last one: the common case, found by a single check. False if not."""
        free = self._free_ns
        now = self.timeline.now_ns
        if free > limit_ns or now > free:
            return False
        if not self._start(free, limit_ns):
            return False
        self.timeline.now_ns = free
        return True

    # whole frames

    def _next_start(self) -> int:
        """The time of the next SOF: when the bus is free and a node is ready to send; NEVER if no node has a frame."""
        free = self._free_ns
        soonest = _NEVER
        node = self._first
        while node is not None:
            box = node.offer
            if box is not None and not node.listen_only:
                ready = box.ready_ns
                if node.suspended_ns > ready:
                    ready = node.suspended_ns
                if ready <= free:
                    return free
                if ready < soonest:
                    soonest = ready
            node = node.next_member
        return soonest

    def _start(self, start_ns: int, limit_ns: int) -> bool:
        """Arbitrate among all nodes that are ready, and find out how the frame will end; False if no node is ready.

        For a frame that is over by `limit_ns` and that no node observes inside, `contending` is not set: arbitration
        losses are counted immediately. A frame that may be observed is passed to `_contend`.
        """
        sender = None
        lowest = _NOBODY
        rivals = 0
        collision = keen = tainted = False
        node = self._first
        while node is not None:
            box = node.offer
            if box is None or box.ready_ns > start_ns or node.suspended_ns > start_ns or node.listen_only:
                node.contends = False
            else:
                node.contends = True
                node.arbitration_losses += 1  # but for the winner's
                rivals += 1
                if node.attentive or box.single_shot:
                    keen = True
                key = box.key
                if key < lowest:
                    collision = False
                    lowest = key
                    sender = node
                elif key == lowest:
                    collision = True
            if node.tainted:
                tainted = True
            node = node.next_member
        if sender is None:
            return False
        if start_ns != self._free_ns:
            self._begin_late(start_ns)
        self._start_ns = start_ns
        sender.arbitration_losses -= 1
        self._sender = sender
        self._box = sender.offer  # type: ignore[assignment]  # a sender has an offer
        self._rivals = 0  # left to be counted
        joins = self._waiting and self._joining.count(start_ns, self._free_ps)
        if self._sleeping:
            self._rouse(start_ns)
        if collision:
            self.collisions += 1
        if collision or self.bitwise or joins or not self._in_step or not self._skippable():
            self._contend()
            self._enter_bitwise()
        else:
            self._time_frame()
            if tainted or (keen and rivals > 1):
                self._contend()
                self._next_ns = self._look_inside().next_ns(self._end_ns, self._acknowledged)
            elif self._early_ps and self._acknowledged:
                self._contend()
                self._next_ns = start_ns + (self._end_ps - 2 * sender.bit_ps + self._early_ps) // 1000
            elif self._end_ns > limit_ns or not self._acknowledged or self.timeline.interrupted:
                self._contend()
        return True

    def _skippable(self) -> bool:
        """Whether no injected fault affects this frame, and all nodes can read its format."""
        box = self._box
        if box.words[1] >> 32 & _FD:
            if not (self._in_step_switching if box.data_bits else self._in_step_fd):
                return False
            can_bits.show_error_state(box, self._sender.passive, self._sender.fd)
        alone = self._acknowledgers <= 1
        self._acknowledged = not alone or self._sender.self_test
        if alone and (self._waiting or (self._listeners and not self._acknowledged)):
            return False
        if self.scripted is not None:
            self._contend()
            if self.scripted(box):
                return False
        if self.noise_left >= 0:
            bits = box.bits
            if not self._acknowledged:
                bits -= _EOF_END_TO_ACK - (1 if box.words[1] >> 32 & _FD else 0)
            if self.noise_left < bits:
                return False
            self._noise_taken = bits
            self.noise_left -= bits
        return True

    def _time_frame(self) -> None:
        """Compute the end of the frame from its bits at one or two rates; without an acknowledge, when its sender
        detects that.
        """
        node = self._sender
        box = self._box
        bits = box.bits
        length_ps = bits * node.bit_ps
        if box.data_bits:
            length_ps += (box.data_bits + 1) * (node.data_bit_ps - node.bit_ps)
        if not self._acknowledged:
            length_ps -= _EOF_END_TO_ACK * node.bit_ps - (node.bit_ps if box.words[1] >> 32 & _FD else 0)
            length_ps += (_ERROR_FRAME + _INTERMISSION) * node.bit_ps
        self._end_ps = self._free_ps + length_ps
        if not self._acknowledged:
            length_ps -= _ACK_SLOT_TO_FREE * node.bit_ps - node.sample_ps
        self._end_ns = self._next_ns = self._start_ns + (self._free_ps + length_ps) // 1000
        self._state = _SENDING

    def _happen(self) -> None:
        """Process an event in the middle of the frame that a node notices."""
        inside = self._look_inside()
        inside.over = False
        soonest = inside.happen(self.timeline.now_ns, self._end_ns, self._acknowledged)
        if self._state == _SENDING:
            self._next_ns = soonest

    def _succeed(self) -> None:
        """End the frame after its last EOF bit: count it and deliver it."""
        sender = self._sender
        box = self._box
        if self._rivals:
            self._count_losers()
        self._state = _REST
        bit_ps = sender.bit_ps
        end_ns = self._end_ns
        free_ps = self._end_ps + _INTERMISSION * bit_ps
        self._free_ns = self._start_ns + free_ps // 1000
        self._free_ps = free_ps % 1000
        if self._waiting:
            quiet_ps = self._end_ps - _ACK_DELIMITER_TO_EOF_END * bit_ps
            self._joining.quiet_from_ns = self._start_ns + quiet_ps // 1000
            self._joining.quiet_from_ps = quiet_ps % 1000
            self._joining.restart()
        self.tally.frames += 1
        self.tally.last_success_ns = end_ns
        if self.tally.tap is not None:
            self.tally.tap.transmitted(sender, box, end_ns)
        node = self._first
        while node is not None:
            if node.contending is not None:
                node.contending = None
            if node is not sender:
                if node.sink is not None:
                    node.frames_received += 1
                    node.sink.deliver(box, end_ns, 0)
                elif not node.validates_early or node.stored_ns != self._start_ns:
                    node.received(box, end_ns)
            node = node.next_member
        sender.transmitted(box, end_ns)  # last, because it may load the mailbox again
        if sender.passive:
            sender.suspended_ns = self._free_ns + 8 * bit_ps // 1000

    def _count_losers(self) -> None:
        """Count arbitration losses that have not been counted yet."""
        sender = self._sender
        node = self._first
        while node is not None:
            if node.contending is not None and node is not sender:
                node.arbitration_losses += 1
            node = node.next_member

    def _fail_unacknowledged(self, sender: Node, box: Mailbox) -> None:
        """Fail a lone sender's frame: the ACK slot is recessive; error flag, delimiter, intermission follow."""
        self._state = _ERRING
        self._end_ns = self._start_ns + self._end_ps // 1000
        self._flag_passive = sender.passive
        self.tally.error_frames += 1
        rule = _NO_RULE if sender.passive else _TRANSMIT_ERROR
        sender.segment = _ACK_SLOT
        sender.read_dominant = False
        self._slot = box.bits - (8 if box.words[1] >> 32 & _FD else 9)  # the mailbox may be loaded again now
        sender.error(_ACK_ERROR, self._slot, True, rule, self.timeline.now_ns)
        sender.contending = None

    def _end_error_frame(self) -> None:
        sender = self._sender
        self._state = _REST
        self._free_ns = self._end_ns
        self._free_ps = self._end_ps % 1000
        if sender.passive:
            sender.suspended_ns = self._free_ns + 8 * sender.bit_ps // 1000

    # bit by bit

    def _enter_bitwise(self) -> None:
        self._enter_at(self._free_ps)

    def _enter_at(self, at_ps: int) -> None:
        """Enter the bit level `at_ps` picoseconds after `_start_ns`."""
        self._state = _BITWISE
        self.bits.delay_ps = self.delay_ps
        origin_ps = self._start_ns * 1000 + at_ps
        self.bits.enter(self._stations, origin_ps // 1000, origin_ps % 1000)

    def _run_bits(self, limit_ns: int) -> bool:
        """Run bits until the limit, until the bus rests, or until the timeline is interrupted; False at the limit."""
        bits, timeline = self.bits, self.timeline
        bits.aligned = False  # who knows what has happened since
        while not self.timeline.interrupted:
            if not self._anything_left():
                self._leave_bitwise()  # the last node has left
                return True
            if bits.coast(limit_ns):
                self.timeline.now_ns = bits.at_ns(bits.now_ps)
            else:
                at_ps = bits.next_ps()
                at_ns = bits.at_ns(at_ps)
                if at_ns > limit_ns:
                    return False
                self.timeline.now_ns = at_ns
                bits.step_at(at_ps)
                if bits.halfway and timeline.interrupted:
                    bits.step_at(at_ps)
            if bits.resting():
                self._leave_bitwise()
                return True
        return True

    def _anything_left(self) -> bool:
        return bool(self.bits.clocks or self.bits.stimuli)

    def _leave_bitwise(self) -> None:
        bits = self.bits
        bits.leave()
        self._state = _REST
        self._free_ns = bits.at_ns(bits.now_ps)
        self._free_ps = bits.remainder_ps()
        self._sender = self._nobody
        self._forget_contenders()
