"""The half of the ACAN driver in the program: one line of the hub, and this program's task blocks.

Source: INduCAN104 manual, "General operation of drivers and applications", "Programming interface".
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import canwire
from canwire import (
    ABORT_ON_ERROR,
    LOOP_BACK,
    BadFrame,
    BadValue,
    CanwireError,
    Closed,
    ErrorState,
    Frame,
    NotInitialised,
    QueueFull,
)
from canwire.acan.constants import CANC_SJA1000, Condition
from canwire.acan.dispatch import EVERY_INTERRUPT, Dispatch
from canwire.acan.hard_config import HardConfig, noted_config, noted_interrupts
from canwire.acan.install import find_line
from canwire.acan.line import AcanLine
from canwire.acan.service import Service, notify, patiently

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager
    from types import TracebackType

    from canwire import Hub
    from canwire.acan.task_block import TaskBlock

LOWEST_PRIORITY = 255
_REPLY_PRIORITY = 1
_BATCH = 64  # arrivals handled before applications are notified


def open_driver(hub: Hub | None = None, board: str | None = None) -> Driver:
    """The driver of the installed board (install.py), or of the board named `board`; without `hub` it connects with
    `canwire.connect()`.

    Raises DriverAbsent if no board is suitable, NoSuchBoard if no board has that name, HubLost.
    """
    if hub is not None:
        return Driver(hub, board)
    own = canwire.connect()
    try:
        return Driver(own, board, own_hub=True)
    except BaseException:
        own.close()
        raise


class Driver:
    """The driver as an application uses it, from any thread; blocks are notified on the service thread (service.py).
    After `close` each call raises Closed; once the hub or the board is gone, HubLost or Unplugged."""

    version = (1, 0)
    controller = CANC_SJA1000

    def __init__(self, hub: Hub, board: str | None = None, *, own_hub: bool = False) -> None:
        self.hub = hub
        self._own_hub = own_hub
        self._line = AcanLine(hub, *find_line(hub, board))
        self.bus = self._line.bus
        self._service = Service(hub, f"ACAN on {self._line.name}", self._work)
        self._dispatch = Dispatch(self._line.status().state, self._reply, self._interrupts)
        self._failure: CanwireError | None = None
        self._line.assign(self._service.event)
        self._service.start()

    @property
    def lost(self) -> bool:
        """Whether the driver is closed, or the hub or the board is gone."""
        return self._failure is not None or self.hub.lost

    # the controller

    @property
    def initialised(self) -> bool:
        self._check()
        return self._line.status().initialised

    @property
    def on_bus(self) -> bool:
        """Whether the controller takes part in the bus: it is started, and not in bus-off."""
        self._check()
        status = self._line.status()
        return status.running and status.state != ErrorState.BUS_OFF

    def configure(self, config: HardConfig) -> None:
        """Configure the controller for all programs; it is off the bus afterwards, even if it was on.

        Raises InUse while another program configures the line or holds its control, and while programs of another
        dialect run it at another rate.
        """
        self._check()
        patiently(self._line.hub, partial(self._line.configure, config))

    def config(self) -> HardConfig | None:
        """The controller's configuration, also of other programs, or None; BadTiming for a rate not in whole kbit/s."""
        self._check()
        mode = self._line.status().mode
        if mode is None or mode.timing is None:
            return None
        return noted_config(mode.note, mode.timing, dict(mode.registers), self._line.registers())

    def bus_on(self) -> bool:
        """Join the bus with error counters at 0 and empty transmit queues; returns whether it was on the bus before.

        If it was, nothing changes. Raises NotInitialised, InUse.
        """
        self._check()
        status = self._line.status()
        if not status.initialised:
            raise NotInitialised(f"{self._line.name}: configure it first")
        bus_off = status.running and status.state == ErrorState.BUS_OFF
        if status.running and not bus_off:
            return True
        if bus_off:
            self._line.recover()
        else:
            patiently(self._line.hub, self._line.start)
        return False

    def bus_off(self) -> bool:
        """Leave the bus; returns whether the controller was on the bus before. Raises InUse."""
        self._check()
        status = self._line.status()
        if status.running:
            with self._dispatch.own_stop():
                patiently(self._line.hub, self._line.stop)
        return status.running and status.state != ErrorState.BUS_OFF

    def hold_filters(self) -> AbstractContextManager[None]:
        """A context: while entered, only this driver configures the controller and takes it on or off the bus.

        Programs that need their own filters use it, such as CANSPY. Raises InUse if another program has the control.
        """
        self._check()
        return self._line.hold()

    # messages

    def send(self, frame: Frame, priority: int = 1, timeout: float | None = 0) -> None:
        """Queue a frame: it is sent after the frames of smaller `priority` (0..255) and after older ones of the same.

        A frame that meets a bus error is discarded. A frame of priority 0 also goes to the task blocks of this line
        in each program. Waits up to `timeout` seconds (None: without limit) for room, and again if another thread
        uses that room first. Raises QueueFull, BadValue, and BadFrame for a CAN FD frame.
        """
        self._check()
        if not isinstance(priority, int) or not 0 <= priority <= LOWEST_PRIORITY:
            raise BadValue(f"priority (bPrio) {priority!r}: a whole number from 0 to {LOWEST_PRIORITY}")
        if frame.fd:
            raise BadFrame(f"{frame!r}: ACAN sends classic frames only")
        flags = ABORT_ON_ERROR | (LOOP_BACK if priority == 0 else 0)
        while True:
            try:
                return self._put(frame, flags, priority)
            except QueueFull:
                if timeout == 0 or not self._line.wait_for_room(timeout):
                    raise

    # task blocks

    @property
    def blocks(self) -> tuple[TaskBlock, ...]:
        """The registered blocks, in the order in which they were registered and receive frames."""
        return tuple(self._dispatch.blocks)

    def register(self, block: TaskBlock) -> TaskBlock:
        """Register a block, which then receives what passes its filters; `with` deregisters it at its end.

        Raises WrongState if it is registered already, BadValue if a channel's variable became too short.
        """
        with self._service.lock:
            self._check()
            block.attach(self)
            self._dispatch.blocks.append(block)
        return block

    def deregister(self, block: TaskBlock) -> None:
        """Deregister a block, and wake the threads that wait for it. A block that is not registered here is ignored."""
        with self._service.lock:
            if block in self._dispatch.blocks:
                self._dispatch.blocks.remove(block)
                block.detach()
        self._service.changed()

    def pump(self) -> None:
        """On a hub in virtual time: handle what has arrived by now. Otherwise the service thread does that."""
        self._check()
        if self._service.here:
            self._work()
            self._check()

    # for blocks

    @property
    def lock(self) -> AbstractContextManager[object]:
        return self._service.lock

    def wait(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """See task_block.py, Keeper."""
        return self._service.wait(partial(self._ready, ready), timeout)

    # the end

    def close(self) -> None:
        """Deregister all blocks and release the line, which stays as it is; a second call does nothing."""
        if isinstance(self._failure, Closed):
            return
        with self._service.lock:
            for block in self.blocks:
                self.deregister(block)
            self._failure = Closed(f"ACAN driver on {self._line.name}")
        self._service.stop()
        self._line.close()
        self._service.close()
        if self._own_hub:
            self.hub.close()

    def __enter__(self) -> Driver:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<ACAN driver on {self._line.name}, {len(self.blocks)} task blocks>"

    # its own

    def _check(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _ready(self, ready: Callable[[], bool]) -> bool:
        if ready():
            return True
        self._check()
        return False

    def _work(self) -> bool:
        """Handle all that has arrived and notify; False if nothing more can arrive."""
        try:
            while (due := self._take_some()) is not None:
                for block in due:
                    notify(block)
        except CanwireError as error:
            with self._service.lock:
                self._failure = self._failure or error
                self._service.changed()
        return self._failure is None

    def _take_some(self) -> list[TaskBlock] | None:
        """Handle what has arrived; returns the blocks to notify after the lock is released, None if nothing arrived.

        It stops early if a block that must be notified has a FIFO half full, so that its application can empty it.
        """
        due: list[TaskBlock] = []
        with self._service.lock:
            for taken in range(_BATCH):
                arrival = None if self._failure is not None else self._line.receive()
                if arrival is None:
                    if taken == 0:
                        return None
                    break
                due += self._dispatch.take(arrival)
                if any(2 * block.occupation >= block.size for block in due):
                    break
            self._service.changed()
        return due

    def _interrupts(self) -> int:
        """The IER that an ACAN program set, else the controller's; all interrupts if the controller shows no IER."""
        noted = noted_interrupts(self._line.status().mode)
        return self._line.registers().get("IER", EVERY_INTERRUPT) if noted is None else noted

    def _reply(self, frame: Frame, looped: bool) -> None:
        """Send a channel's answer. Without room it is lost, and blocks with NOBUFF in their conditions are notified."""
        try:
            self._put(frame, ABORT_ON_ERROR | (LOOP_BACK if looped else 0), _REPLY_PRIORITY)
        except QueueFull:
            self._dispatch.raise_condition(Condition.NOBUFF)

    def _put(self, frame: Frame, flags: int, priority: int) -> None:
        with self._service.sending:
            self._line.send(frame, flags, priority)
