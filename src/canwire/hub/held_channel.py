"""A client's channel as the hub holds it: queues in shared memory, a filter, and whether it is active."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from canwire.boards.channel import Channel
from canwire.boards.message_filter import FormatFilter, MessageFilter, message_filter
from canwire.boards.modes import ChannelMode, ChannelStatus
from canwire.errors import NotInitialised, WrongState
from canwire.hub.held import OnLine, Slot
from canwire.platform import EventDescriptor, close_descriptors, create_memory
from canwire.ring import Ring, ring_size, rounded_capacity

if TYPE_CHECKING:
    from canwire.hub.session import Session


class Halting:
    """An event that also ends the passing of virtual time: somebody has something to look at."""

    def __init__(self, event: EventDescriptor, slot: Slot) -> None:
        self._event = event
        self._timeline = slot.can.line.timeline

    def signal(self) -> None:
        self._event.signal()
        self._timeline.halt()

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("only the other end of a ring waits here")


@dataclass
class HeldChannel(OnLine):
    """A client's channel: its queues once it is set up, its filter, and whether it is active."""

    slot: Slot
    holder: Session
    exclusive: bool
    channel: Channel | None = None
    active: bool = False
    filter: MessageFilter | None = None
    _descriptors: tuple[int, ...] = ()
    _events: list[EventDescriptor] = field(default_factory=list)

    def set_up(self, mode: ChannelMode, doorbell: EventDescriptor | None) -> tuple[int, ...]:
        """New queues in new memory; descriptors for the client: receive memory and event, [transmit ...].

        Raises BadValue or BadFilter, and leaves everything as it was then.
        """
        size = mode.filter_size
        chosen = message_filter(mode.filter_mode, 2048 if size else 0, mode.filter_mode, size)
        for capacity in (mode.receive, mode.transmit) if mode.transmit else (mode.receive,):
            rounded_capacity(capacity)
        self.activate(False)
        self._forget_queues()
        receive = self._queue(mode.receive, mode.exact, doorbell, reads=True)
        transmit = self._queue(mode.transmit, mode.exact, doorbell, reads=False) if mode.transmit else None
        self.channel = self._new_channel(mode, receive, transmit)
        self.channel.filter = self.filter = chosen
        return self._descriptors

    def _new_channel(self, mode: ChannelMode, receive: Ring, transmit: Ring | None) -> Channel:
        channel = Channel(
            mode.receive,
            mode.transmit,
            frames=mode.frames,
            events=frozenset(mode.events),
            siblings=mode.siblings,
            rings=(receive, transmit),
        )
        channel.untrusted = True
        channel.fd = mode.fd
        self._take_time(channel, mode.ticks)
        return channel

    def activate(self, active: bool) -> None:
        """Connect the queues to the line, or take them off it; raises NotInitialised before `set_up`."""
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
                line.open(self.channel)
                self.channel.transmit.arm()
                line.kick()
            else:
                line.close(self.channel)

    def format_filter(self, extended: bool) -> FormatFilter:
        """Raises NotInitialised before `set_up`."""
        if self.filter is None:
            raise NotInitialised(f"{self.slot.can.line.name}: a channel has filters once it is set up")
        return self.filter.of(extended)

    def check_inactive(self) -> None:
        if self.active:
            raise WrongState(f"{self.slot.can.line.name}: deactivate the channel to change its filter")

    def counted(self, name: str) -> int:
        """One of the channel's counters; 0 before it is set up."""
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

    def let_go(self) -> None:
        """Give up what waits to be sent, and the memory."""
        if self.channel is not None:
            self.activate(False)
            self.slot.can.line.cancel(self.channel)
        self._forget_queues()
        self.slot.channels.remove(self)

    def _take_time(self, channel: Channel, ticks: bool) -> None:
        if ticks:
            capabilities = self.slot.can.info.capabilities
            channel.tick_ns = capabilities.stamps.tick_ns
            channel.delay_tick_ns = max(1, capabilities.delay.tick_ns)
            channel.longest_delay = capabilities.delay.maximum

    def _queue(self, capacity: int, exact: bool, doorbell: EventDescriptor | None, *, reads: bool) -> Ring:
        """A ring whose other end is the client's: the client is told by a new event, the hub by the doorbell."""
        memory = create_memory(ring_size(rounded_capacity(capacity)))
        event = EventDescriptor()
        self._descriptors = (*self._descriptors, memory, event.fileno())
        self._events.append(event)
        ring = Ring.over(memory, capacity, exact=exact)
        told = Halting(event, self.slot) if self.holder.virtual else event
        if reads:
            ring.event, ring.free_event = told, doorbell
        else:
            ring.event, ring.free_event = doorbell, told
        return ring

    def _forget_queues(self) -> None:
        for event in self._events:
            event.close()
        close_descriptors(*self._descriptors[::2])
        self._descriptors, self._events, self.channel, self.filter = (), [], None, None
