"""Faults on a hub's buses: what can go wrong, and what is asked and told of it.

A fault is a value; `Fault` are all there are, those of docs/faults.md. Lines are named as everywhere: "HW000001:1".
"""

from __future__ import annotations

import msgspec

from canwire.hub.protocol.message import Message


class HubPlace(Message):
    """A place on the wire, bus/can/faults/places.py's; `line` is whose bits count, "": the sender's."""

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
    """Everybody reads bits wrong with this probability."""

    bit_error_rate: float


class Hold(Message):
    """A level is held; `bits` None: as long as the fault is there."""

    level: str
    at: At
    bits: int | None
    seen_by: SeenBy
    times: int | None


class Play(Message):
    """One level a bit."""

    levels: str
    at: At
    seen_by: SeenBy
    times: int | None


class Glitch(Message):
    """A level for less than a bit, or more."""

    level: str
    at: At
    from_ns: float
    width_ns: float
    seen_by: SeenBy
    times: int | None


class MoveEdge(Message):
    """An edge of a frame comes late, or early."""

    quanta: int
    at: HubPlace
    to: str
    seen_by: SeenBy
    times: int | None


class Short(Message):
    """The wires touch, or a LIN bus's wire touches "ground" or the "supply"."""

    to: str = "ground"


class Disconnect(Message):
    """A line's plug is pulled."""

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
    """Headers or responses of a LIN bus: `kind` is the method of bus/lin/faults.py, `numbers` its own arguments."""

    kind: str
    numbers: tuple[int, ...]
    frame_id: int | None
    times: int | None


Fault = (
    Flip | Noise | Hold | Play | Glitch | MoveEdge | Short | Disconnect | Drift | WrongRate | Cable | Babble | LinFrames
)  # fmt: skip


class GetBus(Message):
    """-> BusFound. Raises NoSuchBoard, or Unsupported for a real adapter's bus, which no hub can disturb."""

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
    """-> FaultList: all programs' faults there, those that are over and not given back yet included."""

    bus: str


class ClearFaults(Message):
    """-> Number of faults that ended. `whose` is "mine", "left" (persistent ones) or "all"."""

    bus: str
    whose: str


class FaultInfo(msgspec.Struct, array_like=True, frozen=True):
    """A fault as everybody sees it.

    `text` says what it is, `setter` who set it. `struck` counts frames disturbed, levels forced, frames babbled, bits
    inverted by noise, or 1 for what simply is so. `times_left` is None without end. `over` says why it ended, ""
    while it has not. `set_ns` is the hub's time.
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
