"""One LIN connector with its controller: set up, started and stopped by one client, with any number of monitors.

States: undefined, `initialise` -> stopped, `start` -> running, `stop` -> stopped, `reset` -> undefined.
Source: VCI V4 manual 5.3, 6.7.2 and 7.4; .NET manual 4.3; rulings 4 and 7.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.boards.description import LinCapabilities
from canwire.boards.lin.description import USB_TO_CAN_FD_LIN
from canwire.boards.lin.modes import LinLineStatus, LinMode, check_mode
from canwire.boards.lin.monitor import LinMonitor
from canwire.boards.lin.splitter import LinSplitter
from canwire.boards.lin.wake import WakeUp
from canwire.chips.lin.controller import LinController
from canwire.chips.lin.host import LinHost
from canwire.drivers.lin_driver import LinDriver, LinSettings
from canwire.errors import BadFrame, Busy, CanwireError, NotInitialised, WrongState
from canwire.timeline import Timeline
from canwire.values.event import InfoCode
from canwire.values.lin.event import (
    OVERRUN_STATUS,
    PENDING_STATUS,
    LinErrorKind,
    LinEvent,
    LinEventKind,
    LinOutcome,
    LinState,
)
from canwire.values.lin.frame import LinFrame, go_to_sleep_frame

_LOOK_AGAIN_NS = 200_000  # the interval between checks while the line waits for a frame's end

Done = Callable[[int | CanwireError], None]
Finished = Callable[[LinOutcome], None]


class LinLine(LinHost):
    """Splitter between one controller and its monitors, and the control over it. No I/O; times are the timeline's.

    Its creator sets `driver`. `busy` is true until the last frame sent has ended. `when_awake` is called when a
    sleep ends, `when_free` when the line is no longer busy, `when_cleared` when settings and responses are discarded.
    """

    driver: LinDriver

    def __init__(
        self, name: str, timeline: Timeline, capabilities: LinCapabilities = USB_TO_CAN_FD_LIN
    ) -> None:
        self.name = name
        self.timeline = timeline
        self.capabilities = capabilities
        self.busy = False
        self.mode: LinMode | None = None
        self.when_awake: Callable[[], None] | None = None
        self.when_free: Callable[[], None] | None = None
        self.when_cleared: Callable[[], object] = lambda: None
        self._splitter = LinSplitter(timeline, capabilities.stamps.tick_ns)
        self.controller = LinController(self, self._splitter)
        self._told = (LinState.STOPPED, 0)
        self._finished: Finished | None = None
        self._stopping: list[Done] = []
        self._wake = WakeUp(timeline, self._pulse, lambda: self.controller.headers, self._wake_failed)
        self._wake_failures = 0

    # control

    @property
    def running(self) -> bool:
        return self.controller.running

    def initialise(self, mode: LinMode, settings: LinSettings | None = None) -> None:
        """Reset and set up; `settings` are more detailed than `mode`. Raises BadValue, Unsupported."""
        settings = settings or LinSettings(mode.master, mode.bit_rate)
        check_mode(mode, self.capabilities, self.name)
        self._clear()
        self.driver.configure(settings)
        self.mode = mode

    def start(self) -> None:
        """Start to take part in the bus; does nothing if the line runs already. Raises NotInitialised."""
        self._check_initialised("started")
        if self.running:
            return
        now_ns = self.timeline.now_ns
        self._splitter.begin_stamps()
        self._wake_failures = 0
        self.tell(self._event(LinEventKind.INFO, now_ns, code=InfoCode.STARTED))
        self.driver.start(now_ns)

    def stop(self, done: Done) -> None:
        """Leave the bus; `done(0)` is called when a frame that the line is sending has ended. Responses stay."""
        if not self.running:
            done(0)
            return
        self._stopping.append(done)
        self._stop_when_quiet()

    def leave(self) -> None:
        """Leave the bus immediately, even in the middle of a bit; settings and responses stay."""
        self._wake.cancel()
        self.driver.stop(self.timeline.now_ns)

    def reset(self) -> None:
        """Leave the bus immediately, discard settings and response table; messages in the monitors stay."""
        self._clear()
        self.tell(self._event(LinEventKind.INFO, 0, code=InfoCode.RESET), stamped=False)

    def write(self, frame: LinFrame, *, send: bool, finished: Finished | None = None) -> None:
        """Put a frame on the bus (`send`, a master only), or its data into the response table.

        A frame to send waits until the bus is free: it has data, or is a header that any node may answer;
        `finished` gets the outcome. The table may be changed at any time once the line is initialised.
        Raises NotInitialised, WrongState (a slave, or not started), Busy, BadFrame for a header without data.
        """
        if send:
            self.send(frame, finished)
            return
        self._check_initialised("given responses")
        if frame.header_only:
            raise BadFrame(f"{self.name}: {frame!r}: a response has data")
        self.driver.respond(frame)

    def send(self, frame: LinFrame, finished: Finished | None = None) -> None:
        """The same as `write` with `send`."""
        if frame.header_only:
            self.ask(frame.id, frame.length, finished)
        else:
            self._check_sending()
            self.busy = True
            self._finished = finished
            self.driver.send(frame)

    def ask(
        self, id: int, length: int, finished: Finished | None = None, silence_is_fine: bool = False
    ) -> None:
        """The same as `send` for a header alone; with `silence_is_fine` a missing response is no error."""
        mode = self.mode
        if self.busy or self._stopping or mode is None or not mode.master or not self.controller.running:
            self._check_sending()
        self.busy = True
        self._finished = finished
        self.driver.ask(id, length, silence_is_fine)

    def go_to_sleep(self, finished: Finished | None = None) -> None:
        """Send the go-to-sleep command, after which all nodes sleep. Raises errors like `write`."""
        self.send(go_to_sleep_frame(), finished)

    def wake_up(self) -> None:
        """Send a wake-up pulse; a slave repeats it until a header comes. Raises WrongState, Busy."""
        self._check_sending(only_wake_up=True)
        if self.mode is not None and self.mode.master:
            self._pulse()
        else:
            self._wake.begin()

    def status(self) -> LinLineStatus:
        """The present state of the line."""
        now_ns, bus = self.timeline.now_ns, self.controller.bus
        counters = self.driver.counters(now_ns)
        errors = list(counters.errors)
        errors[LinErrorKind.WAKEUP] += self._wake_failures
        return LinLineStatus(
            initialised=self.mode is not None,
            running=self.running,
            mode=self.mode,
            state=counters.state,
            status=self._status(),
            bit_rate=counters.bit_rate,
            load=0.0 if bus is None else bus.load_percent(),
            transmitting=self.driver.on_wire() or self.busy,
            headers=counters.headers,
            frames_sent=counters.frames_sent,
            frames_received=counters.frames_received,
            errors=tuple(errors),
            lost=self._splitter.lost,
            monitors=len(self._splitter.monitors),
            time_ns=now_ns,
        )

    def close(self) -> None:
        """End every pending call: the board was unplugged."""
        self._clear()

    def open(self, monitor: LinMonitor) -> LinMonitor:
        """Put a monitor on the line; it receives while it is active."""
        self._splitter.open(monitor)
        return monitor

    def dismiss(self, monitor: LinMonitor) -> None:
        """Remove a monitor from the line; unknown ones are ignored."""
        self._splitter.dismiss(monitor)

    def activate(self, monitor: LinMonitor, active: bool = True) -> None:
        """Start or stop the delivery of messages to a monitor."""
        monitor.active = active
        self._splitter.sort()

    def tell(self, event: LinEvent, *, stamped: bool = True) -> None:
        """Deliver an event to every active monitor; without `stamped` its time does not change."""
        self._splitter.tell(event, stamped=stamped)

    def error(self, kind: int, id: int, transmitting: bool, at_ns: int) -> None:
        if self.mode is not None and self.mode.errors:
            self.tell(self._event(LinEventKind.ERROR, at_ns, LinErrorKind(kind), id, transmitting))

    def state_changed(self, at_ns: int) -> None:
        now = (self.controller.state(at_ns), self.controller.status())
        if now != self._told:
            before, self._told = self._told, now
            self.tell(self._event(LinEventKind.STATE, at_ns))
            if now[0] is LinState.INITIALISING:
                self.timeline.at(self.controller.ready_ns, self._look_at_state, background=True)
            if now[0] is LinState.ASLEEP and before[0] is not LinState.ASLEEP:
                self.tell(self._event(LinEventKind.SLEEP, at_ns))
            if before[0] is LinState.ASLEEP and self.running and self.when_awake is not None:
                self.when_awake()

    def woken(self, at_ns: int) -> None:
        self.tell(self._event(LinEventKind.WAKEUP, at_ns))
        self.state_changed(at_ns)

    def finished(self, id: int, outcome: LinOutcome, at_ns: int) -> None:
        self.busy = False
        finished, self._finished = self._finished, None
        if id < 0 and self.running and self.mode is not None and not self.mode.master:
            self._wake.sent()
        if finished is not None:
            finished(outcome)
        if self.when_free is not None:
            self.when_free()

    def _check_initialised(self, what: str) -> None:
        if self.mode is None:
            raise NotInitialised(f"{self.name}: initialise the line before it is {what}")

    def _check_sending(self, *, only_wake_up: bool = False) -> None:
        """Raise an error if the line cannot send now."""
        self._check_initialised("told to send")
        if not self.running:
            raise WrongState(f"{self.name}: start the line before something is sent")
        if not only_wake_up and not (self.mode is not None and self.mode.master):
            raise WrongState(
                f"{self.name}: a slave sends nothing but wake-up pulses; initialise the line as master"
            )
        if self.busy or self._stopping:
            raise Busy(self.name)

    def _look_at_state(self) -> None:
        self.state_changed(self.timeline.now_ns)

    def _pulse(self) -> None:
        if self.running and not self.busy:
            self.busy = True
            self.driver.wake_up()

    def _wake_failed(self) -> None:
        self._wake_failures += 1
        self.error(LinErrorKind.WAKEUP, -1, True, self.timeline.now_ns)

    def _clear(self) -> None:
        """Leave the bus at this moment, and discard settings and responses."""
        self.leave()
        self.when_cleared()
        self.driver.clear()
        self.mode = None
        self._splitter.end_stamps()
        self._stopped()

    def _stop_when_quiet(self) -> None:
        if self.running and (self.busy or self.driver.on_wire()):
            self.timeline.at(self.timeline.now_ns + _LOOK_AGAIN_NS, self._stop_when_quiet)
        elif self._stopping:
            self.leave()
            self.tell(self._event(LinEventKind.INFO, 0, code=InfoCode.STOPPED), stamped=False)
            self._stopped()

    def _stopped(self) -> None:
        waiting, self._stopping = self._stopping, []
        for done in waiting:
            done(0)

    def _event(
        self,
        kind: LinEventKind,
        at_ns: int,
        error: LinErrorKind = LinErrorKind.NONE,
        id: int = -1,
        transmitting: bool = False,
        code: int = 0,
    ) -> LinEvent:
        state = self.controller.state(at_ns)
        return LinEvent(kind, at_ns, error, state, id, transmitting, self._status(), code)

    def _status(self) -> int:
        """The present state as VCI's LIN_STATUS_ bits."""
        pending = PENDING_STATUS if self.driver.on_wire() or self.busy else 0
        return self.controller.status() | pending | (OVERRUN_STATUS if self._splitter.lost else 0)
