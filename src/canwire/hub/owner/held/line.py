"""The leases on a line of any kind: one control, and any number of queues or one exclusive queue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from canwire.errors import CanwireError, InUse
from canwire.hub.owner.held.held import Held, Holder, Turn


class LineSlot:
    """A line of a board: the holder of its control, and its queues, which are channels (CAN) or monitors (LIN)."""

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
        """True if a queue uses the line exclusively."""
        return any(queue.exclusive for queue in self.queues)

    def admit(self, what: str, holder: Holder | None) -> None:
        """Raise InUse if `what` has a holder."""
        if holder is not None:
            raise InUse(f"{self.name}: {what} is held by {holder.name}")

    def admit_queue(self, exclusive: bool) -> None:
        """Raise InUse for an exclusive queue if there are others, and for any queue if there is an exclusive one."""
        if self.queues and (exclusive or self.exclusive):
            noun = self.queue_noun
            there = f"an exclusive {noun}" if self.exclusive else f"{len(self.queues)} {noun}s"
            raise InUse(f"{self.name}: {there} already open on it, by {self.queues[0].holder.name}")

    def users(self) -> list[Holder]:
        """The holder of each lease on this line except shares; a program appears once for each of its leases."""
        return [queue.holder for queue in self.queues] + ([] if self.control is None else [self.control])

    def used_by(self, holder: Holder | None) -> bool:
        """True if this client has a lease on this line."""
        return any(user is holder for user in self.users())

    def check_rate(self, holder: Holder, kin: tuple[str, str], now: str, wanted: str) -> None:
        """Raise InUse, with both rates, if another rate is requested for a running line that other programs use.

        The program that has set the line up may change the rate, and so may one of the same interface (`kin`).
        """
        if holder is self.setter or (kin[0] and kin[0] == kin[1]):
            return
        if any(user is not holder for user in self.users()):
            raise InUse(
                f"{self.name} runs at {now}; it cannot be set to {wanted} while other programs use it"
            )

    def settle(self) -> None:
        """A lease has ended: reset the line if none is left (VCI V4 manual 5.2.3, closing the control unit)."""
        raise NotImplementedError

    def close(self, why: CanwireError) -> None:
        """The board was pulled out: every waiting call gets this error."""
        raise NotImplementedError


class OnLine(Held):
    """A lease on a line."""

    slot: LineSlot

    def is_on(self, board: int) -> bool:
        return board == self.slot.board

    def let_go(self) -> None:
        self.leave()
        self.slot.settle()

    def leave(self) -> None:
        """Release the place of this lease on the line; `settle` of the line follows."""
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
    """A lease that keeps the settings of a line while it is held."""

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
        """Connect the queue to the line, or disconnect it; raises NotInitialised before it was set up."""
        raise NotImplementedError

    def counted(self, name: str) -> int:
        """The value of one counter; 0 before the queue is set up, and for an unknown name."""
        return 0
