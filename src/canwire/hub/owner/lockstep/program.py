"""A process in lockstep with others, and its threads, at the hub."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.errors import CanwireError
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.lockstep.shared_page import SharedPage
from canwire.hub.owner.lockstep.turns import Participant
from canwire.hub.protocol.link import Answer
from canwire.timeline import Timeline

if TYPE_CHECKING:
    from canwire.hub.owner.session import Session


class Turn(Deferred):
    """An answer that is given when its thread may run."""


class Seat:
    """A thread that takes part. At its turn, `asked` is settled with `answer` or the time, or `page` gets the time."""

    def __init__(self, program: Program, participant: Participant) -> None:
        self.program = program
        self.participant = participant
        self.asked: Turn | None = None
        self.answer: Answer | CanwireError | None = None
        self.page: SharedPage | None = None
        self.sessions: set[Session] = set()  # through which it has asked: with the last of them it goes


class Program:
    """A process: its connections, and its threads that take part. Each signal to it calls `halt`."""

    def __init__(self, word: str, number: int, timeline: Timeline) -> None:
        self.word = word
        self.number = number
        self.name = self.process = ""
        self.sessions: list[Session] = []
        self.seats: dict[int, Seat] = {}
        self.rung = False  # a doorbell, since one of its threads last waited
        self._timeline = timeline

    def runs(self) -> bool:
        """True if one of its threads runs."""
        for seat in self.seats.values():
            if not seat.participant.waits:
                return True
        return False

    def seat_name(self) -> str:
        """The name of its threads in the order of turns; "" if none takes part."""
        return next((seat.participant.name for seat in self.seats.values()), "")

    def halt(self) -> None:
        """A signal has arrived: the threads check again at this instant, before more time passes."""
        for seat in self.seats.values():
            seat.participant.woken = True
        self._timeline.halt()
