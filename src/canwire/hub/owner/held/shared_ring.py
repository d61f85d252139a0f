"""The hub's ends of rings in memory shared with a client: events signal the client, a doorbell signals the hub."""

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
    """An event that also stops the passing of virtual time, so that its receiver can react."""

    def __init__(self, event: EventDescriptor, halts: Halts) -> None:
        self._event = event
        self._halts = halts

    def signal(self) -> None:
        self._event.signal()
        self._halts.halt()

    def wait_for(self, *_: object) -> bool:
        raise NotImplementedError("only the other end of a ring waits here")


class SharedRings:
    """A ring that a client reads and, with room for `transmit` frames, one that it writes, in one memory.

    `hand_over` returns the client's descriptors; the hub keeps one for each event, and the memory. `halts` is called
    at signals in virtual time; with `bells`, signals are given when these ring. Raises BadValue and OSError, and then
    leaves nothing open.
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
        """The descriptors, once: memory, the receive ring's event, [the transmit ring's]; the caller owns them."""
        given, self._for_client = tuple(self._for_client), []
        return given

    def close(self) -> None:
        """Release memory and events; the client keeps its own descriptors.

        A frame that is on the wire now may be reported later: that signals no client.
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
