"""A LIN node of a lab: a master that sends headers, or a slave that answers."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from types import NoneType
from typing import TypeVar

from canwire.boards.lin.configured import ConfiguredSlave
from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMode, LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.drivers.lin_driver import LinCounters, LinSettings
from canwire.errors import BadValue, QueueFull, WrongState
from canwire.lab.lin.schedule import LabSchedule
from canwire.lab.node import BenchNode
from canwire.lab.time import LabTime
from canwire.values.checks import instance
from canwire.values.lin.configuration import LinNodeAttributes, LinSlaveConfiguration
from canwire.values.lin.event import LinEvent, LinEventKind, LinState
from canwire.values.lin.frame import MASTER_REQUEST, SLAVE_RESPONSE, LinFrame, go_to_sleep_frame
from canwire.values.mistakes.names import answers_wrong_names

BusT = TypeVar("BusT")
Responses = Mapping[int, bytes | LinFrame]
_EVENT_QUEUE = 4096
_TRANSMIT_QUEUE = 16_384


@answers_wrong_names
class LinBenchNode(BenchNode[LinFrame, BusT]):
    """The base class of LabLinNode: one controller with one receive queue."""

    def __init__(
        self,
        time: LabTime,
        bus: BusT,
        name: str,
        line: LinLine,
        settings: LinSettings,
        enhanced: bool,
        self_reception: bool,
        receive_queue: int,
    ) -> None:
        line.initialise(LinMode(settings.master, settings.bit_rate, errors=True), settings)
        self._monitor = _opened(line, LinMonitorMode(receive_queue, own=self_reception, events=()), time)
        super().__init__(time, bus, name, line.name, self._monitor.ring, self._heard)
        self.line = line
        self.settings = settings
        self.schedule = LabSchedule(time, line)
        self._enhanced = enhanced
        self._events: LinMonitor | None = None
        self._queue: deque[LinFrame | None] = deque()
        self._configured: ConfiguredSlave | None = None

    # sending

    def send(self, frame: LinFrame) -> None:
        """Masters only: queue a header with or without data; it is sent when the bus is free.

        Raises WrongState for a slave, QueueFull, Closed.
        """
        self._check_open()
        instance("frame", frame, LinFrame)
        if not self.settings.master:
            raise WrongState(f"{self.line.name}: a slave sends nothing by itself; use respond, or wake")
        self._enqueue(frame)

    def ask(self, id: int, length: int = 0) -> None:
        """Queue a header, for an answer of `length` bytes (0: any number). Raises the errors of `send`."""
        self.send(LinFrame(id, header_only=True, length=length))

    def sleep(self) -> None:
        """Queue the go-to-sleep command. Raises the errors of `send`."""
        self.send(go_to_sleep_frame())

    def wake(self) -> None:
        """Wake the bus up; a slave repeats the pulse until a header comes, a master queues it."""
        self._check_open()
        if self.settings.master:
            self._enqueue(None)
        else:
            with self.time.touch():
                self.line.wake_up()
        self.time.active()

    def respond(
        self, id: int, data: bytes | LinFrame, *, enhanced: bool | None = None, once: bool = False
    ) -> None:
        """Answer this header with these data, from the next header on, or `once`.

        `enhanced`, or a frame given as data, sets the checksum; without them the node uses its default.
        Raises BadFrame.
        """
        self._check_open()
        frame = self._response(id, data, enhanced)
        with self.time.touch():
            self.line.driver.respond(frame, once=once)

    def withdraw(self, id: int) -> None:
        """Do not answer this header from now on."""
        self._check_open()
        with self.time.touch():
            self.line.driver.withdraw(LinFrame(id).id)

    def subscribe(self, id: int, length: int, *, enhanced: bool | None = None) -> None:
        """Expect a frame of this length (1..8) after this header; a missing one is an error from now on.

        A wrong checksum is an error too: `enhanced` sets it (None: the node's default); diagnostic frames use classic.
        """
        self._check_open()
        header = LinFrame(id, header_only=True, length=length)
        with self.time.touch():
            self.line.driver.subscribe(header.id, header.length)
        self.expect_checksum(id, self._enhanced if enhanced is None else enhanced)

    def expect_checksum(self, id: int, enhanced: bool | None) -> None:
        """Accept this frame only with the enhanced (True) or classic (False) checksum; None: with either."""
        self._check_open()
        classic = id in (MASTER_REQUEST, SLAVE_RESPONSE)
        with self.time.touch():
            self.line.driver.expect_checksum(LinFrame(id).id, False if classic else enhanced)

    @property
    def pending(self) -> int:
        """Number of frames that wait for the bus, including the one on the bus."""
        return len(self._queue) + self.line.busy

    # receiving

    def expect(self, id: int, *, within: float, data: bytes | None = None) -> LinFrame:
        """Let at most `within` seconds pass until this frame arrives, discarding others.

        Raises NotReceived with the frames that arrived instead.
        """

        def wanted(frame: LinFrame) -> bool:
            return frame.id == id and (data is None or frame.data == data)

        return self._expect(wanted, f"{id:#04x}", within)

    def events(self, *kinds: LinEventKind) -> list[LinEvent]:
        """Events of this node since the last call (errors, sleep, wake-up): all, or those of these kinds.

        The first call starts the recording, so call `events` once before the part of interest.
        """
        if self._events is None:
            self._events = _opened(self.line, LinMonitorMode(_EVENT_QUEUE, frames=False), self.time)
        found = []
        while (event := self._events.take()) is not None:
            if isinstance(event, LinEvent) and (not kinds or event.kind in kinds):
                found.append(event)
        return found

    def on_events(self, callback: Callable[[], None] | None) -> None:
        """Call `callback`, while the bus runs, when the empty queue of events gets one; None removes it.

        Effective once `events` has been called.
        """
        if self._events is not None:
            self._events.ring.listener = callback

    # node configuration

    @property
    def configuration(self) -> LinSlaveConfiguration | None:
        """The NAD of a slave and the identifiers of its frames; None without `attributes`."""
        return None if self._configured is None else self._configured.configuration

    def configure(self, attributes: LinNodeAttributes) -> None:
        """Answer node configuration and the transport layer from now on; called by `LabLinBus.slave`."""
        instance("attributes", attributes, LinNodeAttributes)
        with self.time.touch():
            self._configured = ConfiguredSlave(self.line, attributes)

    def power_up(self) -> None:
        """Restart as after a power failure: a configured slave returns to the NAD and identifiers saved last."""
        self._check_open()
        if self._configured is not None:
            with self.time.touch():
                self._configured.power_up()

    # state

    @property
    def counters(self) -> LinCounters:
        return self.line.driver.counters(self.time.timeline.now_ns)

    @property
    def state(self) -> LinState:
        return self.line.controller.state(self.time.timeline.now_ns)

    @property
    def bit_rate(self) -> int:
        """In bit/s; 0 while a slave detects it."""
        return self.counters.bit_rate

    @property
    def response_error(self) -> bool:
        """True if a response that this node sent or subscribes to had an error that was not reported yet."""
        return self.counters.response_error

    @property
    def accepted(self) -> int:
        """Number of frames received: frames read, waiting and lost."""
        return self._monitor.accepted

    @property
    def lost(self) -> int:
        """Number of frames lost because the receive queue was full."""
        return self._monitor.lost

    def stop(self) -> None:
        """Leave the bus immediately; a schedule stops, and queued frames are discarded."""
        with self.time.touch():
            self._leave()

    def start(self) -> None:
        """Join the bus again, awake."""
        self._check_open()
        with self.time.touch():
            self.line.start()

    def set_up(
        self,
        subscribes: Mapping[int, int],
        events: Mapping[int, int],
        response_error: tuple[int, int] | None,
        checksums: Mapping[int, bool],
    ) -> None:
        """See `LabLinBus.slave`; raises BadFrame for impossible identifiers and lengths."""
        instance("checksums", checksums, Mapping)
        instance("subscribes", subscribes, Mapping)
        instance("events", events, Mapping)
        instance("response_error", response_error, tuple, NoneType)
        with self.time.touch():
            for id, length in subscribes.items():
                self.subscribe(id, length)
            for id, enhanced in checksums.items():
                self.expect_checksum(id, enhanced)
            for event, id in events.items():
                self.line.driver.associate(LinFrame(event).id, LinFrame(id).id)
            if response_error is not None:
                id, bit = response_error
                if not 0 <= bit < 64:
                    raise BadValue(f"response_error bit {bit}: from 0 to 63")
                self.line.driver.report_errors_in(LinFrame(id).id, bit)

    def __repr__(self) -> str:
        kind = "master" if self.settings.master else "slave"
        return f"<{kind} {self.line.name}: {self.state.name}, {self.counters.headers} headers heard>"

    # inside

    def _leave(self) -> None:
        self.schedule.stop()
        self._queue.clear()
        self.line.leave()

    def _heard(self) -> LinFrame | None:
        message = self._monitor.take()
        return message if isinstance(message, LinFrame) else None

    def _response(self, id: int, data: bytes | LinFrame, enhanced: bool | None) -> LinFrame:
        if isinstance(data, LinFrame):
            if data.id != id:
                raise BadValue(f"response of {id:#04x}: {data!r} has another identifier")
            return data
        if enhanced is None and not self._enhanced:
            enhanced = False
        return LinFrame(id, data, enhanced=enhanced)

    def _enqueue(self, item: LinFrame | None) -> None:
        if len(self._queue) >= _TRANSMIT_QUEUE:
            raise QueueFull(self.line.name, _TRANSMIT_QUEUE)
        with self.time.touch():
            self._queue.append(item)
            self._send_next()
        self.time.active()

    def _send_next(self) -> None:
        """Hand the next queued frame (None: a wake-up pulse) to the line, if that is free."""
        if self._queue and self.line.running and not self.line.busy:
            item = self._queue.popleft()
            if item is None:
                self.line.wake_up()
            else:
                self.line.send(item)
        self.line.when_free = self._send_next if self._queue else None


def _opened(line: LinLine, mode: LinMonitorMode, time: LabTime) -> LinMonitor:
    with time.touch():
        monitor = line.open(LinMonitor(mode))
        line.activate(monitor)
    return monitor
