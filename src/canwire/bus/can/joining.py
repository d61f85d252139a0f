"""Nodes that wait for 11 recessive bits, or for 128 times as many, before they take part.

bus.py uses this file while it skips over whole frames; at the bit level, every station counts for itself.
Source: ISO 11898-1:2015 8.2.6 (bus integration), 12.1.4.4 (recovery); reference/can-protocol.md section 7.
"""

from __future__ import annotations

from canwire.bus.can.node import Node
from canwire.timeline import NEVER

_NEVER = NEVER


class Joining:
    """The nodes that wait on one bus; `nodes` is the bus's own list.

    The bus has been recessive since `quiet_from_ns` and, beyond these, `quiet_from_ps` (0..999). Times are compared to
    the picosecond: a node whose last bit ends where a frame begins takes part in the arbitration of that frame.
    """

    def __init__(self, nodes: list[Node]) -> None:
        self.nodes = nodes
        self.quiet_from_ns = 0
        self.quiet_from_ps = 0

    def quiet_from(self) -> int:
        """Since when the bus has been recessive, in ps."""
        return self.quiet_from_ns * 1000 + self.quiet_from_ps

    def next_ns(self, start_ns: int, start_ps: int) -> int:
        """When the first waiting node has seen enough recessive bits, unless that is after this SOF; or NEVER."""
        soonest = _NEVER
        for node in self.nodes:
            if node.waiting:
                due = self._due_ns(node)
                if due < soonest and (due < start_ns or (due == start_ns and self._due_ps(node) <= start_ps)):
                    soonest = due
        return soonest

    def join(self, at_ns: int, at_ps: int) -> None:
        """Call `joined` of the nodes that have seen enough recessive bits by now."""
        for node in self.nodes:
            if node.waiting:
                due = self._due_ns(node)
                if due < at_ns or (due == at_ns and self._due_ps(node) <= at_ps):
                    node.joined(at_ns)

    def groups(self, node: Node, at_ns: int, at_ps: int) -> int:
        """How many groups of 11 bits the node has counted up to now, in recessive time that continues."""
        since = self._quiet_since(node)
        if at_ns < since:
            return node.sequences
        # a group is complete where its last bit is sampled
        past_ps = (at_ns - since) * 1000 + at_ps - self._beyond_ps(node) + node.bit_ps - node.sample_ps
        return node.sequences + (past_ps - 1) // (11 * node.bit_ps) if past_ps > 0 else node.sequences

    def count(self, start_ns: int, start_ps: int) -> bool:
        """Count whole runs of 11 bits at an SOF, which ends the recessive time; True if a node has enough."""
        enough = False
        for node in self.nodes:
            if node.waiting:
                node.sequences = self.groups(node, start_ns, start_ps)
                enough = enough or node.sequences >= node.waiting
        return enough

    def restart(self) -> None:
        """Start counting again: the bus is recessive since `quiet_from_ns`."""
        for node in self.nodes:
            if node.waiting and node.waiting_from_ns <= self.quiet_from_ns:
                node.waiting_from_ps = self._beyond_ps(node)
                node.waiting_from_ns = self.quiet_from_ns

    def _quiet_since(self, node: Node) -> int:
        return node.waiting_from_ns if node.waiting_from_ns > self.quiet_from_ns else self.quiet_from_ns

    def _beyond_ps(self, node: Node) -> int:
        """The picoseconds (0..999) by which the node's recessive time begins after `_quiet_since`."""
        if node.waiting_from_ns != self.quiet_from_ns:
            return node.waiting_from_ps if node.waiting_from_ns > self.quiet_from_ns else self.quiet_from_ps
        return max(node.waiting_from_ps, self.quiet_from_ps)

    def _due_ns(self, node: Node) -> int:
        return self._quiet_since(node) + self._missing_ps(node) // 1000

    def _due_ps(self, node: Node) -> int:
        """The picoseconds (0..999) by which the node is due after `_due_ns`."""
        return self._missing_ps(node) % 1000

    def _missing_ps(self, node: Node) -> int:
        """The time from `_quiet_since` to the end of the last bit that the node must see, in ps."""
        return self._beyond_ps(node) + 11 * (node.waiting - node.sequences) * node.bit_ps
