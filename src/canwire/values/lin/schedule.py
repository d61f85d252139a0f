"""Schedule tables: the slots that a master sends in order.

Source: LIN 2.2A 2.3.3 (frame types) and 2.4 (schedules); reference/lin-protocol.md section 6.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

from canwire.errors import BadFrame, BadValue
from canwire.values.lin.frame import LARGEST_LENGTH, MASTER_REQUEST, SLAVE_RESPONSE, protected_id

LONGEST_SLOT_NS = 1 << 40


class SlotKind(Enum):
    """What happens in a slot.

    FRAME: the master sends its header, and the publisher answers. EVENT: one header for frames of several slaves;
    only slaves with changed data answer, and resolving slots follow a collision. SPORADIC: the first updated
    frame of several frames of the master, or nothing. REQUEST and RESPONSE: diagnostic frames
    0x3C and 0x3D, if there is something to send or to fetch.
    """

    FRAME = "frame"
    EVENT = "event"
    SPORADIC = "sporadic"
    REQUEST = "request"
    RESPONSE = "response"


@dataclass(frozen=True, slots=True)
class LinSlot:
    """One slot of a table; the class methods make each kind. Raises BadValue for an impossible slot.

    `delay_ns` is the time to the next slot, 0 for the shortest multiple of 5 ms that holds any frame. `ids` are
    the frames it may send, for SPORADIC in order of priority. `length` is how many bytes the response has,
    0 for as many as come. `members` are an EVENT's frames, `resolving` the slots after its collision
    (none given: each member once). `data` is what a REQUEST always sends, None for what waits in the queue.
    """

    kind: SlotKind
    ids: tuple[int, ...]
    delay_ns: int = 0
    length: int = 0
    members: tuple[int, ...] = ()
    resolving: tuple[LinSlot, ...] = ()
    data: bytes | None = None

    def __post_init__(self) -> None:
        for id in (*self.ids, *self.members):
            _check_id(self.kind, id)
        if not self.ids or (self.kind is not SlotKind.SPORADIC and len(self.ids) > 1):
            raise BadValue(f"{self.kind.value} slot with identifiers {self.ids}: it needs one of them")
        if not isinstance(self.delay_ns, int) or not 0 <= self.delay_ns <= LONGEST_SLOT_NS:
            raise BadValue(f"delay_ns {self.delay_ns!r}: from 1 to {LONGEST_SLOT_NS}, or 0 for the usual one")
        if not isinstance(self.length, int) or not 0 <= self.length <= LARGEST_LENGTH:
            raise BadValue(f"length {self.length!r}: from 1 to 8, or 0 for as many as come")
        if self.data is not None and (self.kind is not SlotKind.REQUEST or len(self.data) != LARGEST_LENGTH):
            raise BadValue(f"data {self.data.hex(' ')}: only a master request has it, and 8 bytes of it")
        if self.kind is SlotKind.EVENT and not self.members:
            raise BadValue(f"event slot {self.ids[0]:#x}: name the frames that answer it")

    @classmethod
    def frame(cls, id: int, *, delay_ns: int = 0, length: int = 0) -> LinSlot:
        """An unconditional frame."""
        return cls(SlotKind.FRAME, (id,), delay_ns, length)

    @classmethod
    def event(
        cls,
        id: int,
        frames: Iterable[int],
        *,
        delay_ns: int = 0,
        length: int = 0,
        resolving: Sequence[LinSlot] = (),
    ) -> LinSlot:
        """An event-triggered frame for these frames of different slaves."""
        members = tuple(frames)
        slots = tuple(resolving) or tuple(cls.frame(member, delay_ns=delay_ns) for member in members)
        return cls(SlotKind.EVENT, (id,), delay_ns, length, members, slots)

    @classmethod
    def sporadic(cls, ids: Iterable[int], *, delay_ns: int = 0) -> LinSlot:
        """Frames of the master, the most urgent first."""
        return cls(SlotKind.SPORADIC, tuple(ids), delay_ns)

    @classmethod
    def request(cls, data: bytes | None = None, *, delay_ns: int = 0) -> LinSlot:
        """A master request: these 8 bytes each time, or what waits in the queue of requests."""
        return cls(SlotKind.REQUEST, (MASTER_REQUEST,), delay_ns, LARGEST_LENGTH, data=data)

    @classmethod
    def response(cls, *, delay_ns: int = 0) -> LinSlot:
        """A slave response."""
        return cls(SlotKind.RESPONSE, (SLAVE_RESPONSE,), delay_ns, LARGEST_LENGTH)


@dataclass(frozen=True, slots=True)
class LinSchedule:
    """A table of slots that repeats until another one takes over; raises BadValue for an empty one."""

    name: str
    slots: tuple[LinSlot, ...]

    def __post_init__(self) -> None:
        if not self.slots or not all(isinstance(slot, LinSlot) for slot in self.slots):
            raise BadValue(f"schedule {self.name!r}: one LinSlot at least, and nothing else")

    @classmethod
    def of(cls, slots: Iterable[int | LinSlot], name: str = "") -> LinSchedule:
        """A table of slots; an identifier alone is an unconditional frame with the default delay."""
        made = tuple(slot if isinstance(slot, LinSlot) else LinSlot.frame(slot) for slot in slots)
        return cls(name, made)


def _check_id(kind: SlotKind, id: int) -> None:
    try:
        protected_id(id)
    except BadFrame as error:
        raise BadValue(f"{kind.value} slot: {error}") from None
