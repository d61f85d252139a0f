"""What has happened on one bus, counted once for all nodes. Called by bus.py and station.py."""

from __future__ import annotations

from canwire.bus.can.node import Mailbox, Node


class Tap:
    """An observer of the wire that is no node."""

    def transmitted(self, node: Node, box: Mailbox, at_ns: int) -> None:
        """The node's frame went through."""
        raise NotImplementedError


class Tally:
    """What has happened on one bus, counted once for all its stations."""

    def __init__(self) -> None:
        self.frames = 0
        self.error_frames = 0
        self.erring = False
        self.last_success_ns = 0
        self.tap: Tap | None = None
