"""One connector with its controller, shared by any number of channels.

Towards the bus the channels take turns; what comes from the bus is copied to every channel that wants it.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from canwire.boards.channel import Channel
from canwire.bus.node import Mailbox, Sink
from canwire.chips.can_fd import CanFdController, Host
from canwire.errors import LineError, QueueFull
from canwire.ring import Ring
from canwire.timeline import Timeline
from canwire.values import frame as codec
from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind
from canwire.values.frame import Frame
from canwire.values.record import CONFIRM, HIGH_PRIORITY
from canwire.values.records import checked_records

if TYPE_CHECKING:
    import numpy

    from canwire.drivers.driver import Driver

_SELF_RECEPTION = 1 << 21
_CONFIRM = CONFIRM
_HIGH_PRIORITY = HIGH_PRIORITY
_ABORTED = int(EventKind.ABORTED)


class Splitter(Sink):
    """One copy for every channel."""

    def __init__(self) -> None:
        self.channels: list[Channel] = []

    def deliver(self, box: Mailbox, at_ns: int, flags: int) -> None:
        self._deliver(box, at_ns, flags)

    def _deliver(self, box: Mailbox, at_ns: int, flags: int) -> None:
        for channel in self.channels:
            channel.deliver(box, at_ns, flags)


class Line(Host):
    """Splitter between one controller and its channels."""

    def __init__(self, name: str, timeline: Timeline) -> None:
        self.name = name
        self.timeline = timeline
        self.controller = CanFdController(self)
        self.driver: Driver | None = None
        self._scratch = Mailbox()
        self._turn = 0
        self._all: list[Channel] = []
        self._senders: list[Channel] = []
        self._splitter = Splitter()
        self._observers: list[Channel] = []

    def open(self, channel: Channel) -> Channel:
        """Put a channel on the line; from now on it receives."""
        self._all = [*self._all, channel]
        self._sort()
        return channel

    def close(self, channel: Channel) -> None:
        """Take a channel off the line; frames of its own in the controller still go out."""
        self._all = [other for other in self._all if other is not channel]
        self._sort()

    def send(self, channel: Channel, frame: Frame, flags: int = 0, delay_ns: int = 0) -> None:
        """Queue a frame; `flags` are info bits (single shot, high priority, self-reception, confirm).

        Raises QueueFull, and LineError for a frame that this line cannot send.
        """
        if frame.fd:
            self._check_fd(frame)
        if self.controller.listen_only:
            raise LineError(f"{self.name}: a listen-only line sends nothing")
        if not channel.sends:
            raise LineError(f"{self.name}: this channel was opened without a transmit queue")
        codec.store_frame(frame, self._scratch.words, 0, flags, delay_ns)
        if not channel.transmit.free():
            raise QueueFull(self.name, channel.transmit.capacity)
        channel.transmit.put(self._scratch.words, 0, delay_ns, self._scratch.words[1])
        channel.sent += 1
        if flags & _HIGH_PRIORITY:
            channel.urgent += 1
        self.kick()

    def send_records(self, channel: Channel, records: numpy.ndarray, flags: int) -> int:
        """Queue as many of these records as fit; returns how many. Raises BadFrame before queueing any."""
        if not channel.sends:
            raise LineError(f"{self.name}: this channel was opened without a transmit queue")
        if self.controller.listen_only:
            raise LineError(f"{self.name}: a listen-only line sends nothing")
        checked = checked_records(records, fd=self.controller.fd != 0, flags=flags)
        count = channel.transmit.put_array(checked)
        channel.sent += count
        if flags & _HIGH_PRIORITY:
            channel.urgent += count
        self.kick()
        return count

    def kick(self) -> None:
        """Something was queued: load it if a mailbox is free."""
        controller = self.controller
        if not controller.normal.occupied or not controller.high.occupied:
            had_offer = controller.offer
            self.fill(self.timeline.now_ns)
            if controller.offer is not had_offer and controller.bus is not None:
                controller.bus.poll(controller)

    def cancel(self, channel: Channel) -> int:
        """Give up everything this channel has queued, but for a frame on the wire; returns how many."""
        before = channel.aborted
        if channel.sends:
            channel.drop_queued(self.timeline.now_ns)
        for box in (self.controller.high, self.controller.normal):
            if box.occupied and box.owner is channel:
                self.controller.abort(box, self.timeline.now_ns)
        return int(channel.aborted - before)

    # the controller's side

    def received(self, box: Mailbox, at_ns: int) -> None:
        self._splitter.deliver(box, at_ns, 0)

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        channel = box.owner
        channel.delivered += 1
        channel.last_sent_ns = at_ns
        info = box.words[1] >> 32
        if info & (_SELF_RECEPTION | _CONFIRM):
            if info & _SELF_RECEPTION:
                self._splitter.deliver(box, at_ns, _SELF_RECEPTION)
            if info & _CONFIRM:
                channel.tell_outcome(box, True, at_ns)

    def aborted(self, box: Mailbox, at_ns: int) -> None:
        channel = box.owner
        channel.aborted += 1
        if box.words[1] >> 32 & _CONFIRM:
            channel.tell_outcome(box, False, at_ns)
        self.event(_ABORTED, 0, -1, True, at_ns)

    def fill(self, at_ns: int) -> None:
        """Load free mailboxes, one frame from each channel in turn."""
        while self._load_one(at_ns):
            pass

    def _load_one(self, at_ns: int) -> bool:
        """Load one frame of the first channel in turn whose next frame finds its mailbox free."""
        senders = self._senders
        count = len(senders)
        controller = self.controller
        normal_taken = controller.normal.occupied
        for k in range(count):
            turn = self._turn + k
            if turn >= count:
                turn -= count
            channel = senders[turn]
            if normal_taken and channel.urgent == 0:
                continue
            ring = channel.transmit
            at = ring.front()
            if at and not controller.occupied(ring._words, at) and self._due(channel, ring, at, at_ns):
                if controller.load(ring._words, at, at_ns, channel):
                    channel.urgent -= 1
                ring.release(1)
                self._turn = turn + 1 if turn + 1 < count else 0
                return True
        return False

    def event(self, kind: int, error: int, bit: int, transmitting: bool, at_ns: int) -> None:
        if not self._observers:
            return
        confinement = self.controller.confinement
        record = None
        for channel in self._observers:
            if kind in channel.events:
                if record is None:
                    record = BusEvent(
                        EventKind(kind),
                        at_ns,
                        ErrorKind(error),
                        ErrorState(self.controller.state()),
                        bit,
                        bool(transmitting),
                        confinement.tec,
                        confinement.rec,
                    ).to_record()
                channel.deliver_event(record)

    def _due(self, channel: Channel, ring: Ring, at: int, now_ns: int) -> bool:
        """A delayed frame goes to the controller only when its time has come."""
        delay_ns = ring._words[at]
        if delay_ns == 0 or channel.last_sent_ns + delay_ns <= now_ns:
            return True
        if channel.pending() > channel.transmit.fill():
            return False  # the frame before it is still in the controller
        if not channel.held:
            channel.held = True
            self.timeline.at(channel.last_sent_ns + delay_ns, partial(self._release, channel))
        return False

    def _release(self, channel: Channel) -> None:
        channel.held = False
        self.kick()

    def _sort(self) -> None:
        self._turn = 0
        self._senders = [channel for channel in self._all if channel.sends]
        receivers = self._splitter.channels = [channel for channel in self._all if channel.frames]
        self._observers = [channel for channel in self._all if channel.events]
        self.controller.sink = receivers[0] if len(receivers) == 1 else self._splitter
        self.controller.attentive = bool(self._observers)

    def _check_fd(self, frame: Frame) -> None:
        if self.controller.fd == 0:
            raise LineError(
                f"{self.name}: the line is set up for classic CAN; give the bus a data_bit_rate for FD"
            )
