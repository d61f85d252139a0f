"""The hub's end of a ring in memory that a client has too: the client is told by an event, the hub by a doorbell."""

from __future__ import annotations

from canwire.platform import EventDescriptor, close_descriptors, create_memory
from canwire.ring import Ring, Signalled, ring_size, rounded_capacity
from canwire.timeline import Timeline


class Halting:
    """An event that also ends the passing of virtual time: somebody has something to look at."""

    def __init__(self, event: EventDescriptor, timeline: Timeline) -> None:
        self._event = event
        self._timeline = timeline

    def signal(self) -> None:
        self._event.signal()
        self._timeline.halt()

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("only the other end of a ring waits here")


class SharedRing:
    """A ring, and the `descriptors` (memory, event) that its client needs. `timeline` is given in virtual time."""

    def __init__(self, capacity: int, exact: bool, timeline: Timeline | None) -> None:
        self._memory = create_memory(ring_size(rounded_capacity(capacity)))
        self._event = EventDescriptor()
        self.ring = Ring.over(self._memory, capacity, exact=exact)
        self._told: Signalled = self._event if timeline is None else Halting(self._event, timeline)

    @classmethod
    def receiving(
        cls, capacity: int, exact: bool, doorbell: EventDescriptor | None, timeline: Timeline | None
    ) -> SharedRing:
        """The client reads."""
        shared = cls(capacity, exact, timeline)
        shared.ring.event, shared.ring.free_event = shared._told, doorbell
        return shared

    @classmethod
    def transmitting(
        cls, capacity: int, exact: bool, doorbell: EventDescriptor | None, timeline: Timeline | None
    ) -> SharedRing:
        """The client writes."""
        shared = cls(capacity, exact, timeline)
        shared.ring.event, shared.ring.free_event = doorbell, shared._told
        return shared

    @property
    def descriptors(self) -> tuple[int, ...]:
        """Memory and event; they stay the ring's own."""
        return self._memory, self._event.fileno()

    def close(self) -> None:
        """Let go of memory and event; the client keeps what it has.

        A frame that is on the wire then may still be told of here: nobody is signalled any more.
        """
        self.ring.event = self.ring.free_event = None
        self._event.close()
        close_descriptors(self._memory)
