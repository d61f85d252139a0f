"""Hands what arrives from the bus to each task block: frames that pass its filters, events as special conditions.

Source: INduCAN104 manual, "Notification", "CAN channels".
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from canwire import BusEvent, ErrorState, EventKind, Frame, InfoCode
from canwire.acan.constants import Condition, Interrupt
from canwire.acan.identifiers import acan_word
from canwire.acan.line import Arrival
from canwire.acan.task_block import Occurrence

if TYPE_CHECKING:
    from canwire.acan.task_block import TaskBlock

EVERY_INTERRUPT = 0xFF
_TEC_IN_BUS_OFF = 127  # what the chip's TXERR shows then; source: SJA1000 data sheet 6.4.9


class Dispatch:
    """The registered blocks in the order of their registration. `reply(frame, loop_back)` sends a channel's answer.

    An answer is looped back, so that it can address a channel of the same machine, unless it would make a channel
    of this driver send: otherwise a channel could answer itself without end.
    """

    def __init__(
        self,
        state: int,
        reply: Callable[[Frame, bool], None],
        interrupts: Callable[[], int] = lambda: EVERY_INTERRUPT,
    ) -> None:
        """`interrupts` returns the IER for ACAN programs; it is called again after each change of the line."""
        self.blocks: list[TaskBlock] = []
        self._state = _known(state)
        self._tec = self._rec = 0
        self._reply = reply
        self._interrupts = interrupts
        self._enabled: int | None = None
        self._own_stops = 0

    def take(self, arrival: Arrival) -> list[TaskBlock]:
        """Hand one frame or event to the blocks; returns the blocks whose applications must be notified now."""
        if arrival.lost_before:
            self.raise_condition(Condition.NOBUFF)
        if isinstance(arrival.what, BusEvent):
            self._event(arrival.what)
        else:
            self._frame(arrival.what)
        return [block for block in self.blocks if block.take_notification()]

    def raise_condition(self, conditions: Condition, alc: int | None = None, ecc: int | None = None) -> None:
        """Report the conditions to each block, with the newest error counters."""
        what = Occurrence(int(conditions), self._tec, self._rec, alc, ecc)
        for block in self.blocks:
            block.occurred(what)

    @contextmanager
    def own_stop(self) -> Iterator[None]:
        """While entered, this program takes the controller off the bus, and its blocks get no BUSOFF for that."""
        self._own_stops += 1
        try:
            yield
        except BaseException:
            self._own_stops -= 1
            raise

    def _frame(self, frame: Frame) -> None:
        word = acan_word(frame.id, frame.extended)
        replies = [reply for block in self.blocks for reply in block.offer(frame, word)]
        for reply in replies:
            asked = acan_word(reply.id, reply.extended)
            self._reply(reply, not any(block.answers(asked) for block in self.blocks))

    def _event(self, event: BusEvent) -> None:
        if event.kind is EventKind.CHANGED:
            self._enabled = None
            self._changed(event.code)
            return
        self._rec = event.rec
        self._tec = _TEC_IN_BUS_OFF if event.state is ErrorState.BUS_OFF else event.tec
        if event.kind is EventKind.ERROR and self._interrupted_by(Interrupt.BEIE):
            self.raise_condition(Condition.BUSERR, ecc=event.code)
        elif event.kind is EventKind.ARBITRATION_LOST and self._interrupted_by(Interrupt.ALIE):
            self.raise_condition(Condition.ARBLOST, alc=event.bit)
        elif event.kind is EventKind.OVERRUN and self._interrupted_by(Interrupt.DOIE):
            self.raise_condition(Condition.OVERRUN)
        before, self._state = self._state, _known(event.state)
        risen = _risen(before, self._state)
        if risen:
            risen &= _told_by(self._enabled_interrupts())
        if risen:
            self.raise_condition(risen)

    def _changed(self, code: int) -> None:
        """Another program took the controller off the bus: the manual calls this Bus Off, too."""
        if code == InfoCode.STOPPED and self._own_stops:
            self._own_stops -= 1
        elif code in (InfoCode.STOPPED, InfoCode.RESET):
            self.raise_condition(Condition.BUSOFF)

    def _interrupted_by(self, kind: Interrupt) -> bool:
        return bool(self._enabled_interrupts() & kind)

    def _enabled_interrupts(self) -> int:
        if self._enabled is None:
            self._enabled = self._interrupts()
        return self._enabled


def _known(state: int) -> ErrorState:
    """The state from which the next events count: a stopped controller starts again in error active."""
    return ErrorState.ERROR_ACTIVE if state == ErrorState.STOPPED else ErrorState(state)


def _told_by(interrupts: int) -> Condition:
    """The conditions that a controller with this IER reports: without EIE neither the warning limit nor bus-off."""
    found = Condition(0)
    if interrupts & Interrupt.EIE:
        found |= Condition.ERRLIM | Condition.BUSOFF
    if interrupts & Interrupt.EPIE:
        found |= Condition.ERRPAS
    return found


def _risen(before: ErrorState, now: ErrorState) -> Condition:
    """Which limits the controller passed."""
    found = Condition(0)
    if before < ErrorState.ERROR_WARNING <= now:
        found |= Condition.ERRLIM
    if before < now == ErrorState.ERROR_PASSIVE:
        found |= Condition.ERRPAS
    if before < now == ErrorState.BUS_OFF:
        found |= Condition.BUSOFF
    return found
