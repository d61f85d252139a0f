"""Nodes that wait for 11 recessive bits, or for 128 times as many, before they take part.

Asked by bus.py while it skips over whole frames; bit by bit, every station counts for itself.
Source: ISO 11898-1:2015 8.2.6 (bus integration), 12.1.4.4 (recovery); reference/can-protocol.md section 7.
"""

from __future__ import annotations

from canwire.bus.can.node import Node
from canwire.timeline import NEVER

_NEVER = NEVER


class Joining:
    """Who waits on one bus, which has been recessive since `quiet_from_ns`; `nodes` is the bus's own list."""

    def __init__(self, nodes: list[Node]) -> None:
        self.nodes = nodes
        self.quiet_from_ns = 0

    def next_ns(self) -> int:
        """When the first of them has seen enough."""
        soonest = _NEVER
        for node in self.nodes:
            if node.waiting:
                due = self._due_ns(node)
                if due < soonest:
                    soonest = due
        return soonest

    def join(self, at_ns: int) -> None:
        """Tell those who have seen enough by now."""
        for node in self.nodes:
            if node.waiting and self._due_ns(node) <= at_ns:
                node.joined(at_ns)

    def groups(self, node: Node, at_ns: int) -> int:
        """How many groups of 11 bits the node has counted up to now, in recessive time that goes on."""
        since = self._quiet_since(node)
        if at_ns <= since:
            return node.sequences
        # a group is complete where its last bit is sampled
        past_ps = (at_ns - since) * 1000 + node.bit_ps - node.sample_ps
        return node.sequences + (past_ps - 1) // (11 * node.bit_ps)

    def count(self, start_ns: int) -> bool:
        """An SOF ends the recessive time: whole runs of 11 bits count, the rest is lost. True if one has enough."""
        enough = False
        for node in self.nodes:
            if node.waiting:
                node.sequences = self.groups(node, start_ns)
                enough = enough or node.sequences >= node.waiting
        return enough

    def restart(self) -> None:
        """The bus is recessive again since `quiet_from_ns`."""
        for node in self.nodes:
            if node.waiting and node.waiting_from_ns < self.quiet_from_ns:
                node.waiting_from_ns = self.quiet_from_ns

    def _quiet_since(self, node: Node) -> int:
        return node.waiting_from_ns if node.waiting_from_ns > self.quiet_from_ns else self.quiet_from_ns

    def _due_ns(self, node: Node) -> int:
        bits = 11 * (node.waiting - node.sequences)
        return self._quiet_since(node) + (bits * node.bit_ps + 999) // 1000
