"""The rings that a reply opens with a handle: taken over at the hub's end of a link, and copied for a client."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from canwire.hub.links.network.cuts.age import Age, OtherClock
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.mirrors import Outgoing
from canwire.hub.links.network.moved import Mirror
from canwire.hub.links.network.watched import Watched
from canwire.hub.owner.held.shared_ring import SharedRings
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.queues import transmit_offset
from canwire.hub.protocol.roles import FIFO, READER, WRITER
from canwire.platform import EventDescriptor, close_descriptors, create_memory, map_memory
from canwire.ring import Ring, ring_size, rounded_capacity

Filled = tuple[tuple[int, int], ...]
GiveUp = Callable[[int, int, float], object]  # handle, frames, their age in s


class Opened(NamedTuple):
    """A mirror and its events (Pump.add)."""

    mirror: Mirror
    events: tuple[EventDescriptor, ...]


def role_of(request: m.Message) -> str:
    """The role in which a request opens a FIFO."""
    return request.role if isinstance(request, m.OpenFifo) else FIFO


def taken_over(
    request: m.Message,
    reply: m.Message,
    descriptors: tuple[int, ...],
    doorbell: EventDescriptor,
    number: Callable[[], int],
    told: Callable[[], object] | None = None,
    age: Age | None = None,
    give_up: GiveUp = lambda handle, count, age_s: None,
) -> list[Opened]:
    """For the hub's end: take over the rings of a reply, whose records are sent to a remote client.

    `told` is called when the other end of a FIFO is signalled, `give_up` when frames to send are older than `age`.
    """
    if not descriptors:
        return []
    memory, *events = descriptors
    try:
        if isinstance(reply, m.FifoOpened):
            return [_fifo_here(reply, role_of(request), memory, tuple(events), number(), told)]
        assert isinstance(reply, m.ChannelOpened), f"{reply} has descriptors that nobody knows"
        given_up = partial(give_up, getattr(request, "handle", 0))
        return _queues_here(reply, memory, tuple(events), doorbell, number, age, given_up)
    finally:
        close_descriptors(memory)


def _queues_here(
    reply: m.ChannelOpened,
    memory: int,
    events: tuple[int, ...],
    doorbell: EventDescriptor,
    number: Callable[[], int],
    age: Age | None,
    give_up: Callable[[int, float], object],
) -> list[Opened]:
    heard = EventDescriptor.adopt_each(events, 2 if reply.transmit else 1)
    queues = map_memory(memory)
    begin = transmit_offset(reply.receive)
    receive = Ring(reply.receive, exact=True, buffer=queues[:begin])
    receive.event, receive.free_event = heard[0], doorbell
    opened = [Opened(Outgoing(number(), receive, frames=True), (heard[0],))]
    if reply.transmit:
        transmit = Ring(reply.transmit, exact=True, buffer=queues[begin:])
        transmit.event, transmit.free_event = doorbell, heard[1]
        opened.append(Opened(Incoming(number(), transmit, age, give_up), (heard[1],)))
    return opened


class Also:
    """An event, and a function that is also called when it is signalled."""

    def __init__(self, event: EventDescriptor, told: Callable[[], object]) -> None:
        self._event = event
        self._told = told

    def signal(self) -> None:
        self._event.signal()
        self._told()

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("only the other end of a FIFO waits here")


def _fifo_here(
    reply: m.FifoOpened,
    role: str,
    memory: int,
    events: tuple[int, ...],
    number: int,
    told: Callable[[], object] | None,
) -> Opened:
    ring = Ring.over(memory, reply.capacity, exact=True, record_size=reply.element_size)
    ring.event, ring.free_event = reader, writer = EventDescriptor.adopt_each(events, 2)
    if told is not None and role == READER:
        ring.free_event = Also(writer, told)
    elif told is not None:
        ring.event = Also(reader, told)
    if role == READER:
        return Opened(Outgoing(number, ring), (reader, writer))
    if role == WRITER:
        return Opened(Incoming(number, ring), (writer, reader))
    return Opened(Watched(number, ring), (reader, writer))


def filled(opened: Sequence[Opened]) -> Filled:
    """The number of each ring, and how many records its copy at the client begins with."""
    return tuple(
        (one.mirror.number, one.mirror.filled if isinstance(one.mirror, Incoming) else 0) for one in opened
    )


class Copies(NamedTuple):
    """A client's end: mirrors with their events, descriptors for the program's handle, other objects to close."""

    opened: list[Opened]
    descriptors: tuple[int, ...]
    rings: SharedRings | None

    def let_go(self) -> None:
        """Close everything; call this once no ring is moved."""
        if self.rings is not None:
            self.rings.close()


def copied(
    request: m.Message, reply: m.Message, rings: Filled, doorbell: EventDescriptor, clock: OtherClock
) -> Copies:
    """The client's end of the rings that a reply opened; raises OSError if memory or descriptors run out."""
    if not rings:
        return Copies([], (), None)
    if isinstance(reply, m.FifoOpened):
        return _fifo_copied(reply, role_of(request), rings[0], doorbell)
    assert isinstance(reply, m.ChannelOpened), f"{reply} with rings that nobody knows"
    made = SharedRings(reply.receive, reply.transmit, exact=True, doorbell=doorbell, halts=None)
    opened = [Opened(Incoming(rings[0][0], made.receive), ())]
    if made.transmit is not None:
        opened.append(Opened(Outgoing(rings[1][0], made.transmit, clock=clock, frames=True), ()))
    return Copies(opened, made.hand_over(), made)


def _fifo_copied(
    reply: m.FifoOpened, role: str, numbered: tuple[int, int], doorbell: EventDescriptor
) -> Copies:
    number, full = numbered
    with contextlib.ExitStack() as undoing:
        memory = create_memory(ring_size(rounded_capacity(reply.capacity), reply.element_size))
        undoing.callback(close_descriptors, memory)
        ring = Ring.over(memory, reply.capacity, exact=True, record_size=reply.element_size)
        own = EventDescriptor(shared=True)
        undoing.callback(own.close)
        pair = (doorbell, own) if role == WRITER else (own, doorbell)
        ring.event, ring.free_event = pair
        given = (*pair[0].copies(), *pair[1].copies())
        mirror: Mirror
        if role == READER:
            mirror = Incoming(number, ring)
        elif role == WRITER:
            while full > 0:  # what others wrote before and nobody has read yet takes room here, too
                room = len(ring.acquire_free(full)) // reply.element_size
                ring.commit(room)
                full -= room
            mirror = Outgoing(number, ring, ring.contents())
        else:
            mirror = Watched(number, ring, map_memory(memory))
        undoing.pop_all()
    return Copies([Opened(mirror, ())], (memory, *given), None)
