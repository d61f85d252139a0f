"""The hub's end of a page by which a thread waits for its turns."""

from __future__ import annotations

from canwire.hub.protocol.turn_page import SIZE, TurnPage
from canwire.platform import EventDescriptor, close_descriptors, create_memory, map_memory


class SharedPage:
    """New memory and a new event for a thread; `hand_over` returns the program's descriptors.

    Raises OSError, and then leaves nothing open.
    """

    def __init__(self, thread: int) -> None:
        self.thread = thread
        memory = create_memory(SIZE)
        try:
            self.words = TurnPage(map_memory(memory))
            self._event = EventDescriptor(shared=True)
            self._for_program: tuple[int, ...] = (memory, *self._event.copies())
        except BaseException:
            close_descriptors(memory)
            raise

    def hand_over(self) -> tuple[int, ...]:
        """The descriptors of memory and event, once; the caller owns them."""
        given, self._for_program = self._for_program, ()
        return given

    def give(self, now_ns: int) -> None:
        """Let the thread run; the time is `now_ns`."""
        self.words.give(now_ns)
        self._event.signal()

    def close(self) -> None:
        self._event.close()
        close_descriptors(*self.hand_over())
