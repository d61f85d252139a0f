"""The base class of leases at the hub, and the interface to their holders. This file knows no concrete class."""

from __future__ import annotations

from enum import IntEnum
from typing import ClassVar, Protocol

from canwire.hub.owner.held.bells import Bells
from canwire.platform import EventDescriptor


class Halts(Protocol):
    """An object that stops the passing of virtual time: a timeline, or its substitute."""

    def halt(self) -> None: ...


class Holder(Protocol):
    """The client that holds a lease. `halts` is called at each signal to it; with `bells`, these give the signals."""

    name: str
    halts: Halts | None
    bells: Bells | None
    doorbell: EventDescriptor | None

    def channels_changed(self) -> None:
        """A channel was activated, deactivated or closed."""


class Turn(IntEnum):
    """The order in which the leases of a client end: first those that send, so that nothing new is sent."""

    SCHEDULER = 0
    QUEUE = 1
    CONTROL = 2
    SHARE = 3
    REFERENCE = 4


class Held:
    """Anything that a handle refers to."""

    turn: ClassVar[Turn] = Turn.REFERENCE
    limit: ClassVar[str] = "leases"  # which of the client's limits it counts for (boards/config/limits.py)

    def is_on(self, board: int) -> bool:
        """True if this lease ends when this board is pulled out."""
        return False

    def let_go(self) -> None:
        """The lease has ended: release what it has reserved. By default it reserves nothing."""


class Gone(Held):
    """Replaces the object of a handle whose board was pulled out."""

    def __init__(self, text: str) -> None:
        self.text = text
