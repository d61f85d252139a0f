"""One connector with its controller, shared by any number of channels.

Channels take turns to send; what comes from the bus is copied to every channel that wants it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from canwire import _mem
from canwire.boards.can.backlog import Backlog
from canwire.boards.can.channel import Channel, Splitter
from canwire.boards.can.hearing import Hearing
from canwire.boards.can.modes import Siblings
from canwire.bus.can.node import Mailbox, Node
from canwire.chips.host import Host
from canwire.drivers.driver import Driver
from canwire.errors import LineError, QueueFull
from canwire.timeline import Timeline
from canwire.values import dlc as lengths
from canwire.values import frame as codec
from canwire.values.event import BusEvent, ErrorKind, EventKind
from canwire.values.frame import Frame
from canwire.values.record import CONFIRM, CONFIRM_LOAD, HIGH_PRIORITY
from canwire.values.records import checked_records

if TYPE_CHECKING:
    import numpy

_SELF_RECEPTION = 1 << 21
_EXTENDED = 1 << 23
_REMOTE = 1 << 22
_FD = 1 << 10
_FAST = 1 << 11
_LOOP_BACK = 1 << 15
_M32 = 0xFFFFFFFF
_LARGEST_STANDARD, _LARGEST_EXTENDED = 0x7FF, 0x1FFFFFFF
_REFUSALS = 4096  # in _PAUSE_NS; then the bus has its turn, and the channel of the next record waits
_PAUSE_NS = 1_000_000
_CONFIRM = CONFIRM
_CONFIRM_LOAD = CONFIRM_LOAD
_HIGH_PRIORITY = HIGH_PRIORITY
_EVERY = int(Siblings.EVERY)
_ABORTED = int(EventKind.ABORTED)
_ERROR = int(EventKind.ERROR)


class Line(Host):
    """Splitter between one controller and its channels; `controller` is the node on the bus.

    `long_data` and `fast_data` say which frames untrusted channels may send, and each channel which formats. A line
    that is `holding` loads no more frames. A program of the interface `kin` set the line up.
    `coupling_fault` returns whether its transceiver reports a fault of the wires.
    """

    def __init__(self, name: str, timeline: Timeline) -> None:
        self.name = name
        self.timeline = timeline
        self.controller = Node()
        self.driver = Driver(self, Mailbox(), Mailbox())
        self.long_data = self.fast_data = True
        self.holding = False
        self.kin = ""
        self.coupling_fault: Callable[[], bool] = bool  # False, of a line that cannot tell
        self._scratch = Mailbox()
        self._turn = 0
        self._refusals = 0
        self._patient_until_ns = 0
        self._loads = 0
        self._watched = False
        self._all: list[Channel] = []
        self._senders: list[Channel] = []
        self._lone: Channel | None = None  # the only sender, where there is no turn to take
        self._splitter = Splitter()
        self._hearings: dict[str, Hearing] = {}
        self._observers: list[Channel] = []
        self._prioritised: list[Channel] = []
        self._backlog = Backlog()

    def connect(self, driver: Driver, controller: Node) -> None:
        """Set the controller and its driver, before anything is opened on the line."""
        self.driver = driver
        self.controller = controller
        controller.validates_early = False  # of every kind of board a frame's stamp is its end

    def open(self, channel: Channel) -> Channel:
        """Open a channel on the line; it receives from now on."""
        hearing = self._hearings.get(channel.kin)
        if hearing is not None:
            hearing.give(channel)
        self._all = [*self._all, channel]
        self._sort()
        return channel

    def close(self, channel: Channel) -> None:
        """Remove a channel from the line; its frames in the controller are still sent."""
        self._all = [other for other in self._all if other is not channel]
        self._sort()

    def send(self, channel: Channel, frame: Frame, flags: int = 0, delay_ns: int = 0) -> None:
        """Queue a frame; `flags` are info bits (single shot, high priority, self-reception, confirm).

        Raises QueueFull, and LineError for a frame that this line cannot send.
        """
        if frame._info & _FD and self.driver.fd == 0:
            self._check_fd(frame)
        if not (channel.standard and channel.extended and self.long_data and self.fast_data):
            self.check(frame, channel.kin)
        if self.driver.listen_only or not channel.sends:
            self._check_sends(channel)
        codec.store_frame(frame, self._scratch.words, 0, flags, delay_ns)
        if not channel.transmit.free():
            raise QueueFull(self.name, channel.transmit.capacity)
        channel.transmit.put(self._scratch.words, 0, delay_ns, self._scratch.words[1])
        channel.sent += 1
        if flags & _HIGH_PRIORITY:
            channel.urgent += 1
        self.kick()

    def check(self, frame: Frame, kin: str) -> None:
        """Raise LineError for a frame that a program of this kin must not send with the line's settings."""
        own = self._hearings.get(kin)
        if own is not None and not (own.mode.extended if frame.extended else own.mode.standard):
            raise LineError(f"{self.name}: set up without {29 if frame.extended else 11}-bit identifiers")
        if frame.fd:
            self._check_fd(frame)
            if frame.dlc > 8 and not self.long_data:
                raise LineError(f"{self.name}: set up without more than 8 bytes of data")
            if frame.bit_rate_switch and not self.fast_data:
                raise LineError(f"{self.name}: set up without a data bit rate to switch to")

    def send_records(self, channel: Channel, records: numpy.ndarray, flags: int) -> int:
        """Queue as many of these records as fit; returns how many. Raises BadFrame before queueing any."""
        self._check_sends(channel)
        checked = checked_records(records, fd=self.driver.fd != 0, flags=flags)
        count = channel.transmit.put_array(checked)
        channel.sent += count
        if flags & _HIGH_PRIORITY:
            channel.urgent += count
        self.kick()
        return count

    def kick(self) -> None:
        """Load a queued frame if a mailbox is free."""
        driver = self.driver
        lone = self._lone
        if lone is not None and not (lone.urgent or lone.untrusted or driver.several):
            free = not driver.normal.occupied  # else it is loaded when the frame before it has gone
        else:
            free = not (driver.normal.occupied and driver.high.occupied) or driver.several
        if free or self._prioritised:
            before = self._loads
            self.fill(self.timeline.now_ns)
            if self._loads != before:
                driver.poll()

    def hear(self, kin: str, hearing: Hearing) -> None:
        """Set what channels of this kin receive from now on."""
        self._hearings[kin] = hearing
        for channel in self._all:
            if channel.kin == kin:
                hearing.give(channel)
        self._sort()

    def channels(self) -> list[Channel]:
        """The channels that are open on this line."""
        return list(self._all)

    def tell(self, event: BusEvent, stamped: bool = True) -> None:
        """Deliver an event of the line to every channel that wants its kind; its time stays unless `stamped`."""
        record = event.to_record()
        for channel in self._observers:
            if event.kind in channel.events:
                channel.deliver_event(record, stamped)

    def pending(self) -> bool:
        """Whether a frame waits in a mailbox, or is being sent."""
        for box in self.driver.boxes:
            if box.occupied:
                return True
        return False

    def happening(self, kind: EventKind, at_ns: int, code: int = 0) -> BusEvent:
        """An event of the line itself, with the present state of its controller."""
        counters = self.driver.counters()
        return BusEvent(
            kind,
            at_ns,
            state=counters.state,
            code=code,
            pending=self.pending(),
            coupling_fault=self.coupling_fault(),
        )

    def cancel(self, channel: Channel, loaded: bool = True) -> int:
        """Discard all frames that this channel has queued; returns how many. Without `loaded`, mailboxes are unchanged.

        A frame on the wire continues, and is not repeated if it fails.
        """
        before = channel.aborted
        if channel.sends:
            channel.drop_queued(self.timeline.now_ns)
        dropped = self._backlog.drop(channel)
        channel.aborted += dropped
        channel.in_flight -= dropped
        for box in self.driver.boxes if loaded else ():
            if box.occupied and box.owner is channel:
                self.driver.abort(box, self.timeline.now_ns)
        return int(channel.aborted - before)

    # the controller's side

    def received(self, box: Mailbox, at_ns: int) -> None:
        self._splitter.deliver(box, at_ns, 0)

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        self._count_sent(box.owner, box, at_ns)

    def _count_sent(self, channel: Channel, box: Mailbox, at_ns: int) -> None:
        channel.delivered += 1
        channel.in_flight -= 1
        channel.last_sent_ns = at_ns
        info = box.words[1] >> 32
        if info & (_SELF_RECEPTION | _CONFIRM) or self._watched:
            for other in self._splitter.channels:
                other.deliver_sent(box, at_ns)
            if info & _CONFIRM:
                if not channel.untrusted:
                    channel.tell_outcome(box, True, at_ns)
                elif not info & _SELF_RECEPTION:
                    channel.return_own(box, at_ns)

    def aborted(self, box: Mailbox, at_ns: int) -> None:
        channel = box.owner
        channel.aborted += 1
        channel.in_flight -= 1
        if box.words[1] >> 32 & _CONFIRM:
            if channel.untrusted:
                self._tell_aborted(channel, at_ns)
            else:
                channel.tell_outcome(box, False, at_ns)
        self.event(_ABORTED, 0, -1, True, at_ns, 0)

    def fill(self, at_ns: int) -> None:
        """Load free mailboxes, one frame from each channel in turn."""
        driver = self.driver
        if self.holding or not driver.running or driver.listen_only:
            return
        if at_ns >= self._patient_until_ns:
            self._refusals = 0
            self._patient_until_ns = at_ns + _PAUSE_NS
        lone = self._lone
        if lone is not None and not (lone.untrusted or driver.several):
            while (lone.urgent or not driver.normal.occupied) and self._load_trusted(lone, at_ns):
                self._loads += 1
            return
        for channel in self._prioritised:
            self._drain(channel, at_ns)
        while self._load_one(at_ns):
            self._loads += 1

    def _load_one(self, at_ns: int) -> bool:
        """Load one frame, of the first channel in turn whose next frame has a free mailbox; True if one was loaded."""
        senders = self._senders
        count = len(senders)
        normal_taken = self.driver.normal.occupied and not self.driver.several
        for k in range(count):
            turn = self._turn + k
            if turn >= count:
                turn -= count
            channel = senders[turn]
            if channel.prioritised:
                loaded = not normal_taken and self._load_first(at_ns)
            elif channel.untrusted:
                loaded = self._load_untrusted(channel, at_ns)
            elif normal_taken and channel.urgent == 0:
                continue
            else:
                loaded = self._load_trusted(channel, at_ns)
            if loaded:
                self._turn = turn + 1 if turn + 1 < count else 0
                return True
        return False

    def _load_trusted(self, channel: Channel, at_ns: int) -> bool:
        ring = channel.transmit
        at = ring.front()
        driver = self.driver
        if at == 0 or (driver.several and driver.full_for(channel)):
            return False
        delay_ns = ring._words[at]
        if channel.urgent and driver.occupied(ring._words, at):  # else the caller has seen that there is room
            return False
        if delay_ns and not self._due(channel, delay_ns, at_ns):
            return False
        channel.in_flight += 1
        if driver.load(ring._words, at, at_ns, channel):
            channel.urgent -= 1
        ring.release(1)
        return True

    def _load_untrusted(self, channel: Channel, at_ns: int) -> bool:
        """Load an untrusted channel's frame; it is copied before the checks, as its program may still write."""
        ring = channel.transmit
        driver = self.driver
        if driver.full_for(channel) if driver.several else driver.normal.occupied and driver.high.occupied:
            return False
        words = self._scratch.words
        if channel.paused:
            return False
        while (at := ring.front()) != 0:
            _mem.copy_record(words, 0, ring._words, at)
            if self._admit(words, channel):
                delay = words[0] & _M32 if channel.tick_ns else words[0]
                if delay <= channel.longest_delay:
                    if driver.occupied(words, 0) or not self._due(
                        channel, delay * channel.delay_tick_ns, at_ns
                    ):
                        return False
                    channel.sent += 1
                    channel.in_flight += 1
                    if words[1] >> 32 & _CONFIRM_LOAD:
                        channel.return_own(self._scratch, at_ns)
                    driver.load(words, 0, at_ns, channel)
                    ring.release(1)
                    return True
            channel.sent += 1
            ring.release(1)
            if not self._refuse(channel, at_ns):
                return False
        ring.arm_once()
        return False

    def _drain(self, channel: Channel, at_ns: int) -> None:
        """Move the queued frames of a prioritised channel to the backlog, where they wait by priority."""
        ring = channel.transmit
        backlog = self._backlog
        words = self._scratch.words
        while not channel.paused and backlog.room(channel) > 0 and (at := ring.front()) != 0:
            _mem.copy_record(words, 0, ring._words, at)
            ring.release(1)
            channel.sent += 1
            priority = words[0] >> 32 & 0xFF
            loop_back = words[1] >> 32 & _LOOP_BACK
            words[0] = 0
            if self._admit(words, channel):
                channel.in_flight += 1
                backlog.push(priority, self._scratch.record(), channel)
                if loop_back:
                    self._splitter.loop_back(self._scratch, at_ns)
            else:
                self._refuse(channel, at_ns)
        if not channel.paused:
            ring.arm_once()

    def _load_first(self, at_ns: int) -> bool:
        """Load the most urgent frame of all prioritised channels.

        Several mailboxes have their own order, so only one such frame is in the controller at a time.
        """
        if not len(self._backlog):
            return False
        driver = self.driver
        if driver.several:
            for box in driver.boxes:
                owner = box.owner
                if box.occupied and owner.prioritised:
                    return False
        record, channel = self._backlog.front()
        self._scratch.block[:] = record
        if driver.occupied(self._scratch.words, 0):
            return False
        self._backlog.pop()
        driver.load(self._scratch.words, 0, at_ns, channel)
        return True

    def _refuse(self, channel: Channel, at_ns: int) -> bool:
        """Count a record that cannot be sent; False if its writer must pause.

        So a program that writes only invalid records, however fast, keeps no other program from the bus.
        """
        channel.refused += 1
        self._refusals += 1
        if self._refusals < _REFUSALS:
            return True
        channel.paused = True
        self.timeline.at(at_ns + _PAUSE_NS, partial(self._go_on, channel))
        return False

    def _go_on(self, channel: Channel) -> None:
        channel.paused = False
        self.kick()

    def _admit(self, words: _mem.Words, channel: Channel) -> bool:
        """Whether this line can send a record, corrected if necessary: frame and allowed requests remain."""
        info = words[1] >> 32
        identifier = words[1] & _M32
        if info & 0xFF:
            return False
        length = info >> 16 & 15
        if info & _EXTENDED:
            if identifier > _LARGEST_EXTENDED or not channel.extended:
                return False
        elif identifier > _LARGEST_STANDARD or not channel.standard:
            return False
        if info & (_FD | _FAST):
            if not channel.fd or self.driver.fd == 0 or (info & _FAST and not self.fast_data):
                return False
            if length > 8 and not self.long_data:
                return False
            info = (info | _FD) & ~_REMOTE
            length = lengths.FD_LENGTHS[length]
        elif length > 8:
            length = 8
        if info & _REMOTE:
            length = 0
        words[1] = identifier | (info & channel.allowed) << 32
        _mem.clear_tail(words, 2, length)
        return True

    def event(self, kind: int, error: int, bit: int, transmitting: bool, at_ns: int, code: int) -> None:
        if not self._observers:
            return
        record = None
        for channel in self._observers:
            if kind in channel.events and (kind != _ERROR or channel.hears_errors):
                if record is None:
                    counters = self.driver.counters()
                    record = BusEvent(
                        EventKind(kind),
                        at_ns,
                        ErrorKind(error),
                        counters.state,
                        bit,
                        bool(transmitting),
                        counters.tec,
                        counters.rec,
                        code,
                        self.pending(),
                        self.coupling_fault(),
                    ).to_record()
                channel.deliver_event(record)

    def _tell_aborted(self, channel: Channel, at_ns: int) -> None:
        """Report an aborted frame to its channel, which requested that, unless the channel gets all ABORTED events."""
        if _ABORTED not in channel.events:
            counters = self.driver.counters()
            event = BusEvent(EventKind.ABORTED, at_ns, state=counters.state, transmitting=True)
            channel.deliver_event(event.to_record())

    def _due(self, channel: Channel, delay_ns: int, now_ns: int) -> bool:
        """Whether a delayed frame is due; it is loaded into the controller only at its time."""
        if delay_ns == 0 or channel.last_sent_ns + delay_ns <= now_ns:
            return True
        if channel.in_flight > 0:
            return False  # the frame before it is still in the controller
        if not channel.held:
            channel.held = True
            self.timeline.at(channel.last_sent_ns + delay_ns, partial(self._release, channel))
        return False

    def _release(self, channel: Channel) -> None:
        channel.held = False
        self.kick()

    def _sort(self) -> None:
        self._take_turns([channel for channel in self._all if channel.sends])
        receivers = self._splitter.channels = [channel for channel in self._all if channel.frames]
        self._observers = [channel for channel in self._all if channel.events]
        self._watched = any(channel.siblings >= _EVERY for channel in receivers)
        direct = len(receivers) == 1 and not receivers[0].gated()
        self._prioritised = [channel for channel in self._senders if channel.prioritised]
        self._lone = self._senders[0] if len(self._senders) == 1 and not self._prioritised else None
        self.driver.listen(receivers[0] if direct else self._splitter, bool(self._observers))
        strangers = [channel for channel in self._all if channel.kin != self.kin]
        kinds = frozenset[int]().union(*(channel.events for channel in strangers))
        self.driver.report(kinds, any(channel.frames for channel in strangers))

    def _take_turns(self, senders: list[Channel]) -> None:
        """Put the senders in order: the one served last is last but for new ones, so reopening gains no turn."""
        before = self._senders[self._turn :] + self._senders[: self._turn]
        staying = [channel for channel in before if channel in senders]
        others = max(0, len(staying) - 1)
        new = [channel for channel in senders if channel not in before]
        self._senders = staying[:others] + new + staying[others:]
        self._turn = 0

    def _check_sends(self, channel: Channel) -> None:
        if self.driver.listen_only:
            raise LineError(f"{self.name}: a listen-only line, or one in restricted operation, sends nothing")
        if not channel.sends:
            raise LineError(f"{self.name}: this channel was opened without a transmit queue")

    def _check_fd(self, frame: Frame) -> None:
        if self.driver.fd == 0:
            raise LineError(
                f"{self.name}: the line is set up for classic CAN; give the bus a data_bit_rate for FD"
            )
