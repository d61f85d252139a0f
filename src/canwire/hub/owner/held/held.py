"""What everything held has in common, and what it may ask of its holder. This file knows nobody."""

from __future__ import annotations

from enum import IntEnum
from typing import ClassVar, Protocol

from canwire.hub.owner.held.bells import Bells
from canwire.platform import EventDescriptor


class Halts(Protocol):
    """What ends the passing of virtual time: a timeline, or its substitute."""

    def halt(self) -> None: ...


class Holder(Protocol):
    """A client, as what it holds sees it; `halts` is called at every signal that it gets, or `bells` give it."""

    name: str
    halts: Halts | None
    bells: Bells | None
    doorbell: EventDescriptor | None

    def channels_changed(self) -> None:
        """One was activated, deactivated or given back."""


class Turn(IntEnum):
    """The order in which a client's things are given back: first what sends by itself, so that nothing new is sent."""

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
        """It dies with this board."""
        return False

    def let_go(self) -> None:
        """Given back: others may have it. Without more, nobody was kept away by it."""


class Gone(Held):
    """The object of a handle whose board was pulled out."""

    def __init__(self, text: str) -> None:
        self.text = text
