"""Who holds what on a line of any kind: one control, any number of queues or a single exclusive one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from canwire.errors import CanwireError, InUse
from canwire.hub.owner.held.held import Held, Holder, Turn


class LineSlot:
    """A line of a board: who holds its control, and the queues on it, which are channels (CAN) or monitors (LIN)."""

    queue_noun: ClassVar[str]

    def __init__(self, board: int, name: str) -> None:
        self.board = board
        self.name = name
        self.control: Holder | None = None
        self.control_kin = ""  # the interface of the program that holds the control
        self.queues: list[HeldQueue] = []
        self.setter: Holder | None = None  # who set it up last
        self.keepers = 0  # programs for which the settings stay even if nobody has more of the line

    @property
    def exclusive(self) -> bool:
        """A queue has the line for itself."""
        return any(queue.exclusive for queue in self.queues)

    def admit(self, what: str, holder: Holder | None) -> None:
        """Raise InUse if somebody holds it."""
        if holder is not None:
            raise InUse(f"{self.name}: {what} is held by {holder.name}")

    def admit_queue(self, exclusive: bool) -> None:
        """Raise InUse for an exclusive queue beside others, or any beside an exclusive one."""
        if self.queues and (exclusive or self.exclusive):
            noun = self.queue_noun
            there = f"an exclusive {noun}" if self.exclusive else f"{len(self.queues)} {noun}s"
            raise InUse(f"{self.name}: {there} on it already, of {self.queues[0].holder.name}")

    def users(self) -> list[Holder]:
        """Everybody who has anything open here but shares, a program once for each."""
        return [queue.holder for queue in self.queues] + ([] if self.control is None else [self.control])

    def used_by(self, holder: Holder | None) -> bool:
        """It has anything open here."""
        return any(user is holder for user in self.users())

    def check_rate(self, holder: Holder, kin: tuple[str, str], now: str, wanted: str) -> None:
        """Before a running line is set to another rate: it keeps its own as long as others are there.

        Not for who set it up, and where its `kin` is that of the new setting. Raises InUse with both rates.
        """
        if holder is self.setter or (kin[0] and kin[0] == kin[1]):
            return
        if any(user is not holder for user in self.users()):
            raise InUse(f"{self.name} runs at {now}; it cannot be set to {wanted} as long as others use it")

    def settle(self) -> None:
        """Somebody let go: nobody left means nobody's settings (VCI V4 manual 5.2.3, closing the control unit)."""
        raise NotImplementedError

    def close(self, why: CanwireError) -> None:
        """The board is gone; every waiting call gets this error."""
        raise NotImplementedError


class OnLine(Held):
    """Something held on a line."""

    slot: LineSlot

    def is_on(self, board: int) -> bool:
        return board == self.slot.board

    def let_go(self) -> None:
        self.leave()
        self.slot.settle()

    def leave(self) -> None:
        """Its place on the line is free; the line settles afterwards."""
        raise NotImplementedError


@dataclass(eq=False)
class HeldControl(OnLine):
    """The lease on a line's control, CAN or LIN."""

    turn = Turn.CONTROL
    slot: LineSlot
    kin: str = ""

    def __post_init__(self) -> None:
        self.slot.control_kin = self.kin

    def leave(self) -> None:
        self.slot.control = None


@dataclass(eq=False)
class HeldSettings(OnLine):
    """A line's settings stay for as long as somebody has this."""

    turn = Turn.SHARE
    slot: LineSlot

    def __post_init__(self) -> None:
        self.slot.keepers += 1

    def leave(self) -> None:
        self.slot.keepers -= 1


@dataclass(eq=False)
class HeldQueue(OnLine):
    """A client's queue, or queues, on a line."""

    turn = Turn.QUEUE
    limit = "channels"
    slot: LineSlot
    holder: Holder
    exclusive: bool
    kin = ""  # the interface that its program speaks

    def activate(self, active: bool) -> None:
        """Connect it to the line, or take it off; raises NotInitialised before it was set up."""
        raise NotImplementedError

    def counted(self, name: str) -> int:
        """One of its counters; 0 before it is set up, and where it has none of that name."""
        return 0
