"""A client's channel on a line: frames in and out through shared memory, without a call for each."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from canwire.boards.can.modes import ChannelMode, ChannelStatus, FilterContent, LineStatus
from canwire.errors import NotInitialised, QueueFull
from canwire.hub.handles.ends import RingEnd
from canwire.hub.handles.filtered import Filtered
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.queues import transmit_offset
from canwire.platform import EventDescriptor, close_descriptors, map_memory
from canwire.ring import Ring
from canwire.values.checks import LONGEST_NS, check_frame, instance, whole
from canwire.values.event import BusEvent
from canwire.values.frame import Frame, frame_of_record, record_to_send
from canwire.values.mistakes.names import answers_wrong_names
from canwire.values.records import check_dtype

if TYPE_CHECKING:
    import numpy

    from canwire.hub.handles.client import Client

_PRIORITY_SHIFT = 32  # of the time word
_KIND_AT = 12  # byte of a record: 0 for frames, an EventKind for events


@answers_wrong_names
class HubChannel(Filtered):
    """Queues of one client on a line: `set_up` makes them, `activate` connects them to the line.

    `reading` and `writing` are the ends of its queues, for programs that work in their memory; `receive`,
    `send` and their siblings do that for frames.
    """

    def __init__(self, hub: Client, handle: int, board: int, line: int) -> None:
        super().__init__(hub, handle, f"channel on line {line}")
        self.board = board
        self.line = line
        self._reading: RingEnd | None = None
        self._writing: RingEnd | None = None
        self._swapping = threading.Lock()

    def set_up(self, mode: ChannelMode) -> None:
        """Make the queues, or replace them (their contents are discarded); the channel is inactive then."""
        instance("mode", mode, ChannelMode)
        self.check()
        reply, (memory, *events) = self.hub.ask(m.SetUpChannel(self._handle, mode))
        heard = EventDescriptor.adopt_each(tuple(events), 2 if reply.transmit else 1)
        try:
            queues = map_memory(memory)
            lent = self.hub.lent(memory)
        finally:
            close_descriptors(memory)
        begin = transmit_offset(reply.receive)
        receive = Ring(reply.receive, exact=True, buffer=queues[:begin])
        receive.free_event = self.hub.doorbell
        reading, writing = RingEnd(self, receive, heard[0], reads=True, memory=lent), None
        if reply.transmit:
            transmit = Ring(reply.transmit, exact=True, buffer=queues[begin:])
            transmit.event = self.hub.doorbell
            writing = RingEnd(self, transmit, heard[1], reads=False, memory=lent, begin=begin)
        self._drop_ends(reading, writing)
        if self._closed:  # meanwhile, by another thread
            self._drop_ends()

    @property
    def reading(self) -> RingEnd:
        """The receiving end; raises NotInitialised before `set_up`."""
        if self._reading is None:
            self.check()
            raise NotInitialised(f"{self.name}: set it up first")
        return self._reading

    @property
    def writing(self) -> RingEnd:
        """The sending end; raises NotInitialised before `set_up` and for a channel without a transmit queue."""
        if self._writing is None:
            self.check()
            raise NotInitialised(f"{self.name}: it has no transmit queue")
        return self._writing

    def activate(self) -> LineStatus:
        """Start moving frames whenever the line runs; returns the line's status at that moment.

        Each later change is reported as an event, if the channel receives events. Changes between `open_channel` and
        this call only show in the result: the line may have been stopped. The result has no lateness of the hub.
        """
        status: LineStatus = self.ask(m.Activate(self._handle, True)).status
        return status

    def deactivate(self) -> None:
        """Stop moving frames; frames in the queues stay."""
        self.ask(m.Activate(self._handle, False))

    def replace_filters(self, standard: FilterContent, extended: FilterContent) -> None:
        """Replace both filters in one step, without loss of frames. Raises BadFilter if they do not fit the lists."""
        self.ask(m.ReplaceFilters(self._handle, standard, extended))

    def count_refused(self, count: int) -> None:
        """Count frames that could not be queued as refused; the status of the line shows the count."""
        self.ask(m.CountRefused(self._handle, count))

    def status(self) -> ChannelStatus:
        status: ChannelStatus = self.ask(m.GetChannelStatus(self._handle)).status
        return status

    def cancel(self, *, loaded: bool = True) -> int:
        """Discard all queued frames; returns how many. Without `loaded`, frames in the controller stay.

        A frame on the wire continues; if it fails, the chip discards it instead of repeating it.
        """
        return int(self.ask(m.CancelQueued(self._handle, loaded)).value)

    def pass_on(self, record: bytes) -> None:
        """Pass a frame's record immediately to the line's other channels that receive siblings' frames."""
        self.ask(m.PassOn(self._handle, record))

    def send(self, frame: Frame, flags: int = 0, timeout: float | None = 0, priority: int = 0) -> None:
        """Queue a frame; `flags` are request bits of its info word.

        Raises QueueFull if there is no room within `timeout` seconds (None: no limit).
        `priority` (0..255, 0 is sent first) is for channels that were set up `prioritised`.
        """
        end = self.writing
        self.check()
        if frame.__class__ is not Frame:
            check_frame(frame, Frame)
        urgency = 0
        if flags != 0 or priority != 0:  # what hardly any frame has
            flags = whole("flags", flags, 0, 0xFFFF_FFFF)
            urgency = whole("priority", priority, 0, 255) << _PRIORITY_SHIFT
        record = record_to_send(frame, flags, urgency)
        if not end.ring.free() and not (timeout != 0 and end.wait(timeout)):
            raise QueueFull(self.name, end.ring.capacity)
        end.ring.put_bytes(record)
        end.touched()

    def send_array(self, records: numpy.ndarray) -> int:
        """Queue as many records (record_dtype(), time_ns 0 or a delay) as fit; returns how many."""
        end = self.writing
        self.check()
        check_dtype(records)
        count = end.ring.put_array(records)
        end.touched()
        return count

    def receive(self, timeout: float | None = 0) -> Frame | None:
        """The oldest frame, or None if none arrives within `timeout` seconds (None: no limit).

        For a channel that receives frames only; with events use `receive_record`.
        """
        end = self._waited(timeout)
        frame = end.ring.take_frame()
        end.touched()
        return frame

    def receive_many(self, limit: int, timeout: float | None = 0) -> list[Frame]:
        """Up to `limit` frames, waiting `timeout` seconds for the first."""
        end = self._waited(timeout)
        frames = end.ring.take_frames(whole("limit", limit, 0, LONGEST_NS))
        end.touched()
        return frames

    def receive_array(self, limit: int | None = None, timeout: float | None = 0) -> numpy.ndarray:
        """Up to `limit` records (None: all), waiting `timeout` seconds for the first. Needs canwire[arrays]."""
        end = self._waited(timeout)
        records = end.ring.take_array(
            end.ring.capacity if limit is None else whole("limit", limit, 0, LONGEST_NS)
        )
        end.touched()
        return records

    def receive_record(self, timeout: float | None = 0) -> bytes | None:
        """The oldest record, frame or event, as 80 bytes; None if none arrives within `timeout` seconds."""
        end = self._waited(timeout)
        record = end.ring.take_bytes()
        end.touched()
        return record

    def receive_any(self, timeout: float | None = 0) -> Frame | BusEvent | None:
        """The oldest frame or event, if the channel receives both; None if none arrives within `timeout` seconds."""
        record = self.receive_record(timeout)
        if record is None:
            return None
        return BusEvent.from_record(record) if record[_KIND_AT] else frame_of_record(record)

    def end(self, why: Exception) -> None:
        super().end(why)
        for end in (self._reading, self._writing):
            if end is not None:
                end.wake()

    def leave_to_parent(self, why: Exception) -> None:
        super().leave_to_parent(why)
        self._swapping = threading.Lock()  # the thread that may have held it is not here
        for end in (self._reading, self._writing):
            if end is not None:
                end.leave_to_parent()

    def close(self) -> None:
        super().close()
        self._drop_ends()

    def _state(self) -> str:
        if self.over:
            return super()._state()
        if self._reading is None:
            return "not set up"
        return ", ".join(end.contents() for end in (self._reading, self._writing) if end is not None)

    def _waited(self, timeout: float | None) -> RingEnd:
        end = self.reading
        if not end.ring.fill():
            self.check()
            if timeout != 0:
                end.wait(timeout)
        return end

    def _drop_ends(self, reading: RingEnd | None = None, writing: RingEnd | None = None) -> None:
        """Replace the present ends by these and close the present ones; several threads may do that simultaneously."""
        with self._swapping:
            before = self._reading, self._writing
            self._reading, self._writing = reading, writing
        for end in before:
            if end is not None:
                end.close()
