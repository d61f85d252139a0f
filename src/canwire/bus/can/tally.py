"""Events on one bus, counted once for all nodes. bus.py and station.py update it."""

from __future__ import annotations

from canwire.bus.can.node import Mailbox, Node


class Tap:
    """An observer of the bus that is not a node."""

    def transmitted(self, node: Node, box: Mailbox, at_ns: int) -> None:
        """Called when a frame of this node was transmitted."""
        raise NotImplementedError


class Tally:
    """Events on one bus, counted once for all its stations."""

    def __init__(self) -> None:
        self.frames = 0
        self.error_frames = 0
        self.erring = False
        self.last_success_ns = 0
        self.tap: Tap | None = None
