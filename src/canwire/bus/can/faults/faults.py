"""Scripted disturbances: bits that some nodes read wrong, noise, a short, a disconnected node.

`Faults` decides which bits are disturbed and for which nodes; bus.py calls it before it skips over a frame, and
bit_level.py at every bit that the sender drives. The bus does what follows (error frames, counters, repetition).
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass

from canwire.bus.can.bit_layout import BitLayout
from canwire.bus.can.bit_level import EVERYBODY, ONE_NODE, RECEIVERS, SENDER
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.aim import INJECTED, PLACES, place
from canwire.bus.can.faults.forcing import Forcing
from canwire.bus.can.node import CLASSIC_ONLY, Mailbox, Node
from canwire.bus.scripted import Scripted
from canwire.errors import BadValue
from canwire.values.checks import instance
from canwire.values.frame import Frame, frame_of_record
from canwire.values.text import format_frame

_LAST_CLASSIC_BIT, _LAST_FD_BIT = 156, 732
"""Of the longest frames: 118 or 553 bits from SOF that may be stuffed, a stuff bit after each four, the end."""
SEEN_BY = {"all": EVERYBODY, "receivers": RECEIVERS, "sender": SENDER}


@dataclass(slots=True, eq=False)
class Fault(Scripted):
    """One bit inverted on purpose; `times` counts frames.

    `frame_id` and `extended` choose frames (None: any); `bit` is an index from SOF, stuff bits included, or a name
    that `place` resolves in each frame.
    """

    frame_id: int | None
    extended: bool | None
    bit: int | str
    seen_by: int
    victim: Node | None

    def matches(self, frame: Frame) -> bool:
        if self.times == 0:
            return False
        wanted_id = self.frame_id is None or self.frame_id == frame.id
        return wanted_id and (self.extended is None or self.extended == frame.extended)


@dataclass(slots=True, eq=False)
class Noise(Scripted):
    """Bits that are read wrong at random; it counts those that it inverted."""

    rate: float


class Faults(Forcing):
    """All faults of one bus, scripted or random; forcing.py has the forced levels.

    `inverts`, if set, is called before noise inverts a bit, with a function that describes it; False prevents that.
    """

    def __init__(self, bus: CanBus, seed: int) -> None:
        super().__init__(bus)
        self._random = random.Random(seed)
        self._faults: list[Fault] = []
        self._noises: list[Noise] = []
        self._noise = 0.0
        self._active: tuple[Fault, int] | None = None
        self.inverts: Callable[[Callable[[], str]], bool] | None = None

    def __repr__(self) -> str:
        scripted = sum(fault.times != 0 for fault in self._faults)
        return f"<faults of a CAN bus: {scripted} scripted, bit error rate {self._noise:g}>"

    def flip(
        self,
        *,
        bit: int | str,
        frame_id: int | None = None,
        extended: bool | None = None,
        times: int | None = 1,
        seen_by: str | Node = "all",
    ) -> Fault:
        """Invert one bit of matching frames for `seen_by`: "all", "receivers", "sender" or one node.

        `bit` counts from SOF (0), stuff bits included, or names a place: "ack", "crc delimiter", "ack delimiter",
        "eof", "dlc", "data", or an error to provoke (see `inject`). A frame that has no such bit passes undisturbed,
        and the fault waits for the next one.
        """
        self._check(bit, frame_id, extended, times, seen_by)
        victim = None if isinstance(seen_by, str) else seen_by
        viewers = SEEN_BY[seen_by] if isinstance(seen_by, str) else ONE_NODE
        fault = Fault(frame_id, extended, bit, viewers, victim, times=times, remove=self._forget)
        self._faults.append(fault)
        self._choose_frames()
        return fault

    def _check(
        self, bit: object, frame_id: int | None, extended: bool | None, times: int | None, seen_by: object
    ) -> None:
        """Raise BadValue for arguments that no fault can have."""
        if isinstance(bit, str):
            if bit not in PLACES and bit not in INJECTED:
                raise BadValue(f"bit {bit!r}: a number from 0, or one of {', '.join([*PLACES, *INJECTED])}")
        elif not isinstance(bit, int) or bit < 0:
            raise BadValue(f"bit {bit!r}: bits count from 0 (SOF), or have a name")
        elif bit > (last := self._last_bit()):
            raise BadValue(
                f"bit {bit}: the longest frame of this bus ends with bit {last}, stuff bits included"
            )
        if times is not None and times < 1:
            raise BadValue(f"times {times}: at least 1, or None for every frame")
        if not isinstance(seen_by, Node) and seen_by not in SEEN_BY:
            raise BadValue(f"seen_by {seen_by!r}: a node, or one of {', '.join(SEEN_BY)}")
        if frame_id is not None and not 0 <= frame_id <= (0x7FF if extended is False else 0x1FFFFFFF):
            raise BadValue(
                f"frame_id {frame_id:#x}: an identifier of 11 bits, or with extended not False of 29"
            )

    def _last_bit(self) -> int:
        """The index of the last bit of the longest frame that a node of this bus can send."""
        fd = any(node.fd != CLASSIC_ONLY for node in self._bus.nodes)
        return _LAST_FD_BIT if fd or not self._bus.nodes else _LAST_CLASSIC_BIT

    def inject(
        self, error: str, *, frame_id: int | None = None, extended: bool | None = None, times: int | None = 1
    ) -> Fault:
        """Provoke one kind of error in matching frames: "stuff", "form", "crc", "bit" or "ack".

        The receivers see a stuff, form or CRC error, the sender a bit or acknowledge error; all nodes see the
        error frame.
        """
        if error not in INJECTED:
            raise BadValue(f"error {error!r}: one of {', '.join(INJECTED)}")
        seen_by = "sender" if error in ("bit", "ack") else "receivers"
        return self.flip(bit=error, frame_id=frame_id, extended=extended, times=times, seen_by=seen_by)

    def noise(self, bit_error_rate: float) -> Scripted:
        """From now on, all nodes read each bit of a frame wrong with this probability (0 ends it)."""
        self._check_rate(bit_error_rate)
        for noise in [*self._noises]:
            noise.cancel()
        return self.add_noise(bit_error_rate)

    def add_noise(self, bit_error_rate: float) -> Scripted:
        """Add noise to the noise that already exists."""
        self._check_rate(bit_error_rate)
        noise = Noise(bit_error_rate, times=None if bit_error_rate else 0, remove=self._silence)
        with self._touch():
            if bit_error_rate:
                self._noises.append(noise)
            self._mix_noises()
        return noise

    def _check_rate(self, bit_error_rate: float) -> None:
        instance("bit_error_rate", bit_error_rate, int, float)
        if not 0 <= bit_error_rate < 1:
            raise BadValue(f"bit_error_rate {bit_error_rate}: from 0 up to, not including, 1")

    def _silence(self, noise: Noise) -> None:
        with self._touch():
            self._noises = [each for each in self._noises if each is not noise]
            self._mix_noises()

    def _mix_noises(self) -> None:
        self._bus.interrupt()  # what has passed of a frame has passed with the noise before
        self._noise = 1.0 - math.prod(1.0 - noise.rate for noise in self._noises)
        self._bus.noise_left = self._next_noise()
        self._ask_bits()

    def _strike_by_noise(self, node: Node, index: int) -> bool:
        """Let one of the noises invert a bit, if `inverts` permits it; True if it did."""
        rates = [noise.rate for noise in self._noises]
        self._bus.noise_left = self._next_noise()
        if self.inverts is not None and not self.inverts(lambda: self._bit(node, index)):
            return False
        noises = self._noises if len(rates) < 2 else self._random.choices(self._noises, rates)
        noises[0].strike()
        return True

    def _bit(self, node: Node, index: int) -> str:
        box = node.contending
        of = "a frame" if box is None else format_frame(frame_at_box(box))
        return f"{self._bus.name}: bit {index} of {of} from {node.name} at {self._bus.timeline.now_ns} ns"

    def short(self) -> None:
        """Short the wires: the bus is dominant until `clear_short`."""
        self._bus.short(True)

    def clear_short(self) -> None:
        self._bus.short(False)

    def clear(self) -> None:
        """Remove all scripted faults, noise and the short; disconnected nodes and levels forced at a time remain."""
        for fault in [*self._faults, *self._noises]:
            fault.cancel()
        self.forget_placed()
        if self._bus.bits.shorted:
            self.clear_short()

    def _next_noise(self) -> int:
        """How many good bits come before the next bad one: a geometric distribution."""
        if self._noise == 0.0:
            return -1
        return int(math.log(1.0 - self._random.random()) / math.log1p(-self._noise))

    def _choose_frames(self) -> None:
        self._bus.scripted = self._scripted if self._faults or self._placed else None
        self._ask_bits()

    def _ask_bits(self) -> None:
        """Have the bit level call `_disturb` for each bit while one may be disturbed."""
        bits = self._bus.bits
        if self._faults or self._bus.noise_left >= 0:
            bits.disturb, bits.spare = self._disturb, self._spare
        else:
            bits.disturb = bits.spare = None
            self._active = None

    def _scripted(self, box: Mailbox) -> bool:
        frame = frame_at_box(box)
        return any(fault.matches(frame) for fault in self._faults) or self._awaits(box)

    def _spare(self, node: Node, index: int, most: int) -> int:
        """How many of the sender's next bits, at most `most`, no node will see inverted; they count as passed."""
        bus = self._bus
        if 0 <= bus.noise_left < most:
            most = bus.noise_left
        if most == 0:
            return 0
        if bus.bits.undisturbed or not self._faults:
            self._active = None
        else:
            if self._begins(node, index):
                self._choose(node)
            if self._active is not None and self._active[1] >= index:
                most = min(most, self._active[1] - index)
        if bus.noise_left >= 0:
            bus.noise_left -= most
        return most

    def _begins(self, node: Node, index: int) -> bool:
        """Whether this is the first bit of a frame to be checked; a node that joins an SOF begins at bit 1."""
        bits = self._bus.bits
        return node is not bits.sender_seen or index <= bits.index_seen

    def _disturb(self, node: Node, index: int) -> int:
        """Which nodes see the bit inverted that the sender now drives, or -1."""
        bus = self._bus
        if bus.noise_left >= 0:
            bus.noise_left -= 1
            if bus.noise_left < 0 and self._strike_by_noise(node, index):
                return EVERYBODY
        if bus.bits.undisturbed:
            self._active = None
            return -1
        if not self._faults:
            self._active = None  # what a fault that comes in mid-frame must not find
            return -1
        if self._begins(node, index):
            self._choose(node)
        if self._active is None or self._active[1] != index:
            return -1
        fault = self._active[0]
        fault.strike()
        if not any(other.times != 0 for other in self._faults):
            self._faults.clear()
            self._choose_frames()
        bus.bits.victim = fault.victim
        return fault.seen_by

    def _forget(self, fault: Fault) -> None:
        """Remove a cancelled fault, perhaps in the middle of a frame that it was to disturb."""
        with self._touch():
            self._faults = [each for each in self._faults if each is not fault]
            if self._active is not None and self._active[0] is fault:
                self._active = None
            self._choose_frames()

    def _choose(self, node: Node) -> None:
        """Find the first fault for the frame that begins now, and the bit that it inverts."""
        self._active = None
        if node.contending is None:
            return
        frame = frame_at_box(node.contending)
        for fault in self._faults:
            if fault.matches(frame):
                layout = BitLayout(frame, fd_mode=node.fd, error_passive=node.passive)
                at = fault.bit if isinstance(fault.bit, int) else place(layout, fault.bit)
                if 0 <= at < len(layout.levels):
                    self._active = (fault, at)
                    return


def frame_at_box(box: Mailbox) -> Frame:
    """The frame in a mailbox."""
    return frame_of_record(box.block)
