"""Who holds what on a CAN line, but for its channels: the cyclic list, and shares as Win32 has them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from canwire.boards.can.connector import CanLine, Done
from canwire.boards.can.modes import LineMode, LineStatus
from canwire.boards.can.rates import format_rates, format_setter, same_rates
from canwire.boards.can.scheduler import CyclicList
from canwire.boards.sharing import Share, Sharing
from canwire.errors import CanwireError, InUse
from canwire.hub.owner.held.held import Holder, Turn
from canwire.hub.owner.held.line import LineSlot, OnLine


class CanSlot(LineSlot):
    """A CAN line with its holders; when the last of them goes, the line is reset."""

    queue_noun = "channel"

    def __init__(self, board: int, can: CanLine) -> None:
        super().__init__(board, can.line.name)
        self.can = can
        self.scheduler: Holder | None = None
        self._setter: Holder | None = None
        info = can.info
        self.sharing = Sharing(can.line.name, info.receive_channels, info.send_channels)

    def settle(self) -> None:
        mode = self.can.mode
        if (mode is not None and mode.persistent) or self._users() or len(self.sharing):
            return
        if mode is not None and mode.keeps:
            self.can.abort_pending()
            self.can.stop(lambda _: None)
        else:
            self.can.reset()

    def used_by(self, holder: Holder) -> bool:
        """It has anything open here."""
        return any(user is holder for user in self._users())

    def initialise(self, holder: Holder, mode: LineMode, done: Done) -> None:
        """CanLine's, for a program that has the control; raises InUse where the rate is not its to change."""
        self._check_rate(holder, mode)
        before = self.can.mode
        if before is not None and before.persistent:
            mode = replace(mode, persistent=True)
        self.can.initialise(mode, done)
        self._setter = holder

    def _check_rate(self, holder: Holder, mode: LineMode) -> None:
        """A running line keeps its rate as long as others are there, but for those who set it and their kin."""
        now = self.can.mode
        if now is None or not self.can.running or holder is self._setter or same_rates(now, mode):
            return
        if (now.kin and now.kin == mode.kin) or all(user is holder for user in self._users()):
            return
        raise InUse(
            f"{self.name} runs at {format_rates(now)}, {format_setter(self.status())}; "
            f"it cannot be set to {format_rates(mode)} as long as others use it"
        )

    def _users(self) -> list[Holder]:
        """Everybody who has anything open here but shares, a program once for each."""
        leases = [holder for holder in (self.control, self.scheduler) if holder is not None]
        return leases + [queue.holder for queue in self.queues]

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
            refused=sum(held.counted("refused") for held in self.queues),
            lost=sum(held.counted("lost") for held in self.queues),
            control_holder="" if self.control is None else self.control.name,
            scheduler_holder="" if self.scheduler is None else self.scheduler.name,
            channels=len(self.queues),
            exclusive=self.exclusive,
            time_ns=can.line.timeline.now_ns,
            set_by="" if self._setter is None or can.mode is None else self._setter.name,
            set_by_left=self._setter is not None and not self.used_by(self._setter),
        )


@dataclass(eq=False)
class HeldScheduler(OnLine):
    """The lease on a line's cyclic list."""

    turn = Turn.SCHEDULER
    slot: CanSlot
    cyclic: CyclicList

    def leave(self) -> None:
        self.cyclic.close()
        self.slot.scheduler = None


@dataclass(eq=False)
class HeldShare(OnLine):
    """A line that somebody has open for reading or writing."""

    turn = Turn.SHARE
    slot: CanSlot
    share: Share

    def leave(self) -> None:
        self.slot.sharing.close(self.share)
