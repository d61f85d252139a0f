"""A CAN node on the bench: sends, receives, shows its counters."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Never, TypeVar

from canwire.boards.can.channel import Channel
from canwire.boards.can.line import Line
from canwire.boards.can.sending import Sending
from canwire.drivers.driver import Counters, Driver, LineSettings
from canwire.errors import BusOff, NotTransmitted
from canwire.lab.node import BenchNode
from canwire.lab.selection import FRAMES
from canwire.lab.time import LabTime
from canwire.timeline import NEVER
from canwire.values.acceptance import Acceptance
from canwire.values.arguments import unknown_argument
from canwire.values.checks import LONGEST_NS, check_expected, instance, whole
from canwire.values.event import BusEvent, ErrorState, EventKind
from canwire.values.frame import Frame, frame_of_record
from canwire.values.record import CONFIRM, HIGH_PRIORITY, SINGLE_SHOT
from canwire.values.records import check_dtype
from canwire.values.text import format_frame

if TYPE_CHECKING:
    import numpy

BusT = TypeVar("BusT")
_EVENT_QUEUE = 4096
_ALL_EVENTS = frozenset(int(kind) for kind in EventKind)


class CanBenchNode(BenchNode[Frame, BusT], Sending):
    """What LabNode does: one controller with one channel."""

    def __init__(
        self,
        time: LabTime,
        bus: BusT,
        name: str,
        line: Line,
        settings: LineSettings,
        acceptance: Acceptance | None,
        self_reception: bool,
        receives: bool,
        receive_queue: int,
        transmit_queue: int,
    ) -> None:
        channel = Channel(receive_queue, transmit_queue, frames=receives)
        channel.set_acceptance(acceptance)
        ring = channel.receive
        BenchNode.__init__(self, time, bus, name, line.name, ring, ring.take_frame)
        Sending.__init__(self, time, line, channel, self_reception)
        self.settings = settings
        self._events: Channel | None = None
        line.controller.name = name
        line.open(channel)

    def begin(self, resting: bool) -> None:
        """Configure and start; on a resting bus the node counts as having been there all along."""
        self._driver.configure(self.settings)
        self._driver.start(self.time.timeline.now_ns, integrated=resting)

    # sending: `send` and `send_many` are Sending's

    def send_array(self, records: numpy.ndarray) -> int:
        """Queue records of numpy dtype `record_dtype()`, as from `receive_array`; their time is a delay in ns.

        Returns how many fitted into the queue. Raises BadFrame for a record that is no frame of this line.
        """
        self._check_open()
        check_dtype(records)
        if self.time.selection is not None:
            return self._send_selected(records)
        with self.time.touch():
            count = self.line.send_records(self._channel, records, self._flags)
        self.time.active()
        return count

    def _send_selected(self, records: numpy.ndarray) -> int:
        places = [at for at in range(len(records)) if self._takes(frame_of_record(records[at].tobytes()))]
        count = self.line.send_records(self._channel, records[places], self._flags)
        self.time.active()
        return places[count] if count < len(places) else len(records)

    def _takes(self, frame: Frame) -> bool:
        """Is it sent? A frame that is left out counts as taken, and never reaches the queue."""
        selection = self.time.selection
        return selection is None or selection.takes(
            FRAMES, lambda: f"{self._full_name}: {format_frame(frame)}"
        )

    async def send_async(
        self, frame: Frame, *, single_shot: bool = False, high_priority: bool = False
    ) -> int:
        """Send and wait until the frame went through; returns when that was, in ns.

        Raises NotTransmitted if it was given up, BusOff if the node left the bus. Cancelled, the frame
        stays queued.
        """
        outcome: list[tuple[bool, int]] = []
        self._check_open()
        if not self._takes(frame):
            return self.time.now_ns
        flags = CONFIRM | self._flags | SINGLE_SHOT * single_shot | HIGH_PRIORITY * high_priority

        def settle(delivered: bool, at_ns: int) -> None:
            outcome.append((delivered, at_ns))
            self.time.active()

        with self.time.touch():
            self.line.send(self._channel, frame, flags, 0)
            self._channel.expect_outcome(high_priority, settle)
        self.time.active()
        while not outcome:
            if self.state is ErrorState.BUS_OFF:
                raise BusOff(self.line.name)
            await self.time.turn(NEVER)
        delivered, at_ns = outcome[0]
        if not delivered:
            raise NotTransmitted(self.line.name, frame, "single shot failed or it was cancelled")
        return at_ns

    def cancel(self) -> int:
        """Give up everything queued, but for a frame on the wire; returns how many."""
        with self.time.touch():
            return self.line.cancel(self._channel)

    # receiving

    def receive_many(self, limit: int) -> list[Frame]:
        """Up to `limit` frames, oldest first; takes only what is there."""
        most = whole("limit", limit, 0, LONGEST_NS)
        return self._ring.take_frames(most)  # at once: several times as quick as one by one

    def receive_array(self, limit: int | None = None) -> numpy.ndarray:
        """Up to `limit` frames (None: all) as numpy records: see `record_dtype`. Needs canwire[arrays]."""
        most = self._ring.capacity if limit is None else whole("limit", limit, 0, LONGEST_NS)
        return self._ring.take_array(most)

    def expect(
        self, id: int, *, within: float, extended: bool = False, data: bytes | None = None, **unknown: Never
    ) -> Frame:
        """Let at most `within` seconds pass until this frame arrives, dropping others.

        Raises NotReceived, saying what came instead.
        """
        if unknown:
            raise unknown_argument("expect()", unknown, CanBenchNode.expect)
        check_expected(id)

        def wanted(frame: Frame) -> bool:
            return frame.id == id and frame.extended == extended and (data is None or frame.data == data)

        return self._expect(wanted, f"{id:#x}", within)

    def events(self, *kinds: EventKind) -> list[BusEvent]:
        """What else happened to this node since the last call (errors, states, lost arbitration); all, or these kinds.

        The first call starts the recording, so call it once before what you want to see.
        """
        if self._events is None:
            self._events = Channel(_EVENT_QUEUE, 0, frames=False, events=_ALL_EVENTS)
            with self.time.touch():
                self.line.open(self._events)
        found = []
        while (record := self._events.receive.take_bytes()) is not None:
            event = BusEvent.from_record(record)
            if not kinds or event.kind in kinds:
                found.append(event)
        return found

    # state

    @property
    def counters(self) -> Counters:
        return self._driver.counters()

    @property
    def state(self) -> ErrorState:
        return self.line.driver.counters().state

    @property
    def tec(self) -> int:
        """Transmit error counter, 0..256."""
        return self.line.driver.counters().tec

    @property
    def rec(self) -> int:
        """Receive error counter, 0..255."""
        return self.line.driver.counters().rec

    @property
    def arbitration_losses(self) -> int:
        return self.line.driver.counters().arbitration_losses

    @property
    def accepted(self) -> int:
        """Frames that passed the filters: those read, those that wait, and those lost."""
        return int(self._channel.accepted)

    @property
    def lost(self) -> int:
        """Frames that found the receive queue full."""
        return self._channel.lost

    @property
    def sent(self) -> int:
        """Frames queued so far: those delivered, aborted and pending."""
        return int(self._channel.sent)

    @property
    def delivered(self) -> int:
        return int(self._channel.delivered)

    @property
    def aborted(self) -> int:
        return int(self._channel.aborted)

    @property
    def pending(self) -> int:
        return self._channel.pending()

    def stop(self) -> None:
        """Leave the bus at once; what is queued stays queued."""
        with self.time.touch():
            self._driver.stop(self.time.timeline.now_ns)

    def start(self) -> None:
        """Take part again, with counters at 0, after 11 recessive bits."""
        self._check_open()
        with self.time.touch():
            self._driver.start(self.time.timeline.now_ns)

    def restart(self) -> None:
        """After bus-off: rejoin once 128 times 11 recessive bits have been seen."""
        self._check_open()
        with self.time.touch():
            self._driver.restart(self.time.timeline.now_ns)

    def reconfigure(self, settings: LineSettings) -> None:
        """New timing or mode, effective at once."""
        instance("settings", settings, LineSettings)
        with self.time.touch():
            self._driver.configure(settings)
            self.settings = settings

    def on_events(self, callback: Callable[[], None] | None) -> None:
        """The same for the queue of events, once `events` has been called."""
        if self._events is not None:
            self._events.receive.listener = callback

    def __repr__(self) -> str:
        return f"<node {self.line.name}: {self.state.name}, TEC {self.tec}, REC {self.rec}>"

    @property
    def _driver(self) -> Driver:
        return self.line.driver

    def _leave(self) -> None:
        self._driver.stop(self.time.timeline.now_ns)
