"""The hub's end of a page by which one thread waits for its turns."""

from __future__ import annotations

from canwire.hub.protocol.turn_page import SIZE, TurnPage
from canwire.platform import EventDescriptor, close_descriptors, create_memory, map_memory


class SharedPage:
    """New memory and a new event for this thread; `hand_over` has the program's descriptors.

    Raises OSError with nothing left behind.
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
        """Memory and event; once, they are the asker's."""
        given, self._for_program = self._for_program, ()
        return given

    def give(self, now_ns: int) -> None:
        """Its thread may run."""
        self.words.give(now_ns)
        self._event.signal()

    def close(self) -> None:
        self._event.close()
        close_descriptors(*self.hand_over())
