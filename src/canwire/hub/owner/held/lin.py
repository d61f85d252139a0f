"""The leases on a LIN line: one control, and any number of monitors or one exclusive monitor."""

from __future__ import annotations

from dataclasses import dataclass

from canwire.boards.lin.configured import ConfiguredSlave
from canwire.boards.lin.exchange import Answered, LinExchange
from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMode, LinMonitorMode, LinMonitorStatus
from canwire.boards.lin.monitor import LinMonitor
from canwire.boards.lin.schedule import LinScheduler
from canwire.errors import Busy, CanwireError, NotInitialised, WrongState
from canwire.hub.owner.held.held import Holder
from canwire.hub.owner.held.line import HeldQueue, LineSlot
from canwire.hub.owner.held.shared_ring import SharedRings
from canwire.platform import Descriptor
from canwire.values.lin.configuration import LinNodeAttributes
from canwire.values.lin.schedule import LinSchedule


class LinSlot(LineSlot):
    """A LIN line with the holders of its leases; the line is reset when the last lease ends."""

    queue_noun = "monitor"

    def __init__(self, board: int, lin: LinLine) -> None:
        super().__init__(board, lin.name)
        self.lin = lin
        self._scheduler: LinScheduler | None = None
        self._slave: ConfiguredSlave | None = None
        self._requesting = False

    def initialise(self, holder: Holder, mode: LinMode) -> None:
        """LinLine.initialise for a program that has the control; raises InUse if it may not change the rate."""
        now = self.lin.mode
        if now is not None and self.lin.running and now.bit_rate != mode.bit_rate:
            who = "nobody" if self.setter is None else self.setter.name
            rate = f"{now.bit_rate} bit/s, set by {who}"
            self.check_rate(holder, (now.kin, mode.kin), rate, f"{mode.bit_rate} bit/s")
        self.lin.initialise(mode)
        self.setter = holder

    def run_schedule(self, schedule: LinSchedule | None, rounds: int) -> None:
        """Run this table in place of the running one; None: only end the running one."""
        if self._scheduler is not None:
            self._scheduler.stop()
            self._scheduler = None
        if schedule is not None:
            self._scheduler = LinScheduler(self.lin, schedule)
            self._scheduler.start(schedule.name, rounds=rounds or None)

    def configure(self, attributes: LinNodeAttributes) -> None:
        """Answer node configuration from now on, until the line is next set up or reset. Raises WrongState."""
        mode = self.lin.mode
        if mode is None or mode.master:
            raise WrongState(f"{self.name}: initialise the line as slave before you configure it")
        self._slave = ConfiguredSlave(self.lin, attributes)

    @property
    def slave(self) -> ConfiguredSlave:
        """The slave that answers node configuration on this line; raises WrongState if none does."""
        if self._slave is None or not self._slave.answers:
            raise WrongState(f"{self.name}: it has no node configuration; use configure first")
        return self._slave

    def request(self, nad: int, payload: bytes, within_ns: int, done: Answered) -> None:
        """Send a request as master. Raises WrongState, NotInitialised, Busy while another request is not over."""
        if self._requesting:
            raise Busy(self.name)

        def over(result: bytes | CanwireError) -> None:
            self._requesting = False
            done(result)

        exchange = LinExchange(self.lin, nad, payload, within_ns, over)
        self._requesting = True
        try:
            exchange.begin()
        except CanwireError:
            self._requesting = False
            raise

    def settle(self) -> None:
        if self.control is None:
            self.run_schedule(None, 0)
            if not self.queues and not self.keepers:
                self.lin.reset()

    def close(self, why: CanwireError) -> None:
        self.run_schedule(None, 0)
        self.lin.close()


@dataclass(eq=False)
class HeldMonitor(HeldQueue):
    """A client's monitor: its queue once it is set up."""

    slot: LinSlot
    monitor: LinMonitor | None = None
    _queue: SharedRings | None = None

    def set_up(self, mode: LinMonitorMode) -> tuple[Descriptor, ...]:
        """Make a queue in new memory. Returns descriptors for the client: memory and event."""
        doorbell = self.holder.doorbell
        queue = SharedRings(
            mode.receive,
            0,
            exact=mode.exact,
            doorbell=doorbell,
            halts=self.holder.halts,
            bells=self.holder.bells,
        )
        self._forget()
        self._queue = queue
        self.monitor = LinMonitor(mode, ring=queue.receive)
        self.slot.lin.open(self.monitor)
        return queue.hand_over()

    def activate(self, active: bool) -> None:
        if self.monitor is not None:
            self.slot.lin.activate(self.monitor, active)
        elif active:
            raise NotInitialised(f"{self.slot.name}: set the monitor up before activating it")

    def status(self) -> LinMonitorStatus:
        return LinMonitorStatus(False, 0, 0, 0) if self.monitor is None else self.monitor.status()

    def leave(self) -> None:
        self._forget()
        self.slot.queues.remove(self)

    def _forget(self) -> None:
        if self.monitor is not None:
            self.slot.lin.dismiss(self.monitor)
        if self._queue is not None:
            self._queue.close()
        self.monitor = self._queue = None
