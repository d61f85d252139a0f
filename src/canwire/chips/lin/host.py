"""The interfaces that a LIN controller reports to: a line implements them."""

from __future__ import annotations

from canwire.bus.lin.node import LinResponse
from canwire.values.lin.event import LinOutcome


class LinEar:
    """Receives the frames of a controller, in the order of bus time: those of others if it `hears`, those that the
    controller sends if it `hears_own`.
    """

    hears = True
    hears_own = True

    def deliver(self, response: LinResponse, at_ns: int) -> None:
        """Called when another node's response arrived, with a correct checksum, if it `hears`."""
        raise NotImplementedError

    def deliver_sent(self, response: LinResponse, at_ns: int) -> None:
        """Called when this controller's own response was sent, if it `hears_own`."""
        raise NotImplementedError


class LinHost:
    """Receives a controller's reports, in the order of bus time."""

    def error(self, kind: int, id: int, transmitting: bool, at_ns: int) -> None:
        """Called at a LinErrorKind, with the identifier of its frame or -1."""
        raise NotImplementedError

    def state_changed(self, at_ns: int) -> None:
        """Called when `state()` or `status()` has changed."""
        raise NotImplementedError

    def woken(self, at_ns: int) -> None:
        """Called when another node's wake-up pulse ended the sleep."""
        raise NotImplementedError

    def finished(self, id: int, outcome: LinOutcome, at_ns: int) -> None:
        """Called when the transmission is over and the buffer is free again; `id` is -1 for a wake-up pulse."""
        raise NotImplementedError
