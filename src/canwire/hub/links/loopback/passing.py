"""The objects that a hub has passed to one client of a loopback link: memory by name, events by number."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.errors import BadMessage, LimitReached
from canwire.hub.links.loopback import asides
from canwire.platform.portable.events import EventDescriptor, SharedEvent
from canwire.platform.portable.memory import Memory

if TYPE_CHECKING:
    from canwire.platform import Descriptor

_MOST_UNFETCHED = 256


class Passing:
    """Runs in the engine's thread. `tell` is called, from any thread, with the number of an event that is signalled."""

    def __init__(self, tell: Callable[[int], object]) -> None:
        self._tell = tell
        self._events: dict[int, EventDescriptor] = {}
        self._unfetched: deque[list[Memory]] = deque()
        self._last = asides.DOORBELL

    def hand_over(self, descriptors: tuple[Descriptor, ...]) -> bytes:
        """Take over these descriptors, and return what the client needs to open them.

        Raises LimitReached if too many wait to be opened.
        """
        memories = [thing for thing in descriptors if isinstance(thing, Memory)]
        if len(self._unfetched) >= _MOST_UNFETCHED:
            for thing in descriptors:
                thing.close()
            raise LimitReached(
                f"the client has not opened {len(self._unfetched)} shared memories that it requested"
            )
        items = [self._item(thing) for thing in descriptors]
        if memories:
            self._unfetched.append(memories)
        return asides.passed(items)

    def take(self, payload: bytes) -> None:
        """Process a payload of the client about passed objects; raises BadMessage."""
        letter = payload[:1]
        if letter == asides.FETCHED:
            if not self._unfetched:
                raise BadMessage("the client reports memory that was not passed to it")
            _close(self._unfetched.popleft())
        else:
            number = asides.number_in(payload)
            event = self._events.get(number)
            if event is None:  # the hub has closed it meanwhile
                return
            if letter == asides.DROPPED:
                self._forget(number)
            else:
                event.tell_others()

    def close(self) -> None:
        """Close everything: the client is gone."""
        while self._unfetched:
            _close(self._unfetched.popleft())
        for number in list(self._events):
            self._forget(number)

    def _forget(self, number: int) -> None:
        event = self._events.pop(number, None)
        if event is not None:
            event.close()

    def _item(self, thing: Memory | EventDescriptor) -> tuple[str, int, str]:
        if isinstance(thing, Memory):
            return asides.MEMORY, 0, thing.path
        self._last += 1
        self._events[self._last] = thing
        relay = _Relay(self._last, self._tell, self._forget)
        thing.follow(relay)
        if thing.is_set():
            relay.heard()
        origin = thing.beyond
        both_ways = isinstance(origin, SharedEvent) and origin.both_ways
        return asides.BOTH_WAYS if both_ways else asides.EVENT, self._last, ""


class _Relay:
    """Follows a copy of an event, and reports its signals to the client."""

    def __init__(self, number: int, tell: Callable[[int], object], forget: Callable[[int], object]) -> None:
        self._number = number
        self._tell = tell
        self._forget = forget

    def heard(self) -> None:
        self._tell(self._number)

    def cleared(self) -> None:
        """Nothing to do: the client clears its copy of the signal."""

    def ended(self) -> None:
        self._forget(self._number)


def _close(memories: list[Memory]) -> None:
    for memory in memories:
        memory.close()
