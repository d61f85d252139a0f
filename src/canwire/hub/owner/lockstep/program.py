"""A process that keeps one time with others, and its threads, as the hub knows them."""

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
    """An answer that comes when somebody may run."""


class Seat:
    """A thread that takes part. `asked` waits for its turn, which then gets `answer`, or the time; or `page` does."""

    def __init__(self, program: Program, participant: Participant) -> None:
        self.program = program
        self.participant = participant
        self.asked: Turn | None = None
        self.answer: Answer | CanwireError | None = None
        self.page: SharedPage | None = None
        self.sessions: set[Session] = set()  # through which it has asked: with the last of them it goes


class Program:
    """A process: its connections, and those of its threads that take part. `halt` is called by each of its signals."""

    def __init__(self, word: str, number: int, timeline: Timeline) -> None:
        self.word = word
        self.number = number
        self.name = self.process = ""
        self.sessions: list[Session] = []
        self.seats: dict[int, Seat] = {}
        self.rung = False  # a doorbell, since one of its threads last waited
        self._timeline = timeline

    def runs(self) -> bool:
        """One of its threads does."""
        for seat in self.seats.values():
            if not seat.participant.waits:
                return True
        return False

    def seat_name(self) -> str:
        """What its threads are called in the order of turns; "" where none takes part."""
        return next((seat.participant.name for seat in self.seats.values()), "")

    def halt(self) -> None:
        """Something was signalled: its threads look again at this instant, and no more time passes before that."""
        for seat in self.seats.values():
            seat.participant.woken = True
        self._timeline.halt()
