"""Places on the wire by name: a bit of a frame, of an error flag, of a delimiter, of the intermission ...

A `Place` is where a disturbance begins; `Progress` follows one node from bit to bit and says where it is.
"""

from __future__ import annotations

from dataclasses import dataclass

from canwire.bus.can import station
from canwire.bus.can.bit_layout import BitLayout
from canwire.bus.can.clock import Clock
from canwire.bus.can.node import Node
from canwire.errors import BadValue
from canwire.values.frame import Frame

FIELDS = {
    "identifier": "ID",
    "dlc": "DLC",
    "data": "DATA",
    "crc": "CRC",
    "crc delimiter": "CRC DEL",
    "ack": "ACK",
    "ack delimiter": "ACK DEL",
    "eof": "EOF",
}
_PHASES = {
    "error flag": (station.ACTIVE_FLAG, station.PASSIVE_FLAG),
    "overload flag": (station.OVERLOAD_FLAG,),
    "error delimiter": (station.DELIMITER,),
    "overload delimiter": (station.DELIMITER,),
    "intermission": (station.INTERMISSION,),
    "suspend": (station.SUSPEND,),
    "idle": (station.IDLE,),
}
FRAME = "frame"
PARTS = (FRAME, *FIELDS, *_PHASES)
_COUNTED = {  # states that know how many of their bits are left
    station.ACTIVE_FLAG: 6, station.OVERLOAD_FLAG: 6, station.INTERMISSION: 3, station.SUSPEND: 8,
}  # fmt: skip
_LONGEST = {"error delimiter": 8, "overload delimiter": 8, "intermission": 3, "suspend": 8}


@dataclass(frozen=True, slots=True)
class Place:
    """The start of one bit, the next time that a node reaches it.

    `part` is "frame", one of its fields, or a part after a frame (PARTS); `bit` counts from 1 in the order of the wire,
    stuff bits included, in "frame" from 0 (SOF). Bit 1 of a delimiter is its first recessive bit, which is known as
    such only afterwards: the first possible place in it is bit 2. `node` is the node whose bits are counted (None: the
    sender of the last frame); `frame_id` and `extended` select the frames in or after which the place is (None: any).
    """

    part: str
    bit: int = 1
    frame_id: int | None = None
    extended: bool | None = None
    node: Node | None = None

    def __post_init__(self) -> None:
        if self.part not in PARTS:
            raise BadValue(f"part {self.part!r}: one of {', '.join(PARTS)}")
        first = 0 if self.part == FRAME else 2 if "delimiter" in self.part and self.part in _PHASES else 1
        last = _LONGEST.get(self.part)
        if not isinstance(self.bit, int) or self.bit < first or (last is not None and self.bit > last):
            raise BadValue(f"bit {self.bit!r} of {self.part}: from {first}{f' to {last}' if last else ''}")

    def admits(self, frame: Frame | None) -> bool:
        """Whether the place is in this frame or after it; None means an unknown frame."""
        if frame is None:
            return self.frame_id is None and self.extended is None
        wanted_id = self.frame_id is None or self.frame_id == frame.id
        return wanted_id and (self.extended is None or self.extended == frame.extended)

    def index_in(self, layout: BitLayout) -> int:
        """The index of the place's bit in the frame, counted from SOF; -1 if it is not in this frame."""
        if self.part == FRAME:
            return self.bit
        if self.part not in FIELDS:
            return -1
        at = layout.find(FIELDS[self.part])
        last = layout.fields.rfind(layout.fields[at]) if at >= 0 else -1
        index = at + self.bit - 1
        return index if index <= last else -1

    def outlasts_the_frame(self) -> bool:
        """Whether the bus may already rest before a node reaches the place."""
        return self.part in ("suspend", "idle")


def indices(places: list[Place], frame: Frame | None, sender: Node | None) -> dict[int, int]:
    """The index of each place's bit in this frame, by `id(place)`; places that do not admit the frame are left out."""
    if frame is None or sender is None:
        return {}
    layout = BitLayout(frame, fd_mode=sender.fd, error_passive=sender.passive)
    return {id(place): place.index_in(layout) for place in places if place.admits(frame)}


class Progress:
    """The position of one node: the part that its present bit belongs to, and the number of that bit in the part.

    If the node was not watched before, its position starts from the state of its clock.
    """

    def __init__(self, clock: Clock | None = None) -> None:
        self.part = ""
        self.bit = 0
        self._state = -1
        if clock is not None and clock.station.state in _COUNTED:
            machine = clock.station
            self._state, self.part = machine.state, _part_of(machine.state)
            self.bit = _COUNTED[machine.state] - machine.left + clock.sampling

    def begin_bit(self, clock: Clock) -> None:
        machine = clock.station
        if machine.state == station.FRAME:
            self.part, self.bit = FRAME, machine.index
        elif machine.state == station.DELIMITER:
            self.part, self.bit = _delimiter(machine.overload), 9 - machine.left
        elif machine.state != self._state or machine.left == _full(machine.state):
            self.part, self.bit = _part_of(machine.state), 1
        else:
            self.bit += 1
        self._state = machine.state


def _delimiter(overload: bool) -> str:
    return "overload delimiter" if overload else "error delimiter"


def _full(state: int) -> int:
    """`left` in the first bit of an active error or overload flag (two flags may be adjacent); else -1."""
    return 6 if state in (station.ACTIVE_FLAG, station.OVERLOAD_FLAG) else -1


def _part_of(state: int) -> str:
    for part, states in _PHASES.items():
        if state in states:
            return part
    return ""
