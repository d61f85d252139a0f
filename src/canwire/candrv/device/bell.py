"""A bell between programs: a program that has it open sees in shared memory that it was rung, without a request.

It is a FIFO of the hub that no program reads: each ring puts an element into it, or counts as lost once it is full.
Its number is in a note of the hub.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import NoSuchBoard

if TYPE_CHECKING:
    from canwire import Fifo, Hub


class Bell:
    """Call `ring` after a change that other programs must see; read `count` before you read what may have changed."""

    def __init__(self, fifo: Fifo) -> None:
        self._fifo = fifo
        self._ring = fifo.end_of_ring.ring

    @classmethod
    def find(cls, hub: Hub, note: str) -> Bell | None:
        """The bell in a note; None if the note has none, or if no program has it open any more."""
        number = hub.note(note)
        try:
            return cls(hub.open_fifo(int(number), "fifo")) if number else None
        except NoSuchBoard:
            return None

    @classmethod
    def make(cls, hub: Hub, note: str) -> Bell:
        """A new bell. The caller must prevent that two programs do this at the same time."""
        fifo = hub.create_fifo(1, 1)
        hub.set_note(note, str(fifo.id).encode())
        return cls(fifo)

    @property
    def count(self) -> int:
        """A number that changes with each ring."""
        return self._ring.written + self._ring.lost

    def ring(self) -> None:
        self._ring.put_bytes(b"\0")

    def close(self) -> None:
        self._fifo.close()
