"""The calls from a controller to its line: the interface between chip and line."""

from __future__ import annotations

from canwire.bus.can.node import Mailbox


class Host:
    """Receives a controller's calls in the order of bus time. A `box` is valid until the call returns."""

    def received(self, box: Mailbox, at_ns: int) -> None:
        """Called when a frame arrived."""
        raise NotImplementedError

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        """Called when the frame in `box` was transmitted; the mailbox is free again once this returns."""
        raise NotImplementedError

    def aborted(self, box: Mailbox, at_ns: int) -> None:
        """Called when the frame in `box` was aborted; the mailbox is free again once this returns."""
        raise NotImplementedError

    def fill(self, at_ns: int) -> None:
        """Load the next queued frame: a mailbox is free."""
        raise NotImplementedError

    def event(self, kind: int, error: int, bit: int, transmitting: bool, at_ns: int, code: int) -> None:
        """Called at an EventKind; for errors with their ErrorKind, and the chip's own `code` for them (0: none)."""
        raise NotImplementedError
