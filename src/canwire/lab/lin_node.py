"""A LIN node on the bench: a master that asks, or a slave that answers; with or without asyncio."""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping
from typing import TYPE_CHECKING

from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMode, LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.boards.lin.schedule import LinScheduler
from canwire.drivers.lin_driver import LinCounters, LinSettings
from canwire.errors import BadValue, Closed, NotReceived, QueueFull, WrongState
from canwire.lab.listening import Listening
from canwire.lab.spans import nanoseconds
from canwire.timeline import NEVER
from canwire.values.lin.event import LinEvent, LinEventKind, LinState
from canwire.values.lin.frame import LinFrame, go_to_sleep_frame

if TYPE_CHECKING:
    from canwire.lab.bench import Lab
    from canwire.lab.lin import LabLinBus

Responses = Mapping[int, bytes | LinFrame]
_EVENT_QUEUE = 4096
_TRANSMIT_QUEUE = 16_384


class LabSchedule(LinScheduler):
    """boards/lin/schedule.py, on a timeline that may be paced."""

    def __init__(self, lab: Lab, line: LinLine) -> None:
        super().__init__(line, {})
        self._lab = lab

    def start(self, name: str | None = None, *, rounds: int | None = None) -> None:
        with self._lab.touch():
            super().start(name, rounds=rounds)

    def stop(self) -> None:
        with self._lab.touch():
            super().stop()

    def request(self, data: bytes, *, responses: int = 1) -> None:
        with self._lab.touch():
            super().request(data, responses=responses)


class LabLinNode:
    """One LIN controller with one queue of what it hears. Made by `LabLinBus.master` and `LabLinBus.slave`.

    `schedule` is a master's: `start`, `stop`, `request` and the rest of it.
    """

    def __init__(
        self,
        lab: Lab,
        bus: LabLinBus,
        name: str,
        line: LinLine,
        settings: LinSettings,
        enhanced: bool,
        self_reception: bool,
        receive_queue: int,
    ) -> None:
        self.name = name
        self.bus = bus
        self.line = line
        self.settings = settings
        self._lab = lab
        self._enhanced = enhanced
        self._closed = False
        self._events: LinMonitor | None = None
        self._queue: deque[LinFrame | None] = deque()
        line.initialise(LinMode(settings.master, settings.bit_rate, errors=True), settings)
        self.schedule = LabSchedule(lab, line)
        self._monitor = self._open(LinMonitorMode(receive_queue, own=self_reception, events=()))
        self._ring = self._monitor.ring

    # sending

    def send(self, frame: LinFrame) -> None:
        """Queue a frame: a header with its data behind it, or alone. A master's; it goes when the bus is free.

        Raises WrongState for a slave, which only answers, QueueFull, Closed.
        """
        self._check_open()
        if not self.settings.master:
            raise WrongState(f"{self.line.name}: a slave sends nothing by itself; use respond, or wake")
        self._enqueue(frame)

    def ask(self, id: int, length: int = 0) -> None:
        """Queue a header, for others to answer with `length` bytes (0: as many as come). Raises like `send`."""
        self.send(LinFrame(id, header_only=True, length=length))

    def sleep(self) -> None:
        """Queue the go-to-sleep command. Raises like `send`."""
        self.send(go_to_sleep_frame())

    def wake(self) -> None:
        """Wake the bus up; a slave repeats the pulse until a header comes. A master's waits for its turn."""
        self._check_open()
        if self.settings.master:
            self._enqueue(None)
        else:
            with self._lab.touch():
                self.line.wake_up()
        self._lab.active()

    def respond(
        self, id: int, data: bytes | LinFrame, *, enhanced: bool | None = None, once: bool = False
    ) -> None:
        """Answer this header with these data from now on, or once; effective for the next header.

        The checksum is the node's usual one unless `enhanced`, or the frame given as data, says otherwise.
        Raises BadFrame.
        """
        self._check_open()
        frame = self._response(id, data, enhanced)
        with self._lab.touch():
            self.line.driver.respond(frame, once=once)

    def withdraw(self, id: int) -> None:
        """Answer this header no more."""
        self._check_open()
        with self._lab.touch():
            self.line.driver.withdraw(id)

    def subscribe(self, id: int, length: int) -> None:
        """Expect a frame of this length (1..8) behind this header; its absence is an error from now on."""
        self._check_open()
        with self._lab.touch():
            self.line.driver.subscribe(LinFrame(id).id, LinFrame(id, header_only=True, length=length).length)

    @property
    def pending(self) -> int:
        """Frames that wait for the bus, the one on it included."""
        return len(self._queue) + self.line.busy

    # receiving

    def receive(self, timeout: float | None = None) -> LinFrame | None:
        """The oldest frame heard, or None.

        With a `timeout` in seconds, time passes until a frame arrives or the timeout is over.
        """
        frame = self._take()
        if frame is None and self._closed:
            raise Closed(f"node {self.name}")
        if frame is None and timeout is not None:
            deadline_ns = self._lab.now_ns + nanoseconds("timeout", timeout)
            with Listening(self._ring, self._lab.timeline.halt):
                self._lab.advance(deadline_ns, lambda: self._ring.fill() > 0)
            frame = self._take()
        return frame

    def receive_many(self, limit: int) -> list[LinFrame]:
        """Up to `limit` frames, oldest first; takes only what is there."""
        frames: list[LinFrame] = []
        while len(frames) < limit and (frame := self._take()) is not None:
            frames.append(frame)
        return frames

    async def receive_async(self, timeout: float | None = None) -> LinFrame | None:
        """The oldest frame, waiting for one; None after `timeout` seconds. Cancelled, it takes nothing."""
        deadline_ns = NEVER if timeout is None else self._lab.now_ns + nanoseconds("timeout", timeout)
        with Listening(self._ring, self._lab.active):
            while True:
                self._check_open()
                frame = self._take()
                if frame is not None or self._lab.now_ns >= deadline_ns:
                    return frame
                await self._lab.turn(deadline_ns)

    async def __aiter__(self) -> AsyncIterator[LinFrame]:
        while not self._closed:
            frame = await self.receive_async()
            if frame is not None:
                yield frame

    def expect(self, id: int, *, within: float, data: bytes | None = None) -> LinFrame:
        """Let time pass until this frame arrives, dropping others; raises NotReceived, saying what came instead."""
        deadline_ns = self._lab.now_ns + nanoseconds("within", within)
        others: list[LinFrame] = []
        while True:
            frame = self.receive(max(0.0, (deadline_ns - self._lab.now_ns) / 1e9))
            if frame is None:
                break
            if frame.id == id and (data is None or frame.data == data):
                return frame
            others.append(frame)
        came = ", ".join(repr(frame) for frame in others[-5:]) or "nothing"
        raise NotReceived(
            f"{self.line.name}: no frame {id:#04x} within {within:g} s; {len(others)} others, last: {came}"
        )

    def expect_nothing(self, *, within: float) -> None:
        """Let time pass; raises NotReceived if any frame arrives."""
        frame = self.receive(within)
        if frame is not None:
            raise NotReceived(f"{self.line.name}: {frame!r} arrived where silence was expected")

    def events(self, *kinds: LinEventKind) -> list[LinEvent]:
        """What else happened to this node since the last call (errors, sleep, wake-up); all, or these kinds.

        The first call starts the recording, so call it once before what you want to see.
        """
        if self._events is None:
            self._events = self._open(LinMonitorMode(_EVENT_QUEUE, frames=False))
        found = []
        while (event := self._events.take()) is not None:
            if isinstance(event, LinEvent) and (not kinds or event.kind in kinds):
                found.append(event)
        return found

    # state

    @property
    def counters(self) -> LinCounters:
        return self.line.driver.counters(self._lab.timeline.now_ns)

    @property
    def state(self) -> LinState:
        return self.line.controller.state(self._lab.timeline.now_ns)

    @property
    def bit_rate(self) -> int:
        """In bit/s; 0 while a slave looks for it."""
        return self.counters.bit_rate

    @property
    def response_error(self) -> bool:
        """An error was seen in a response that this node sent or subscribes to, and was not reported yet."""
        return self.counters.response_error

    @property
    def accepted(self) -> int:
        """Frames heard: those read, those that wait, and those lost."""
        return self._monitor.accepted

    @property
    def waiting(self) -> int:
        """Frames heard and not read."""
        return self._ring.fill()

    @property
    def lost(self) -> int:
        """Frames that found the receive queue full."""
        return self._monitor.lost

    def stop(self) -> None:
        """Leave the bus at once; a schedule stops, and what is queued is given up."""
        with self._lab.touch():
            self.schedule.stop()
            self._queue.clear()
            self.line.leave()

    def start(self) -> None:
        """Take part again, awake."""
        self._check_open()
        with self._lab.touch():
            self.line.start()

    def close(self) -> None:
        """Leave the bus for good; a second time does nothing."""
        if not self._closed:
            self._closed = True
            self.schedule.stop()
            self._queue.clear()
            self.line.leave()
            self._lab.active()

    def on_frames(self, callback: Callable[[], None] | None) -> None:
        """Call back, within the bus's run, when the empty receive queue gets a frame; None ends it."""
        self._ring.listener = callback

    def set_up(
        self,
        subscribes: Mapping[int, int],
        events: Mapping[int, int],
        response_error: tuple[int, int] | None,
    ) -> None:
        """What `LabLinBus.slave` says of these; raises BadFrame for identifiers and lengths that cannot be."""
        with self._lab.touch():
            for id, length in subscribes.items():
                self.subscribe(id, length)
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

    def _open(self, mode: LinMonitorMode) -> LinMonitor:
        with self._lab.touch():
            monitor = self.line.open(LinMonitor(mode))
            self.line.activate(monitor)
        return monitor

    def _take(self) -> LinFrame | None:
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
        with self._lab.touch():
            self._queue.append(item)
            self._send_next()
        self._lab.active()

    def _send_next(self) -> None:
        """Hand the next queued frame (None: a wake-up pulse) to the line, if that is free."""
        if self._queue and self.line.running and not self.line.busy:
            item = self._queue.popleft()
            if item is None:
                self.line.wake_up()
            else:
                self.line.send(item)
        self.line.when_free = self._send_next if self._queue else None

    def _check_open(self) -> None:
        if self._closed:
            raise Closed(f"node {self.name}")
