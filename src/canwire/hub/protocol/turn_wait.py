"""A program's end of a page (turn_page.py): one of its threads waits there for its turns."""

from __future__ import annotations

from collections.abc import Callable

from canwire.hub.protocol.turn_page import TurnPage
from canwire.platform import EventDescriptor, close_descriptors, map_memory


class TurnWait:
    """`ring` tells the hub that there is something to look at. Takes over the descriptors of m.Joined."""

    def __init__(self, ring: Callable[[], object], memory: int, *event: int) -> None:
        self._ring = ring
        self._over = False
        self._words = TurnPage(map_memory(memory))
        self._event = EventDescriptor.adopt(*event)
        self._latest = 0
        close_descriptors(memory)

    def wait(self, until_ns: int) -> int | None:
        """The time at the next turn; None: the hub is gone, or another wait has begun since."""
        words = self._words
        asked = self._latest = words.ask(until_ns)
        self._ring()
        while not words.given(asked):
            if self._over:
                return None
            if self._latest != asked:
                self._event.signal()  # this wake-up may have been the other one's
                return None
            self._event.rest()
        return words.now_ns()

    def stir(self) -> None:
        """The program's other threads look again; `ring` is still to be called."""
        self._words.stir()

    def end(self) -> None:
        """The connection has ended: whoever waits need not any longer."""
        self._over = True
        self._event.signal()
