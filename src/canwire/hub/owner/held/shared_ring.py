"""The hub's ends of rings in memory that a client has too: events signal the client, a doorbell the hub."""

from __future__ import annotations

from canwire.hub.owner.held.bells import Bells
from canwire.hub.owner.held.held import Halts
from canwire.hub.protocol.queues import transmit_offset
from canwire.platform import (
    Descriptor,
    EventDescriptor,
    close_descriptors,
    create_memory,
    map_memory,
    shared_event,
)
from canwire.ring import Ring, Signalled, ring_size, rounded_capacity


class Halting:
    """An event that also ends the passing of virtual time: somebody has something to look at."""

    def __init__(self, event: EventDescriptor, halts: Halts) -> None:
        self._event = event
        self._halts = halts

    def signal(self) -> None:
        self._event.signal()
        self._halts.halt()

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("only the other end of a ring waits here")


class SharedRings:
    """A ring that a client reads and, with room for `transmit` frames, one that it writes; in one memory.

    `hand_over` gives the client its descriptors; the hub itself keeps one for each event, and the memory. `halts`
    is called at signals in virtual time; with `bells` they are given when those are rung. Raises BadValue, and OSError
    with nothing left behind.
    """

    def __init__(
        self,
        receive: int,
        transmit: int,
        *,
        exact: bool,
        doorbell: EventDescriptor | None,
        halts: Halts | None,
        bells: Bells | None = None,
    ) -> None:
        self._halts = halts
        self._bells = bells
        self._events: list[EventDescriptor] = []
        self._for_client: list[Descriptor] = []
        begin = transmit_offset(receive)
        size = begin + (ring_size(rounded_capacity(transmit)) if transmit else 0)
        try:
            self._for_client.append(create_memory(size))
            memory = map_memory(self._for_client[0])
            self.receive = Ring(receive, exact=exact, buffer=memory[:begin])
            self.receive.event, self.receive.free_event = self._event(), doorbell
            self.transmit: Ring | None = None
            if transmit:
                self.transmit = Ring(transmit, exact=exact, buffer=memory[begin:])
                self.transmit.event, self.transmit.free_event = doorbell, self._event()
        except BaseException:
            self._close()
            raise

    def hand_over(self) -> tuple[Descriptor, ...]:
        """Memory, the receive ring's event, the transmit ring's event if there is one; once, they are the asker's."""
        given, self._for_client = tuple(self._for_client), []
        return given

    def close(self) -> None:
        """Let go of memory and events; the client keeps what it has.

        A frame that is on the wire then may still be reported here: no client is signalled any more.
        """
        for ring in (self.receive, self.transmit):
            if ring is not None:
                ring.event = ring.free_event = None
        self._close()

    def _event(self) -> Signalled:
        event = shared_event()
        self._events.append(event)
        self._for_client += event.copies()
        if self._bells is not None:
            return self._bells.late(event)
        return event if self._halts is None else Halting(event, self._halts)

    def _close(self) -> None:
        for event in self._events:
            event.close()
        close_descriptors(*self.hand_over())
