"""Requests of programs in lockstep time: to take part, to wait until a time, and to read the state.

A thread of a program takes part. Its identity is its program (a word that all connections of one process share) and its
number in the program, on whichever connection it calls.
"""

from __future__ import annotations

from canwire.hub.protocol.message import Message
from canwire.values.frozen import dataclass


class JoinTime(Message):
    """-> Joined, at this thread's turn, once all expected programs have joined. `name` decides its place.

    `process` describes the process for display, if the connection does not: on another machine.
    """

    program: str
    thread: int
    name: str
    process: str = ""


class AwaitTurn(Message):
    """-> Number: the time in ns, at this thread's turn.

    The turn comes at `until_ns`, at a signal to this program, or when a program stirs. A thread that the hub does not
    know yet takes part from now on. An earlier request of the same thread is answered immediately.
    """

    thread: int
    until_ns: int


class LeaveTime(Message):
    """-> None: time no longer waits for this thread; no effect for a thread that takes no part."""

    thread: int


class Stir(Message):
    """-> None: all waiting threads check again, each at its turn at this instant."""


class SetPace(Message):
    """-> None: from now on, this many seconds pass in one second of the clock; 0: as many as possible."""

    factor: float


class GetTime(Message):
    """-> TimeState"""


class Joined(Message):
    """The reply to JoinTime. `hub` identifies the hub, with the same value at all its addresses.

    With descriptors if memory can be shared: this thread's page (turn_page.py), and the event of its turns.
    """

    hub: str
    now_ns: int


@dataclass(frozen=True, slots=True)
class TimedProgram:
    """One thread that takes part. If it `waits`, it does so until `until_ns` (None: until a signal).

    `name` contains the number of the process.
    """

    name: str
    thread: int
    waits: bool
    until_ns: int | None


class TimeState(Message):
    """Lockstep time: the programs in the order of their turns; `standstill` says why time does not pass, or "".

    `pace`: how many seconds pass in one second of the clock, 0: as many as possible.
    """

    now_ns: int
    programs: tuple[TimedProgram, ...]
    standstill: str
    pace: float = 0.0
