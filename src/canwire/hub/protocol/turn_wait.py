"""A program's end of a page (turn_page.py): one of its threads waits there for its turns."""

from __future__ import annotations

import threading
from collections.abc import Callable

from canwire.hub.protocol.turn_page import TurnPage
from canwire.platform import EventDescriptor, close_descriptors, map_memory


class TurnWait:
    """`ring` signals the hub to read the page. The TurnWait owns the descriptors of m.Joined."""

    def __init__(self, ring: Callable[[], object], memory: int, *event: int) -> None:
        self._ring = ring
        self._over = False
        self._waiter = 0
        self._words = TurnPage(map_memory(memory))
        self._event = EventDescriptor.adopt(*event)
        close_descriptors(memory)

    def wait(self, until_ns: int) -> int | None:
        """Wait for the next turn and return its time in ns; None if the connection has ended."""
        words = self._words
        self._waiter = threading.get_ident()
        asked = words.ask(until_ns)
        self._ring()
        while not words.given(asked):
            if self._over:
                return None
            self._event.rest()
        return words.now_ns()

    def stir(self) -> None:
        """Make the program's other threads check again; the hub still needs a message."""
        if self._waiter == threading.get_ident():
            self._words.stir()
        else:
            self._words.call()

    def end(self) -> None:
        """End all waits, after the connection has ended."""
        self._over = True
        self._event.signal()

    # in pieces, for a wait for another machine's program

    def begin(self, until_ns: int) -> int:
        """Begin a wait and return its number."""
        asked = self._words.ask(until_ns)
        self._ring()
        return asked

    def rest(self) -> None:
        """Wait until the hub gives a turn, or until the end; in one thread only."""
        self._event.rest()

    def given(self, asked: int) -> int | None:
        """Return the time in ns at the turn that ended this wait; None if it is not over."""
        return self._words.now_ns() if self._words.given(asked) else None
