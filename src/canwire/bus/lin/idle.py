"""Calls the nodes of a LIN bus that has had no edge for seconds; they fall asleep.

Source: LIN 2.2A 2.6.3; reference/lin-protocol.md section 7.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from canwire.bus.lin.node import LinNode
from canwire.timeline import Timeline, Timer


class Idleness:
    """Watches the time since the last edge for nodes that are awake; `last_edge_ns` returns when the level last
    changed.

    One background timer serves all nodes and costs nothing while frames come: it fires every `idle_ns` at most.
    """

    def __init__(self, timeline: Timeline, idle_ns: int | None, last_edge_ns: Callable[[], int]) -> None:
        self._timeline = timeline
        self._idle_ns = idle_ns
        self._last_edge_ns = last_edge_ns
        self._nodes: Sequence[LinNode] = ()
        self._timer: Timer | None = None

    def watch(self, nodes: Sequence[LinNode]) -> None:
        """Set the nodes that are on the bus now."""
        self._nodes = nodes
        if self._timer is None:
            self._arm()

    def _arm(self) -> None:
        awake = [node.awake_since_ns for node in self._nodes if not node.asleep]
        if awake and self._idle_ns is not None:
            due_ns = max(min(awake), self._last_edge_ns()) + self._idle_ns
            self._timer = self._timeline.at(due_ns, self._look, background=True)

    def _look(self) -> None:
        self._timer = None
        now_ns, edge_ns = self._timeline.now_ns, self._last_edge_ns()
        assert self._idle_ns is not None
        for node in self._nodes:
            if not node.asleep and max(edge_ns, node.awake_since_ns) + self._idle_ns <= now_ns:
                node.quiet(now_ns)
        if self._timer is None:  # a node that falls asleep may have had it set
            self._arm()
