"""A FIFO between any two clients, of elements of any size: the hub makes it, and ensures that each end is open once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.hub.handles.ends import RingEnd
from canwire.hub.handles.lease import Lease
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.roles import WRITER
from canwire.platform import Descriptor, EventDescriptor, close_descriptors
from canwire.ring import Ring

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client


class Telling:
    """The event of the other end in lockstep time: the hub has to know that the other program may continue."""

    def __init__(self, event: EventDescriptor, hub: Client) -> None:
        self._event = event
        self._hub = hub

    def signal(self) -> None:
        self._event.signal()
        self._hub.stir_everybody()

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("only the other end of a FIFO waits here")


class Fifo(Lease):
    """A reference to a FIFO in one of three roles: "fifo" monitors it, "reader" and "writer" are its ends.

    The FIFO exists while references to it exist. Each end can only be open once at a time.
    """

    def __init__(
        self, hub: Client, opened: m.FifoOpened, role: str, descriptors: tuple[Descriptor, ...]
    ) -> None:
        super().__init__(hub, opened.handle, f"FIFO {opened.fifo} ({role})")
        self.id = opened.fifo
        self.role = role
        self.capacity = opened.capacity
        self.element_size = opened.element_size
        memory, *events = descriptors
        ring = Ring.over(memory, opened.capacity, exact=True, record_size=opened.element_size)
        lent = hub.lent(memory)
        close_descriptors(memory)
        reader, writer = EventDescriptor.adopt_each(tuple(events), 2)
        ring.event, ring.free_event = reader, writer
        own, self._other = (writer, reader) if role == WRITER else (reader, writer)
        if hub.timed and not hub.copies:
            telling = Telling(self._other, hub)
            if role == WRITER:
                ring.event = telling
            else:
                ring.free_event = telling
        self.end_of_ring = RingEnd(self, ring, own, reads=role != WRITER, memory=lent)

    def reset(self) -> None:
        """Empty the FIFO; raises WrongState while a reader or writer is open."""
        self.ask(m.ResetFifo(self._handle))

    def end(self, why: Exception) -> None:
        super().end(why)
        self.end_of_ring.wake()

    def leave_to_parent(self, why: Exception) -> None:
        super().leave_to_parent(why)
        self.end_of_ring.leave_to_parent()

    def close(self) -> None:
        super().close()
        self.end_of_ring.close()
        self._other.close()
