"""Rings that the program may use: their places in memory, and a word for each that shows when its use is over."""

from __future__ import annotations

import itertools
import mmap
import os
import struct
import threading
from functools import partial
from typing import TYPE_CHECKING

from canwire.native.helper.answers import Reply

if TYPE_CHECKING:
    from canwire import Event, RingEnd

PLACE = struct.Struct("<QIIII")
"""struct cw_place of ../core/canwire.h."""

_STATES = 1 << 16  # words; used again after this many rings
_WORD = 4
_OVER = struct.pack("<I", 1)


class States:
    """The page of states, which the program reads: 0 while a ring can be used."""

    def __init__(self) -> None:
        self.descriptor = os.memfd_create("canwire-states", os.MFD_CLOEXEC)
        os.ftruncate(self.descriptor, _STATES * _WORD)
        self._page = mmap.mmap(self.descriptor, _STATES * _WORD)
        self._numbers = itertools.count()
        self._lock = threading.Lock()

    def page(self) -> Reply:
        """A reply that gives the program this page."""
        return Reply(descriptors=duplicates(self.descriptor))

    def new(self) -> int:
        with self._lock:
            number = next(self._numbers) % _STATES
        self._write(number, bytes(_WORD))
        return number

    def end(self, number: int) -> None:
        """Mark the ring of this word as over."""
        self._write(number, _OVER)

    def lend(self, end: RingEnd, value: int = 0, data: bytes = b"") -> Reply:
        """A reply that gives the program this end of a ring to use, which cw_ring_open takes; `data` follows."""
        number = self.new()
        lent = end.lend(partial(self.end, number))
        if end.lease.over:
            self.end(number)
        ring = end.ring
        place = PLACE.pack(lent.begin, ring.capacity, ring.record_size, end.reads, number)
        events = (lent.own,) if lent.peer is None else (lent.own, lent.peer)
        return Reply(
            0, value, place + data, duplicates(lent.memory.fileno(), *(event.fileno() for event in events))
        )

    def watch(self, event: Event) -> Reply:
        """A reply with a descriptor that becomes readable each time this event is signalled."""
        return Reply(descriptors=duplicates(event.signals[0].descriptor.fileno()))

    def _write(self, number: int, word: bytes) -> None:
        self._page[number * _WORD : (number + 1) * _WORD] = word


def duplicates(*descriptors: int) -> tuple[int, ...]:
    """Duplicate all descriptors, for a reply to own; raises OSError with none left open."""
    made: list[int] = []
    try:
        for descriptor in descriptors:
            made.append(os.dup(descriptor))
    except OSError:
        for descriptor in made:
            os.close(descriptor)
        raise
    return tuple(made)
