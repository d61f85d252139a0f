"""A bell between programs: who has it open sees in shared memory that it was rung, without asking the hub.

It is a FIFO of the hub that nobody reads: each ring puts an element into it, or is counted as lost once it is full.
Its number is in a note.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import NoSuchBoard

if TYPE_CHECKING:
    from canwire import Fifo, Hub


class Bell:
    """`ring` after what the others are to look at has changed; `count` before looking at it."""

    def __init__(self, fifo: Fifo) -> None:
        self._fifo = fifo
        self._ring = fifo.end_of_ring.ring

    @classmethod
    def find(cls, hub: Hub, note: str) -> Bell | None:
        """The bell in a note; None if there is none, or all who had it open are gone."""
        number = hub.note(note)
        try:
            return cls(hub.open_fifo(int(number), "fifo")) if number else None
        except NoSuchBoard:
            return None

    @classmethod
    def make(cls, hub: Hub, note: str) -> Bell:
        """A new one; one at a time may do this."""
        fifo = hub.create_fifo(1, 1)
        hub.set_note(note, str(fifo.id).encode())
        return cls(fifo)

    @property
    def count(self) -> int:
        """Another number than before: it was rung."""
        return self._ring.written + self._ring.lost

    def ring(self) -> None:
        self._ring.put_bytes(b"\0")

    def close(self) -> None:
        self._fifo.close()
