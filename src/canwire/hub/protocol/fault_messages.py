"""Faults on a hub's buses: their values, requests and replies.

A fault is a value; `Fault` is the union of all of them, those of docs/faults.md. Lines have names like "HW000001:1".
"""

from __future__ import annotations

import msgspec

from canwire.hub.protocol.message import Message


class HubPlace(Message):
    """A place on the wire (bus/can/faults/places.py); the bits of `line` are counted, "": those of the sender."""

    part: str
    bit: int = 1
    frame_id: int | None = None
    extended: bool | None = None
    line: str = ""


At = HubPlace | int | None  # a place, a time of the hub in ns, or immediately
SeenBy = tuple[str, ...]  # "all", "receivers" or "sender" alone, or lines


class Flip(Message):
    """One bit of matching frames is inverted; also what `inject` provokes."""

    bit: int | str
    frame_id: int | None
    extended: bool | None
    times: int | None
    seen_by: SeenBy


class Noise(Message):
    """Every node reads each bit wrong with this probability."""

    bit_error_rate: float


class Hold(Message):
    """A level is held; `bits` None: until the fault ends."""

    level: str
    at: At
    bits: int | None
    seen_by: SeenBy
    times: int | None


class Play(Message):
    """A sequence of levels, one for each bit."""

    levels: str
    at: At
    seen_by: SeenBy
    times: int | None


class Glitch(Message):
    """A level is forced for a time, shorter or longer than a bit."""

    level: str
    at: At
    from_ns: float
    width_ns: float
    seen_by: SeenBy
    times: int | None


class MoveEdge(Message):
    """An edge of a frame is late, or early."""

    quanta: int
    at: HubPlace
    to: str
    seen_by: SeenBy
    times: int | None


class Short(Message):
    """The wires are shorted; on a LIN bus, the wire to "ground" or to the "supply"."""

    to: str = "ground"


class Disconnect(Message):
    """A line is disconnected from the bus."""

    line: str


class Drift(Message):
    """A line's oscillator runs fast (or, negative, slow)."""

    line: str
    ppm: float


class WrongRate(Message):
    """A line runs at this bit rate, whatever it is set to."""

    line: str
    bit_rate: int


class Cable(Message):
    """The bus's cable has this length; each node adds so much delay."""

    length_m: float
    node_delay_ns: float


class Babble(Message):
    """A node that sends one frame again and again, `gap_ns` after the last one. `record` is its 80 bytes."""

    record: bytes
    gap_ns: int
    times: int | None


class LinFrames(Message):
    """A fault of a LIN bus's headers or responses: `kind` is a method of bus/lin/faults.py, `numbers` its arguments."""

    kind: str
    numbers: tuple[int, ...]
    frame_id: int | None
    times: int | None


Fault = (
    Flip | Noise | Hold | Play | Glitch | MoveEdge | Short | Disconnect | Drift | WrongRate | Cable | Babble | LinFrames
)  # fmt: skip


class GetBus(Message):
    """-> BusFound. Raises NoSuchBoard, or Unsupported for the bus of a real adapter, which a hub cannot disturb."""

    bus: str


class BusFound(Message):
    """`kind` is "CAN" or "LIN"."""

    kind: str


class SetFault(Message):
    """-> Opened. `lasting_ns` None: until it is cancelled; a `persistent` one outlives its client."""

    bus: str
    fault: Fault
    lasting_ns: int | None
    persistent: bool


class GetFault(Message):
    """Fault -> FaultState"""

    handle: int


class AwaitFault(Message):
    """Fault -> FaultState, once it is over or `timeout_ns` have passed."""

    handle: int
    timeout_ns: int | None


class CancelFault(Message):
    """Fault -> FaultState"""

    handle: int


class ListFaults(Message):
    """-> FaultList: the faults of all programs on this bus, including those that are over and not yet closed."""

    bus: str


class ClearFaults(Message):
    """-> Number of faults that ended. `whose` is "mine", "left" (persistent ones) or "all"."""

    bus: str
    whose: str


class FaultInfo(msgspec.Struct, array_like=True, frozen=True):
    """The description and state of a fault, for all programs.

    `text` describes it, `setter` names the program that set it. `struck` counts frames disturbed, levels forced, frames
    babbled or bits inverted by noise; it is 1 for a lasting condition. `times_left` is None without a limit. `over` is
    the reason for its end, "" until then. `set_ns` is in the hub's time.
    """

    number: int
    bus: str
    kind: str
    text: str
    setter: str
    persistent: bool
    set_ns: int
    struck: int
    times_left: int | None
    over: str


class FaultState(Message):
    info: FaultInfo


class FaultList(Message):
    faults: tuple[FaultInfo, ...]
