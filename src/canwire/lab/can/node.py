"""A CAN node of a lab: sends, receives, shows its counters."""

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
from canwire.ring import Ring
from canwire.timeline import NEVER
from canwire.values.acceptance import Acceptance
from canwire.values.arguments import unknown_argument
from canwire.values.checks import LONGEST_NS, check_expected, instance, whole
from canwire.values.event import BusEvent, ErrorState, EventKind
from canwire.values.frame import Frame, frame_of_record
from canwire.values.mistakes.names import answers_wrong_names
from canwire.values.record import CONFIRM, HIGH_PRIORITY, SINGLE_SHOT
from canwire.values.records import check_dtype
from canwire.values.text import format_frame

if TYPE_CHECKING:
    import numpy

BusT = TypeVar("BusT")
_EVENT_QUEUE = 4096
_STATES = 16
_ALL_EVENTS = frozenset(int(kind) for kind in EventKind)


@answers_wrong_names
class CanBenchNode(BenchNode[Frame, BusT], Sending):
    """The base class of LabNode: one controller with one channel."""

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
        self._states: Ring | None = None
        line.controller.name = name
        line.open(channel)

    def begin(self, resting: bool) -> None:
        """Configure and start; on a resting bus the node takes part immediately."""
        self._driver.configure(self.settings)
        self._driver.start(self.time.timeline.now_ns, integrated=resting)

    # sending: `send` and `send_many` are Sending's

    def send_array(self, records: numpy.ndarray) -> int:
        """Queue records of numpy dtype `record_dtype()`, as from `receive_array`; their time is a delay in ns.

        Returns the number of records queued. Raises BadFrame for a record that is no valid frame for this line.
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
        """Whether the lab's selection lets the frame be sent; callers treat other frames as sent
        without queuing them."""
        selection = self.time.selection
        return selection is None or selection.takes(
            FRAMES, lambda: f"{self._full_name}: {format_frame(frame)}"
        )

    async def send_async(
        self, frame: Frame, *, single_shot: bool = False, high_priority: bool = False
    ) -> int:
        """Send, wait until the frame was transmitted, and return the time of its end in ns.

        Raises NotTransmitted if it was discarded, BusOff if the node left the bus. If the task is cancelled,
        the frame stays queued.
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
            states = self._heard_states()
            self.line.send(self._channel, frame, flags, 0)
            self._channel.expect_outcome(high_priority, settle)
        self.time.active()
        await self._until(lambda: bool(outcome), states)
        delivered, at_ns = outcome[0]
        if not delivered:
            raise NotTransmitted(self.line.name, frame, "single shot failed or it was cancelled")
        return at_ns

    def cancel(self) -> int:
        """Discard all queued frames, except one on the wire; returns their number."""
        with self.time.touch():
            return self.line.cancel(self._channel)

    # receiving

    def receive_many(self, limit: int) -> list[Frame]:
        """Up to `limit` frames, oldest first, without waiting."""
        most = whole("limit", limit, 0, LONGEST_NS)
        return self._ring.take_frames(most)  # together: several times as quick as one by one

    def receive_array(self, limit: int | None = None) -> numpy.ndarray:
        """Up to `limit` frames (None: all) as numpy records: see `record_dtype`. Needs canwire[arrays]."""
        most = self._ring.capacity if limit is None else whole("limit", limit, 0, LONGEST_NS)
        return self._ring.take_array(most)

    def expect(
        self, id: int, *, within: float, extended: bool = False, data: bytes | None = None, **unknown: Never
    ) -> Frame:
        """Let at most `within` seconds pass until this frame arrives, discarding others.

        Raises NotReceived with the frames that arrived instead.
        """
        if unknown:
            raise unknown_argument("expect()", unknown, CanBenchNode.expect)
        check_expected(id)

        def wanted(frame: Frame) -> bool:
            return frame.id == id and frame.extended == extended and (data is None or frame.data == data)

        return self._expect(wanted, f"{id:#x}", within)

    def events(self, *kinds: EventKind) -> list[BusEvent]:
        """Events of this node since the last call (errors, states, lost arbitration): all, or those of these kinds.

        The first call starts the recording, so call `events` once before the part of interest.
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
        """Number of frames that passed the filters: frames read, waiting and lost."""
        return int(self._channel.accepted)

    @property
    def lost(self) -> int:
        """Number of frames lost because the receive queue was full."""
        return self._channel.lost

    @property
    def sent(self) -> int:
        """Number of frames queued so far: delivered, aborted and pending."""
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
        """Leave the bus immediately; frames stay queued."""
        with self.time.touch():
            self._driver.stop(self.time.timeline.now_ns)

    def start(self) -> None:
        """Join the bus again, with counters at 0, after 11 recessive bits."""
        self._check_open()
        with self.time.touch():
            self._driver.start(self.time.timeline.now_ns)

    def restart(self) -> None:
        """After bus-off: join the bus again after 128 sequences of 11 recessive bits."""
        self._check_open()
        with self.time.touch():
            self._driver.restart(self.time.timeline.now_ns)

    def reconfigure(self, settings: LineSettings) -> None:
        """Set a new timing or mode, effective immediately."""
        instance("settings", settings, LineSettings)
        with self.time.touch():
            self._driver.configure(settings)
            self.settings = settings

    def on_events(self, callback: Callable[[], None] | None) -> None:
        """Like `on_frames`, for the queue of events; effective once `events` has been called."""
        if self._events is not None:
            self._events.receive.listener = callback

    def __repr__(self) -> str:
        return f"<node {self.line.name}: {self.state.name}, TEC {self.tec}, REC {self.rec}>"

    def _heard_states(self) -> Ring:
        """The queue of what becomes of the node's state; the first one in an empty queue wakes the tasks that wait."""
        if self._states is None:
            channel = Channel(_STATES, 0, frames=False, events=frozenset({int(EventKind.STATE)}))
            channel.receive.listener = self.time.active
            self._states = self.line.open(channel).receive
        return self._states

    async def _until(self, settled: Callable[[], bool], states: Ring) -> None:
        """Wait for it; raises BusOff if the node leaves the bus, Closed if it is closed before."""

        def changed() -> bool:
            return settled() or self._closed or self.state is ErrorState.BUS_OFF

        while not settled():
            self._check_open()
            if self.state is ErrorState.BUS_OFF:
                raise BusOff(self.line.name)
            states.clear()
            await self.time.turn(NEVER, changed)

    @property
    def _driver(self) -> Driver:
        return self.line.driver

    def _leave(self) -> None:
        self._driver.stop(self.time.timeline.now_ns)
