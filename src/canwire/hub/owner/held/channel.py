"""A client's channel at the hub: queues in shared memory, a filter, and whether it is active."""

from __future__ import annotations

from dataclasses import dataclass

from canwire.boards.can.channel import ALL_REQUESTS, Channel
from canwire.boards.can.message_filter import FormatFilter, MessageFilter, message_filter
from canwire.boards.can.modes import ChannelMode, ChannelStatus, FilterContent, Siblings
from canwire.bus.can.node import Mailbox
from canwire.errors import BadFrame, BadValue, NotInitialised, WrongState
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.held.line import HeldQueue
from canwire.hub.owner.held.shared_ring import SharedRings
from canwire.platform import Descriptor, EventDescriptor
from canwire.values.frame import frame_of_record, record_of_frame

_KIND_AT = 12  # byte of a record: 0 for frames


@dataclass(eq=False)
class HeldChannel(HeldQueue):
    """A client's channel: its queues once it is set up, its filter, and whether it is active."""

    slot: CanSlot
    channel: Channel | None = None
    active: bool = False
    kin: str = ""
    filter: MessageFilter | None = None
    _queues: SharedRings | None = None

    def set_up(self, mode: ChannelMode, doorbell: EventDescriptor | None) -> tuple[Descriptor, ...]:
        """Make queues in new memory. Returns descriptors: memory, the receive queue's event, [the transmit queue's].

        Raises BadValue, BadFilter or OSError, and then changes nothing.
        """
        size = mode.filter_size
        chosen = message_filter(mode.filter_mode, 2048 if size else 0, mode.filter_mode, size)
        queues = SharedRings(
            mode.receive,
            mode.transmit,
            exact=mode.exact,
            doorbell=doorbell,
            halts=self.holder.halts,
            bells=self.holder.bells,
        )
        self.activate(False)
        self._forget_queues()
        self._queues = queues
        self.channel = self._new_channel(mode, queues)
        self.channel.filter = self.filter = chosen
        return queues.hand_over()

    def _new_channel(self, mode: ChannelMode, queues: SharedRings) -> Channel:
        channel = Channel(
            mode.receive,
            mode.transmit,
            frames=mode.frames,
            events=frozenset(mode.events),
            siblings=mode.siblings,
            rings=(queues.receive, queues.transmit),
        )
        channel.untrusted = True
        channel.kin = self.kin = mode.kin
        channel.prioritised = mode.prioritised
        if mode.prioritised or mode.confirms:
            channel.allowed = ALL_REQUESTS
        channel.fd = mode.fd
        self._take_time(channel, mode.ticks)
        return channel

    def activate(self, active: bool) -> None:
        if self.channel is None:
            if active:
                raise NotInitialised(f"{self.slot.can.line.name}: set the channel up before activating it")
            return
        if active != self.active:
            self.active = active
            self.holder.channels_changed()
            line = self.slot.can.line
            if active:
                self.channel.origin_ns = self.slot.can.origin_ns or 0
                self.slot.can.welcome(self.channel)
                line.open(self.channel)
                self.channel.transmit.arm()
                line.kick()
            else:
                line.close(self.channel)

    def pass_on(self, record: bytes) -> None:
        """Pass a frame to the line's other channels that receive siblings' frames like those of the bus.

        Raises BadFrame.
        """
        line, box = self.slot.can.line, Mailbox()
        frame = frame_of_record(record)
        if record[_KIND_AT]:
            raise BadFrame(f"{line.name}: this record is an event's, not a frame's")
        box.block[:] = record_of_frame(frame)
        for channel in line.channels():
            if channel is not self.channel and channel.frames and channel.siblings == Siblings.AS_BUS:
                channel.deliver(box, line.timeline.now_ns, 0)

    def format_filter(self, extended: bool) -> FormatFilter:
        """The filter for one frame format; raises NotInitialised before `set_up`."""
        if self.filter is None:
            raise NotInitialised(f"{self.slot.can.line.name}: a channel has filters once it is set up")
        return self.filter.of(extended)

    def replace_filters(self, standard: FilterContent, extended: FilterContent) -> None:
        """Replace both filters in one step, without loss of frames. Raises NotInitialised, BadFilter."""
        sizes = self.format_filter(False).size, self.format_filter(True).size
        chosen = message_filter(standard.mode, sizes[0], extended.mode, sizes[1])
        for content, made in ((standard, chosen.standard), (extended, chosen.extended)):
            made.set_pattern(*content.pattern)
            for code, mask in content.listed:
                made.add(code, mask)
        assert self.channel is not None
        self.channel.filter = self.filter = chosen

    def check_inactive(self) -> None:
        if self.active:
            raise WrongState(f"{self.slot.can.line.name}: deactivate the channel to change its filter")

    def count_refused(self, count: int) -> None:
        """Count frames that the client had no room for. Raises NotInitialised before `set_up`, BadValue below 0."""
        if self.channel is None:
            raise NotInitialised(f"{self.slot.can.line.name}: set the channel up first")
        if count < 0:
            raise BadValue(f"{count} refused frames: a count from 0 up")
        self.channel.refused += count
        self.channel.sent += count

    def counted(self, name: str) -> int:
        return 0 if self.channel is None else int(getattr(self.channel, name))

    def status(self) -> ChannelStatus:
        channel = self.channel
        if channel is None:
            return ChannelStatus(False, 0, 0, 0, 0, 0, 0, 0)
        waiting = channel.transmit.fill()
        return ChannelStatus(
            active=self.active,
            accepted=int(channel.accepted),
            lost=int(channel.lost),
            sent=int(channel.sent) + waiting,
            delivered=int(channel.delivered),
            aborted=int(channel.aborted),
            refused=int(channel.refused),
            pending=int(channel.in_flight) + waiting,
        )

    def leave(self) -> None:
        """Discard frames that wait to be sent, and release the memory."""
        if self.channel is not None:
            self.activate(False)
            self.slot.can.line.cancel(self.channel)
        self._forget_queues()
        self.slot.queues.remove(self)

    def _take_time(self, channel: Channel, ticks: bool) -> None:
        if ticks:
            capabilities = self.slot.can.info.capabilities
            channel.tick_ns = capabilities.stamps.tick_ns
            channel.delay_tick_ns = max(1, capabilities.delay.tick_ns)
            channel.longest_delay = capabilities.delay.maximum

    def _forget_queues(self) -> None:
        if self._queues is not None:
            self._queues.close()
        self._queues = self.channel = self.filter = None
