# cython: nonecheck=False
"""A frame that is processed in one step: the events inside it, their times, and what a node does in the middle of it.

bus.py computes how the frame begins and ends. Some nodes can notice more: a node that loses arbitration and gets a
call, a node whose REC decreases at the ACK slot, one that stores a frame before its end, one whose state is read. For
these nodes alone this file computes the results that station.py computes bit by bit.
Source: ISO 11898-1:2015 chapters 10.4.2 and 12.1.4; reference/can-protocol.md sections 5 to 7.
"""

from __future__ import annotations

from canwire.bus.can import node as seam
from canwire.bus.can.node import Mailbox, Node
from canwire.timeline import NEVER

_NEVER = NEVER
_QUIET, _RECEIVED_LAST, _SENT = seam.QUIET, seam.RECEIVED_LAST, seam.SENT
_RECEIVING, _SENDING, _FAILED, _RECEIVED = seam.RECEIVING, seam.SENDING, seam.FAILED, seam.RECEIVED
_TOP_BIT = 1 << 31
_ACK_SLOT_TO_EOF_END = 9
_INTERMISSION = 3


class SteppedFrame:
    """The frame that bus.py processes in one step, or the last one.

    It began at `start_ns` and `lead_ps`; `end_ps` counts from `start_ns`. `first` begins the chain of all nodes on the
    bus. Nodes whose `contending` is set are still in arbitration or, as `sender`, have won it. `over` means that the
    frame is no longer processed in one step.
    """

    def __init__(self) -> None:
        self.start_ns = 0
        self.lead_ps = 0
        self.end_ps = 0
        self.sender = Node()
        self.box = Mailbox()
        self.first: Node | None = None
        self.over = False

    def take(self, start_ns: int, lead_ps: int, end_ps: int, sender: Node, box: Mailbox) -> None:
        """Set the frame."""
        self.start_ns = start_ns
        self.lead_ps = lead_ps
        self.end_ps = end_ps
        self.sender = sender
        self.box = box

    def next_ns(self, end_ns: int, acknowledged: bool) -> int:
        """The time of the next observable event, `end_ns` at the latest."""
        soonest = end_ns
        node = self.first
        while node is not None:
            box = node.contending
            if box is not None and node is not self.sender and (node.attentive or box.single_shot):
                soonest = min(soonest, self._loses_ns(node, box))
            if acknowledged and self._is_to_count(node):
                soonest = min(soonest, self._acknowledges_ns(node))
            if acknowledged and self._is_to_store(node):
                soonest = min(soonest, self._valid_ns(node))
            node = node.next_member
        return soonest

    def happen(self, now_ns: int, end_ns: int, acknowledged: bool) -> int:
        """Report the events that are due: to losers of arbitration, to receivers whose REC decreases or that store the
        frame.

        Returns when the next event is due, as `next_ns`, unless a call changed the bus to the bit level (`over`).
        """
        soonest = due = end_ns
        sender = self.sender
        node = self.first
        while node is not None:
            if node is not sender:
                box = node.contending
                if box is not None and (node.attentive or box.single_shot):
                    due = self._loses_ns(node, box)
                    if due <= now_ns:
                        self._lose(node, box)
                    else:
                        soonest = min(soonest, due)
                if acknowledged and not self.over and self._is_to_count(node):
                    due = self._acknowledges_ns(node)
                    if due <= now_ns:
                        node.counted_ns = self.start_ns
                        node.count(_RECEIVED, now_ns)
                    else:
                        soonest = min(soonest, due)
                if acknowledged and not self.over and self._is_to_store(node):
                    due = self._valid_ns(node)
                    if due <= now_ns:
                        node.stored_ns = self.start_ns
                        node.received(self.box, now_ns)
                    else:
                        soonest = min(soonest, due)
                if self.over:
                    return end_ns
            node = node.next_member
        return soonest

    def catch_up(self, node: Node, now_ns: int) -> None:
        """Count an arbitration loss up to now that needs no call."""
        box = node.contending
        if box is None or node is self.sender or node.attentive or box.single_shot:
            return
        if self._loses_ns(node, box) < now_ns:
            node.contending = None
            node.arbitration_losses += 1

    def activity(self, node: Node, now_ns: int) -> int:
        """The same as Bus.activity, up to the end of EOF."""
        if self.transmits(node, now_ns):
            return _SENDING
        joined = node.contending is not None or self._at_ns(self.lead_ps + node.sample_ps) < now_ns
        return _RECEIVING if joined else _QUIET

    def transmits(self, node: Node, now_ns: int) -> bool:
        """Whether the node has won arbitration, or still takes part in it."""
        box = node.contending
        return node is self.sender or (box is not None and now_ns <= self._loses_ns(node, box))

    def fails(self, now_ns: int) -> bool:
        """Whether an error frame follows an unacknowledged frame; `end_ps` is then the end of its intermission."""
        node = self.sender
        return now_ns <= self._at_ns(self.end_ps - (_INTERMISSION + 1) * node.bit_ps + node.sample_ps)

    def activity_behind(self, node: Node, now_ns: int) -> int:
        """Bus.activity during the intermission after the frame that ended at `end_ps`."""
        if now_ns > self._at_ns(self.end_ps - node.bit_ps + node.sample_ps):
            return _QUIET
        return _SENT if node is self.sender else _RECEIVED_LAST

    def _at_ns(self, at_ps: int) -> int:
        return self.start_ns + at_ps // 1000

    def _lose(self, node: Node, box: Mailbox) -> None:
        node.contending = None
        node.arbitration_losses += 1
        node.arbitration_lost(box, losing_bit(box.key, self.box.key), self.start_ns)

    def _loses_ns(self, node: Node, box: Mailbox) -> int:
        """When this contender samples the first dominant bit where it sends a recessive one."""
        at_bit = wire_bit(box.key, losing_bit(box.key, self.box.key))
        return self._at_ns(self.lead_ps + at_bit * node.bit_ps + node.sample_ps)

    def _is_to_count(self, node: Node) -> bool:
        return (
            node.tainted
            and not node.listen_only
            and node is not self.sender
            and node.counted_ns != self.start_ns
        )

    def _is_to_store(self, node: Node) -> bool:
        return node.validates_early and node is not self.sender and node.stored_ns != self.start_ns

    def _valid_ns(self, node: Node) -> int:
        """When this receiver samples the last bit of EOF but one."""
        return self._at_ns(self.end_ps - 2 * self.sender.bit_ps + node.sample_ps)

    def _acknowledges_ns(self, node: Node) -> int:
        """When this receiver samples its own acknowledge: its REC decreases then (rule 8)."""
        return self._at_ns(self.end_ps - _ACK_SLOT_TO_EOF_END * self.sender.bit_ps + node.sample_ps)


def losing_bit(key: int, winner: int) -> int:
    """The first bit where this arbitration field is higher than the winner's, 0..31 as SJA1000's ALC counts."""
    differing = key ^ winner
    bit = 0
    while differing < _TOP_BIT and bit < 31:
        differing <<= 1
        bit += 1
    return bit


def wire_bit(key: int, bit: int) -> int:
    """The position of a bit of the arbitration field on the wire, counted from SOF with stuff bits."""
    at = run = 1
    last = 0
    for k in range(bit + 1):
        level = key >> 31 - k & 1
        if run == 5:
            at += 1
            last ^= 1
            run = 1
        run = run + 1 if level == last else 1
        last = level
        at += 1
    return at - 1
