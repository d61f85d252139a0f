"""The programs in lockstep at the hub: their connections, their threads, and the wait of each thread."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from canwire.errors import CanwireError, HubLost, LimitReached, WrongState
from canwire.held_time import HeldTime
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.limits import enough
from canwire.hub.owner.lockstep.program import Program, Seat, Turn
from canwire.hub.owner.lockstep.shared_page import SharedPage
from canwire.hub.owner.lockstep.turns import Participant, Turns
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.hub.protocol.time_messages import TimedProgram
from canwire.platform import close_descriptors
from canwire.timeline import NEVER, Timeline

if TYPE_CHECKING:
    from canwire.hub.owner.session import Session


_THREADS = 4096  # of one program that take part


class Looked(Protocol):
    """The hub's world: `kick` checks the transmit queues of a session, and `warn` gets warnings for users."""

    warn: Callable[[str], object]

    def kick(self, session: Session) -> None: ...


class Lockstep:
    """All programs in lockstep. `standstill` is the reason why time does not pass, as a sentence, or ""."""

    def __init__(self, timeline: Timeline, held: HeldTime, turns: Turns, world: Looked) -> None:
        self.turns = turns
        self.standstill = ""
        self.held = held
        self.turn_ns = 0  # when the last turn began
        self._timeline = timeline
        self._world = world
        self._hub = os.urandom(8).hex()
        self._programs: dict[str, Program] = {}
        self._of_session: dict[Session, Program] = {}
        self._pages: dict[Session, SharedPage] = {}
        self._seats: dict[Participant, Seat] = {}
        self._last = 0

    @property
    def occupied(self) -> bool:
        """True if a thread takes part."""
        return bool(self._seats)

    def has(self, session: Session) -> bool:
        """True if this connection belongs to a program that takes part."""
        return session in self._of_session

    # requests

    def join(self, session: Session, request: m.JoinTime) -> Turn:
        """Add this connection to a program that takes part, and the calling thread if it does not take part yet."""
        if session in self._of_session and self._of_session[session].word != request.program:
            raise WrongState(f"{session.name} takes part in the hub's time as another program")
        program = self._programs.get(request.program) or self._new_program(session, request)
        if session not in program.sessions:
            self._of_session[session] = session.halts = program
            program.sessions.append(session)
        seat = program.seats.get(request.thread) or self._seated(program, request.thread, request.name)
        seat.sessions.add(session)
        joined = m.Joined(self._hub, self._timeline.now_ns), self._page(session, request.thread)
        if not seat.participant.waits:
            return _settled(joined)
        return self._ask(seat, joined)

    def wait(self, session: Session, request: m.AwaitTurn) -> Turn:
        """Wait for this thread's next turn; the answer is given then, with the time."""
        program = self._of(session)
        seat = self._at(program, session, request.thread)
        self._sends(program, seat)
        self.turns.wait(seat.participant, min(request.until_ns, NEVER))
        return self._ask(seat, None)

    def leave(self, session: Session, thread: int) -> None:
        program = self._of(session)
        seat = program.seats.get(thread)
        if seat is not None:
            self._sends(program, seat)
            self._stand_up(seat)

    def stir(self) -> None:
        """Give each thread a turn at this instant, to check again."""
        for seat in self._seats.values():
            seat.participant.woken = True

    def state(self) -> m.TimeState:
        programs = tuple(
            TimedProgram(
                f"{one.name} {self._seats[one].program.process}",
                one.thread,
                one.waits,
                None if one.until_ns >= NEVER or not one.waits else one.until_ns,
            )
            for one in self.turns.everybody
        )
        return m.TimeState(self._timeline.now_ns, programs, self.standstill, self.held.factor)

    # for sessions

    def blocked(self, session: Session, answer: Deferred) -> Deferred:
        """An answer that takes time: the thread that called, which is the running one, receives it at its turn."""
        running = self.turns.running
        seat = None if running is None else self._seats[running]
        if (
            answer.settled
            or isinstance(answer, Turn)
            or seat is None
            or seat.program is not self._of_session.get(session)
        ):
            return answer
        self._sends(seat.program, seat)
        self.turns.wait(seat.participant, NEVER, deaf=True)
        later = self._ask(seat, None)
        answer.on_done(lambda outcome: self._unblocked(seat, outcome))
        return later

    def rung(self, session: Session) -> None:
        """A session's doorbell. Frames of the running program are read when it waits, so always in the same order."""
        program, page = self._of(session), self._pages.get(session)
        if page is not None:
            if page.words.called() and page.thread in program.seats:
                program.seats[page.thread].participant.woken = True  # a wait that is about to begin ends, too
            if page.words.asked():
                seat = self._at(program, session, page.thread)
                self._sends(program, seat)
                self.turns.wait(seat.participant, page.words.until_ns())
                if seat.asked is not None:  # interrupted by a signal, and here again
                    seat.asked.settle((m.Number(self._timeline.now_ns), ()))
                seat.asked, seat.answer, seat.page = None, None, page
                return
            if not page.words.stirred():
                return
        if program.runs():
            program.rung = True
        else:
            self._world.kick(session)
            program.halt()

    def gone(self, session: Session) -> None:
        """A connection has ended; a program leaves with its last connection."""
        program = self._of_session.pop(session, None)
        if program is None:
            return
        program.sessions.remove(session)
        page = self._pages.pop(session, None)
        if page is not None:
            page.close()
        for seat in list(program.seats.values()):
            seat.sessions.discard(session)
            if not seat.sessions:
                self._stand_up(seat)
        if not program.sessions:
            del self._programs[program.word]
            self._say(
                f"{program.name} has left at {_seconds(self._timeline.now_ns)}: time continues without it"
            )

    # for the pace

    def give_turn(self) -> None:
        """Let the next thread run whose turn has come, if there is one."""
        one = self.turns.next(self._timeline.now_ns)
        if one is None:
            return
        self.turn_ns = self._timeline.now_ns
        seat = self._seats[one]
        asked, answer = seat.asked, seat.answer
        if seat.page is not None:
            seat.page.give(self._timeline.now_ns)
        seat.asked = seat.answer = seat.page = None
        if asked is not None:
            asked.settle(answer or (m.Number(self._timeline.now_ns), ()))

    def report_standstill(self, repeats: bool) -> None:
        """Report why no time has passed for too long. `repeats`: threads run repeatedly at one instant."""
        self.standstill = f"time stopped at {_seconds(self._timeline.now_ns)}: {self._why(repeats)}"
        self._say(self.standstill)

    def _why(self, repeats: bool) -> str:
        running = self.turns.running
        if self.turns.missing:
            return f"{self.turns.missing} did not join yet"
        if running is None:
            return "everybody waits without a timeout, and nothing comes"
        who = f"{running.name} {self._seats[running].program.process}, thread {running.thread},"
        if repeats:
            return f"{who} and maybe others wait again and again for no time at all"
        return (
            f"{who} computes, asks again and again without waiting (as recv(0) does), or waits for something that the "
            f"hub does not know of (hub.sleep, hub.away)"
        )

    def _new_program(self, session: Session, request: m.JoinTime) -> Program:
        self._last += 1
        program = self._programs[request.program] = Program(request.program, self._last, self._timeline)
        program.process = (
            f"({request.process})" if request.process else session.name[session.name.rindex("(") :]
        )
        program.name = f"{request.name} {program.process}"
        if any(one.name == request.name for one in self.turns.everybody):
            self._say(
                f"two programs are called {request.name}: the one that joined first goes first, which may be different "
                f"the next time; CANWIRE_NAME gives each its own name"
            )
        return program

    def _page(self, session: Session, thread: int) -> tuple[int, ...]:
        """Descriptors of a page for the thread that asks, where it can have one."""
        if session in self._pages or not session.shares_memory:
            return ()
        with enough("a place in the hub's time"):
            page = SharedPage(thread)
        self._pages[session] = page
        return page.hand_over()

    def _seated(self, program: Program, thread: int, name: str) -> Seat:
        if len(program.seats) >= _THREADS:
            raise LimitReached(
                f"{program.name}: {_THREADS} of its threads take part in the hub's time already"
            )
        participant = self.turns.add(name, program.number, thread)
        seat = program.seats[thread] = self._seats[participant] = Seat(program, participant)
        return seat

    def _at(self, program: Program, session: Session, thread: int) -> Seat:
        """The seat of a thread; a thread without one gets a new seat."""
        seat = program.seats.get(thread)
        if seat is None:
            seat = self._seated(program, thread, program.seat_name() or session.name)
            seat.participant.woken = False
        seat.sessions.add(session)
        return seat

    def _stand_up(self, seat: Seat) -> None:
        self.turns.remove(seat.participant)
        del self._seats[seat.participant]
        del seat.program.seats[seat.participant.thread]
        if isinstance(seat.answer, tuple):
            close_descriptors(*seat.answer[1])
        if seat.asked is not None:
            seat.asked.settle(HubLost("this program takes part in the hub's time no longer"))

    def _ask(self, seat: Seat, answer: Answer | None) -> Turn:
        if seat.asked is not None:  # interrupted by a signal, and here again
            seat.asked.settle((m.Number(self._timeline.now_ns), ()))
        seat.asked, seat.answer, seat.page = Turn(), answer, None
        return seat.asked

    def _unblocked(self, seat: Seat, outcome: Answer | CanwireError) -> None:
        seat.answer = outcome
        self.turns.wake(seat.participant)
        self._timeline.halt()

    def _sends(self, program: Program, seat: Seat) -> None:
        """Take note of what the program put into its queues; others of its threads may wait for the effect."""
        for session in program.sessions:
            page = self._pages.get(session)
            if page is not None:
                program.rung |= page.words.stirred()
            elif session.doorbell is not None:
                program.rung |= session.doorbell.take()
            self._world.kick(session)
        if program.rung:
            program.rung = False
            for other in program.seats.values():
                if other is not seat:
                    other.participant.woken = True

    def _of(self, session: Session) -> Program:
        if session not in self._of_session:
            raise CanwireError(f"{session.name} takes no part in the hub's time: connect(timed=True)")
        return self._of_session[session]

    def _say(self, text: str) -> None:
        self._world.warn(text)


def _settled(answer: Answer) -> Turn:
    found = Turn()
    found.settle(answer)
    return found


def _seconds(time_ns: int) -> str:
    return f"{time_ns / 1e9:.9f} s"
