"""FIFOs between any two clients: the hub allocates their memory and ensures that each end is open once."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field

from canwire.errors import BadValue, InUse, NoSuchBoard, WrongState
from canwire.hub.owner.held.held import Held
from canwire.hub.protocol.roles import FIFO, READER, WRITER
from canwire.platform import (
    Descriptor,
    EventDescriptor,
    close_descriptors,
    create_memory,
    duplicate,
    shared_event,
)
from canwire.ring import Ring, ring_size, rounded_capacity

PAGE = 4096
CONTROL = 24  # bytes of a VCI FIFO that are not the user's; source: VCI V4 manual 4
_LARGEST = 0xFFFF


@dataclass
class Pipe:
    """One FIFO, kept while references to it exist."""

    id: int
    capacity: int
    element_size: int
    memory: Descriptor
    reader_event: EventDescriptor
    writer_event: EventDescriptor
    ring: Ring
    references: int = 0
    ends: set[str] = field(default_factory=set)

    def copies(self) -> tuple[Descriptor, ...]:
        """Copies of the descriptors, which the caller owns: memory, the reader's event, the writer's event."""
        copies: list[Descriptor] = []
        try:
            copies += duplicate((self.memory,))
            copies += self.reader_event.copies()
            copies += self.writer_event.copies()
        except OSError:
            close_descriptors(*copies)
            raise
        return tuple(copies)


class Pipes:
    """All FIFOs of a hub."""

    def __init__(self) -> None:
        self._pipes: dict[int, Pipe] = {}

    def create(self, number: int, capacity: int, element_size: int) -> Pipe:
        """A FIFO that fills whole pages (rulings 12); raises BadValue."""
        for name, value in (("capacity", capacity), ("element size", element_size)):
            if not 1 <= value <= _LARGEST:
                raise BadValue(f"FIFO {name} {value}: 1 to {_LARGEST}")
        capacity = page_capacity(capacity, element_size)
        with contextlib.ExitStack() as undoing:
            memory = create_memory(ring_size(rounded_capacity(capacity), element_size))
            undoing.callback(close_descriptors, memory)
            ring = Ring.over(memory, capacity, exact=True, record_size=element_size)
            reader = undoing.enter_context(contextlib.closing(shared_event(both_ways=True)))
            writer = shared_event(both_ways=True)
            undoing.pop_all()
        pipe = self._pipes[number] = Pipe(number, capacity, element_size, memory, reader, writer, ring)
        return pipe

    def open(self, number: int, role: str) -> Pipe:
        """Add a reference; raises NoSuchBoard, BadValue, or InUse for an end that is already open."""
        pipe = self._pipes.get(number)
        if pipe is None:
            raise NoSuchBoard(f"no FIFO {number}; a FIFO is removed when no program refers to it")
        if role not in (FIFO, READER, WRITER):
            raise BadValue(f"role {role!r} of a FIFO: {FIFO}, {READER} or {WRITER}")
        if role != FIFO:
            if role in pipe.ends:
                raise InUse(f"FIFO {number}: its {role} is open already")
            pipe.ends.add(role)
        pipe.references += 1
        return pipe

    def close(self, pipe: Pipe, role: str) -> None:
        """Remove a reference; the last one removes the FIFO."""
        pipe.ends.discard(role)
        pipe.references -= 1
        if pipe.references == 0:
            del self._pipes[pipe.id]
            pipe.reader_event.close()
            pipe.writer_event.close()
            close_descriptors(pipe.memory)

    def reset(self, pipe: Pipe) -> None:
        """Empty the FIFO; raises WrongState while an end is open."""
        if pipe.ends:
            raise WrongState(f"FIFO {pipe.id}: its {' and '.join(sorted(pipe.ends))} is open")
        pipe.ring.clear()


@dataclass(eq=False)
class HeldPipe(Held):
    """A reference to a FIFO, as its reader, its writer or neither."""

    limit = "fifos"
    pipes: Pipes
    pipe: Pipe
    role: str

    def let_go(self) -> None:
        self.pipes.close(self.pipe, self.role)


def page_capacity(capacity: int, element_size: int) -> int:
    """The number of elements that fit into the whole pages needed for `capacity` elements, at most 65535.

    >>> page_capacity(32, 16)
    254
    """
    pages = -(-(capacity * element_size + CONTROL) // PAGE)
    return min(_LARGEST, (pages * PAGE - CONTROL) // element_size)
