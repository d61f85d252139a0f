"""Requests of programs in lockstep time: to take part, to wait until a time, and to read the state.

A thread of a program takes part. It is known by its program (a word that all connections of one process share) and its
number in there, whichever connection it asks through.
"""

from __future__ import annotations

from canwire.hub.protocol.message import Message
from canwire.values.frozen import dataclass


class JoinTime(Message):
    """-> Joined, at this thread's turn: no sooner than everybody is there who is expected. `name` says its place.

    `process` says for people which one it is, where the connection does not: on another machine.
    """

    program: str
    thread: int
    name: str
    process: str = ""


class AwaitTurn(Message):
    """-> Number: the time in ns, at this thread's turn.

    That comes at `until_ns`, or once something is signalled to this program, or a program stirs. A thread that the hub
    does not know yet takes part from now on. An earlier one of the same thread is answered immediately.
    """

    thread: int
    until_ns: int


class LeaveTime(Message):
    """-> None: time does not wait for this thread any more; for one that takes no part, nothing happens."""

    thread: int


class Stir(Message):
    """-> None: everybody who waits looks again, each in its turn at this very instant."""


class SetPace(Message):
    """-> None: from now on so many seconds pass in one of the wall clock; 0: as many as can."""

    factor: float


class GetTime(Message):
    """-> TimeState"""


class Joined(Message):
    """`hub` tells hubs apart, whatever address they have.

    With descriptors where memory can be shared: this thread's page (turn_page.py), and the event of its turns.
    """

    hub: str
    now_ns: int


@dataclass(frozen=True, slots=True)
class TimedProgram:
    """One thread that takes part: `until_ns` is what it waits for (None: for a signal alone), where it `waits`.

    `name` has the process's number in it.
    """

    name: str
    thread: int
    waits: bool
    until_ns: int | None


class TimeState(Message):
    """One time for many programs: in the order of their turns; `standstill` says why time does not pass, or "".

    `pace`: how many seconds pass in one of the wall clock, 0: as many as can.
    """

    now_ns: int
    programs: tuple[TimedProgram, ...]
    standstill: str
    pace: float = 0.0
