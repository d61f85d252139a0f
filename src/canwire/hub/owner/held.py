"""Who holds what on a line: one control, one cyclic list, any number of channels or a single exclusive one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire.boards.can.connector import CanLine
from canwire.boards.can.modes import LineStatus
from canwire.boards.can.scheduler import CyclicList
from canwire.boards.sharing import Share, Sharing
from canwire.errors import CanwireError, InUse
from canwire.hub.owner.pipes import Pipe

if TYPE_CHECKING:
    from canwire.hub.owner.held_channel import HeldChannel
    from canwire.hub.owner.session import Session


class LineSlot:
    """A line of a board, and who holds its control."""

    def __init__(self, board: int, name: str) -> None:
        self.board = board
        self.name = name
        self.control: Session | None = None

    def admit(self, what: str, holder: Session | None) -> None:
        """Raise InUse if somebody holds it."""
        if holder is not None:
            raise InUse(f"{self.name}: {what} is held by {holder.name}")

    def settle(self) -> None:
        """Somebody let go: nobody left means nobody's settings (VCI V4 manual 5.2.3, closing the control unit)."""
        raise NotImplementedError

    def close(self, why: CanwireError) -> None:
        """The board is gone; whoever waits gets this error."""
        raise NotImplementedError


class Slot(LineSlot):
    """A CAN line with its holders; when the last of them goes, the line is reset."""

    def __init__(self, board: int, can: CanLine) -> None:
        super().__init__(board, can.line.name)
        self.can = can
        self.scheduler: Session | None = None
        self.channels: list[HeldChannel] = []
        info = can.info
        self.sharing = Sharing(can.line.name, info.receive_channels, info.send_channels)

    @property
    def exclusive(self) -> bool:
        return any(channel.exclusive for channel in self.channels)

    def admit_channel(self, exclusive: bool) -> None:
        """Raise InUse for an exclusive channel beside others, or any beside an exclusive one."""
        if self.channels and (exclusive or self.exclusive):
            kind = "an exclusive channel" if self.exclusive else f"{len(self.channels)} channels"
            holder = self.channels[0].holder.name
            raise InUse(f"{self.can.line.name}: {kind} on it already, of {holder}")

    def settle(self) -> None:
        mode = self.can.mode
        if mode is not None and mode.persistent:
            return
        users = (self.control, self.scheduler, *self.channels)
        if not any(user is not None for user in users) and not len(self.sharing):
            self.can.reset()

    def close(self, why: CanwireError) -> None:
        self.can.close(why)

    def status(self) -> LineStatus:
        can, driver = self.can, self.can.line.driver
        counters = driver.counters()
        return LineStatus(
            initialised=can.mode is not None,
            running=can.running,
            mode=can.mode,
            state=counters.state,
            tec=counters.tec,
            rec=counters.rec,
            last_error=counters.last_error,
            load=can.load(),
            transmitting=any(box.occupied for box in driver.boxes),
            coupling_fault=can.coupling_fault,
            frames_sent=counters.frames_sent,
            frames_received=counters.frames_received,
            errors=counters.errors,
            arbitration_losses=counters.arbitration_losses,
            refused=sum(held.counted("refused") for held in self.channels),
            lost=sum(held.counted("lost") for held in self.channels),
            control_holder="" if self.control is None else self.control.name,
            scheduler_holder="" if self.scheduler is None else self.scheduler.name,
            channels=len(self.channels),
            exclusive=self.exclusive,
            time_ns=can.line.timeline.now_ns,
        )


class OnLine:
    """Something held on a line."""

    slot: LineSlot

    @property
    def board(self) -> int:
        return self.slot.board


@dataclass
class HeldControl(OnLine):
    """The lease on a line's control, CAN or LIN."""

    slot: LineSlot

    def let_go(self) -> None:
        self.slot.control = None


@dataclass
class HeldScheduler(OnLine):
    """The lease on a line's cyclic list."""

    slot: Slot
    cyclic: CyclicList

    def let_go(self) -> None:
        self.cyclic.close()
        self.slot.scheduler = None


@dataclass
class HeldShare(OnLine):
    """A line that somebody has open for reading or writing."""

    slot: Slot
    share: Share

    def let_go(self) -> None:
        self.slot.sharing.close(self.share)


@dataclass
class HeldLayer:
    """A share of a board's access layer."""

    board: int
    layer: str


@dataclass
class HeldPipe:
    """A reference to a FIFO, as its reader, its writer or neither."""

    pipe: Pipe
    role: str
