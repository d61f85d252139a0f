"""The leases on a CAN line except its channels: the cyclic list, and shares like those of Win32."""

from __future__ import annotations

from dataclasses import dataclass, replace

from canwire.boards.can.connector import CanLine, Done
from canwire.boards.can.modes import LineMode, LineStatus
from canwire.boards.can.rates import format_rates, format_setter, same_rates
from canwire.boards.can.scheduler import CyclicList
from canwire.boards.outside import obstacle_of
from canwire.boards.sharing import Share, Sharing
from canwire.bus.medium import delay_of
from canwire.errors import CanwireError
from canwire.hub.owner.held.held import Holder, Turn
from canwire.hub.owner.held.line import LineSlot, OnLine


class CanSlot(LineSlot):
    """A CAN line with the holders of its leases; the line is reset when the last lease ends."""

    queue_noun = "channel"

    def __init__(self, board: int, can: CanLine) -> None:
        super().__init__(board, can.line.name)
        self.can = can
        self.scheduler: Holder | None = None
        self.scheduler_kin = ""  # the interface of the program that holds the list
        info = can.info
        self.sharing = Sharing(can.line.name, info.receive_channels, info.send_channels)

    def settle(self) -> None:
        mode = self.can.mode
        if not self.keepers:
            self.can.release(self._kins())
        if (mode is not None and mode.persistent) or self.users() or len(self.sharing) or self.keepers:
            return
        if mode is not None and mode.keeps:
            self.can.abort_pending()
            self.can.stop(lambda _: None)
        else:
            self.can.abandon()

    def initialise(self, holder: Holder, mode: LineMode, done: Done) -> None:
        """CanLine.initialise for a program that has the control; raises InUse if it may not change the rate."""
        self._check_rate(holder, mode)
        before = self.can.mode
        if before is not None and before.persistent:
            mode = replace(mode, persistent=True)
        self.can.initialise(mode, done)
        self.setter = holder

    def _check_rate(self, holder: Holder, mode: LineMode) -> None:
        now = self.can.mode
        if now is not None and self.can.running and not same_rates(now, mode):
            rates = f"{format_rates(now)}, {format_setter(self.status())}"
            self.check_rate(holder, (now.kin, mode.kin), rates, format_rates(mode))

    def _kins(self) -> set[str]:
        """The interfaces of the programs that have a channel, the control or the cyclic list."""
        found = {held.kin for held in self.queues}
        if self.control is not None:
            found.add(self.control_kin)
        if self.scheduler is not None:
            found.add(self.scheduler_kin)
        return found

    def users(self) -> list[Holder]:
        return super().users() + ([] if self.scheduler is None else [self.scheduler])

    def close(self, why: CanwireError) -> None:
        self.can.close(why)

    def status(self, kin: str = "") -> LineStatus:
        """The status as programs of this interface see it."""
        can, driver = self.can, self.can.line.driver
        counters = driver.counters()
        return LineStatus(
            initialised=can.mode is not None,
            running=can.running,
            mode=can.in_effect(kin),
            state=counters.state,
            tec=counters.tec,
            rec=counters.rec,
            last_error=counters.last_error,
            load=can.load(),
            transmitting=can.line.pending(),
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
            set_by="" if self.setter is None or can.mode is None else self.setter.name,
            set_by_left=self.setter is not None and not self.used_by(self.setter),
            delay_ps=delay_of(can.bus),
            drift_ppm=can.crystal.drift_ppm,
            obstacle=obstacle_of(can.line),
            chip_timing=can.chip_timing,
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
    """The lease of a program that has the line open for reading or writing."""

    turn = Turn.SHARE
    slot: CanSlot
    share: Share

    def leave(self) -> None:
        self.slot.sharing.close(self.share)
