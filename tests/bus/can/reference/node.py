"""One node between frames: idle, intermission, suspend, integration, bus-off; and what it tells.

Source: ISO 11898-1:2015 8.2.6, 10.4.6, 12.1.4; reference/can-protocol.md sections 5 and 7.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from tests.bus.can.reference.confinement import BUS_OFF, PASSIVE, STOPPED, Confinement
from tests.bus.can.reference.flags import FlagMachine
from tests.bus.can.reference.frames import (
    DOMINANT,
    NEXT_BIT,
    RECESSIVE,
    Bits,
    ExceptionState,
    Heard,
    Overload,
    Wrong,
)
from tests.bus.can.reference_bits import classic, flexible


class Off(Exception):
    """The node is bus-off by now."""


class Order(NamedTuple):
    """A frame that somebody wants sent."""

    frame: Heard
    single_shot: bool


class Node(FlagMachine):
    """A controller, its queue, and `log`: all that it ever tells, with times in quanta.

    `where` and `pending_rate` are for its clock; `sof_edge` is told by it: the present bit began with an edge, or has
    had one.
    """

    def __init__(self, *, knows_fd: bool, listen_only: bool, tec: int = 0, rec: int = 0) -> None:
        self.knows_fd = knows_fd
        self.listen_only = listen_only
        self.confinement = Confinement(tec, rec)
        self.queue: list[Order] = []
        self.log: list[tuple[Any, ...]] = []
        self.heard: list[tuple[int, Heard]] = []
        self.now = 0
        self.running = True
        self.where = ""
        self.pending_rate = False
        self.sof_edge = False
        self.level_before = RECESSIVE
        self.recessive = 0
        self.sof_at = 0
        self.just_free = False
        self.attempt: Order | None = None
        self.after_this_bit: list[Callable[[], None]] = []

    # what its frames tell

    def place(self, name: str) -> None:
        self.where = name

    def data_rate(self, on: bool) -> None:
        self.pending_rate = on

    def settle(self) -> None:
        happenings, self.after_this_bit = self.after_this_bit, []
        for happen in happenings:
            happen()

    def lose(self, bit: int) -> None:
        self.log.append(("lost", self.sof_at, bit, self.state(), self.confinement.tec, self.confinement.rec))
        if self.attempt is not None and self.attempt.single_shot:
            self.queue.remove(self.attempt)
        self.attempt = None

    def reception_is_well(self) -> None:
        self.count(self.confinement.received)

    def frame_is_over(self, heard: Heard) -> None:
        self.after_this_bit.append(
            self.sent if self.transmitting else lambda: self.heard.append((self.now, heard))
        )

    def sent(self) -> None:
        assert self.attempt is not None
        self.count(self.confinement.transmitted)
        self.tell("sent")
        self.queue.remove(self.attempt)
        self.attempt = None

    # counters and events

    def state(self) -> int:
        return self.confinement.state() if self.running else STOPPED

    def passive(self) -> bool:
        return self.listen_only or self.confinement.state() >= PASSIVE

    def tell(self, what: str, *more: Any) -> None:
        self.log.append((what, self.now, *more, self.state(), self.confinement.tec, self.confinement.rec))

    def count(self, rule: Callable[[], None], told: tuple[Any, ...] = ()) -> None:
        """Apply a rule and tell of the error (if it is one) and of the state that it led to."""
        before = self.confinement.state()
        if not self.listen_only:
            rule()
        if told:
            self.tell(*told)
        if self.confinement.state() != before:
            self.tell("state")
        if told and self.transmitting and self.attempt is not None and self.attempt.single_shot:
            self.queue.remove(self.attempt)
        if self.confinement.state() == BUS_OFF:
            self.attempt = None
            raise Off

    # life

    def life(self, groups: int) -> Bits:
        """From a start on; `groups` of 11 recessive bits come before anything else."""
        self.transmitting = False
        step = self.integrate(groups) if groups else self.idle()
        while True:
            try:
                yield from step
                step = self.next_step()
            except Wrong as wrong:
                step = self.error_frame(wrong)
            except Overload:
                step = self.overload_frame()
            except ExceptionState:
                self.transmitting = False
                step = self.integrate(1)
            except Off:
                self.transmitting = False
                step = self.off()

    def next_step(self) -> Bits:
        """What follows a part that went well: told by `follows`."""
        return {"frame": self.frame, "intermission": self.intermission, "idle": self.idle}[self.follows]()

    def frame(self) -> Bits:
        self.follows = "intermission"
        yield from super().frame()

    def off(self) -> Bits:
        """Neither driving nor caring."""
        self.place("off")
        while True:
            yield from self.bit(RECESSIVE)
            self.place("off")

    def integrate(self, groups: int) -> Bits:
        """Idle is what 11 recessive bits are; an edge begins their count anew (told by the clock)."""
        self.place("integrating")
        for _ in range(groups):
            self.recessive = 0
            while self.recessive < 11:
                level = yield from self.bit(RECESSIVE)
                self.recessive = self.recessive + 1 if level == RECESSIVE else 0
        self.after_this_bit.append(self.join)
        self.follows = "idle"

    def join(self) -> None:
        if self.confinement.state() == BUS_OFF:
            self.confinement = Confinement()
            self.tell("state")

    # between frames

    def idle(self) -> Bits:
        """Until an SOF, somebody's or its own."""
        while True:
            yield NEXT_BIT
            self.settle()
            may_start = self.just_free if self.sof_edge else self.level_before == RECESSIVE
            self.just_free = False
            self.place("idle")
            if self.queue and may_start and not self.listen_only:
                self.begin_sending()
                if (yield DOMINANT) == RECESSIVE:
                    self.index = 1
                    raise Wrong("BIT")
                break
            if (yield RECESSIVE) == DOMINANT:
                self.transmitting = False
                break
        self.begin()
        self.follows = "frame"

    def begin_sending(self) -> None:
        self.place("frame")
        self.index = 0
        self.sof_at = self.now
        self.transmitting = True
        self.attempt = self.queue[0]
        frame = self.attempt.frame
        self.arbitration_bits = 32 if frame.extended else 12
        common = {"extended": frame.extended, "dlc": frame.dlc, "data": frame.data}
        if frame.fd:
            passive = self.confinement.state() >= PASSIVE
            sent = flexible(frame.id, switch=frame.bit_rate_switch, passive=passive, **common)
        else:
            sent = classic(frame.id, remote=frame.remote, **common)
        self.levels, self.arbitration = sent.bits, sent.arbitration

    def intermission(self) -> Bits:
        for bit in (1, 2, 3):
            yield NEXT_BIT
            self.settle()
            self.place(f"intermission {bit}")
            level = yield RECESSIVE
            if level == DOMINANT:
                if bit < 3:
                    raise Overload
                self.join_sof()
                return
        suspends = self.transmitting and self.passive()
        self.transmitting = False
        self.just_free = not suspends
        self.follows = "idle"
        if suspends:
            yield from self.suspend()

    def join_sof(self) -> None:
        """The third bit is dominant: an SOF, and for a node with a frame to send its own."""
        suspends = self.transmitting and self.passive()
        self.transmitting = False
        if self.queue and not suspends and not self.listen_only:
            self.begin_sending()
        self.begin()
        self.follows = "frame"

    def suspend(self) -> Bits:
        for _ in range(8):
            yield NEXT_BIT
            self.settle()
            self.place("suspend")
            if (yield RECESSIVE) == DOMINANT:
                self.begin()
                self.follows = "frame"
                return
