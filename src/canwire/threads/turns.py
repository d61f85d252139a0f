"""Turns of the threads of one program that share a hub's time.

A thread that waits hands its turn to the next thread that can continue, in the order of their starts. If no thread can
continue, the thread that waits lets time pass, up to the first timeout or until something is signalled.
"""

from __future__ import annotations

import math
import threading
from bisect import bisect_right
from collections.abc import Callable
from operator import attrgetter

from canwire.errors import HubError, HubLost
from canwire.threads.keeper import NEVER, ByTheClock, Keeper
from canwire.threads.member import MEMBERS, Member, never
from canwire.threads.originals import allocate_lock
from canwire.threads.polling import Polling
from canwire.threads.standstill import describe, wait_for_descriptors

SILENCE_NS = 3_600_000_000_000  # longest common wait without a timeout: the clocks of boards never stop

_number_of = attrgetter("number")


class Turns(Polling):
    """The threads that take part. `founder` made it, and gets the error if no event can ever come."""

    def __init__(self, keeper: Keeper) -> None:
        self.keeper = keeper
        self.over = False
        self.when_over: Callable[[], object] = never
        self.turns = 0  # handed on so far
        self.running: Member | None = None
        self._members: list[Member] = []
        self._numbers = 0
        self._now_ns: int | None = None
        self._last_ns = 0
        self._quiet_since_ns = 0
        self._told = False
        self._away = 0  # threads that wait outside
        self._lock = allocate_lock()  # over who runs, for threads that come back from outside
        self._poked = allocate_lock()
        self._poked.acquire()
        self.founder = self.running = self.enrolled(threading.current_thread())
        MEMBERS[threading.get_ident()] = self.founder

    @property
    def members(self) -> tuple[Member, ...]:
        """The threads, in the order of their turns."""
        return tuple(self._members)

    def now_ns(self) -> int:
        """The time, read once in each turn."""
        if self._now_ns is None:
            try:
                self._last_ns = self.keeper.now_ns()
            except HubLost:
                self.keeper = ByTheClock(self._last_ns)
            self._now_ns = self._last_ns
        return self._now_ns

    def go_on_at(self, keeper: Keeper) -> None:
        """Continue with this keeper, after the program has connected to a hub again."""
        self.keeper, self._now_ns = keeper, None

    def end_ns(self, seconds: float | None) -> int:
        """Return the hub's time in ns after this many seconds from now, rounded up; NEVER for None or infinity.

        Some time passes in every span: a loop whose rest is what rounding left of its clock's seconds would never end.
        """
        if seconds is None or seconds == math.inf:
            return NEVER
        span_ns = max(1, math.ceil(seconds * 1e9 - 1e-3)) if seconds > 0 else 0
        return min(self.now_ns() + span_ns, NEVER)

    # members

    def enrolled(self, thread: threading.Thread) -> Member:
        """Add a new thread; its turn comes when others wait."""
        with self._lock:
            self._numbers += 1
            member = Member(self, thread, self._numbers)
            self._members.append(member)
        return member

    def withdraw(self, me: Member) -> None:
        """Remove a thread that did not begin."""
        with self._lock:
            self._members.remove(me)

    def begin(self, me: Member) -> None:
        """In a new thread: wait for the first turn."""
        MEMBERS[threading.get_ident()] = me
        self._rest(me)

    def end(self, me: Member) -> None:
        """In a thread that is about to end: give the turn to the next thread."""
        me.ended = True
        MEMBERS.pop(threading.get_ident(), None)
        with self._lock:
            if me in self._members:
                self._members.remove(me)
        if not self.over and self.running is me:
            self._hand_on(me, stays=False)

    def go_outside(self, me: Member) -> None:
        """Stop taking turns while this thread waits for something outside the hub; others have their turns."""
        with self._lock:
            self._members.remove(me)
            self._away += 1
        MEMBERS.pop(threading.get_ident(), None)
        if not self.over:
            self._hand_on(me, stays=False)

    def come_back(self, me: Member) -> None:
        """Let this thread take part again, from its next turn."""
        MEMBERS[threading.get_ident()] = me
        me.ready, me.until_ns, me.what = None, 0, "its turn"
        with self._lock:
            if self.over:
                MEMBERS.pop(threading.get_ident(), None)
                return
            self._away -= 1
            self._members.append(me)
            self._members.sort(key=lambda one: one.number)
            alone = self.running is None
            if alone:
                self.running = me
        if alone:
            self.keeper.rejoin()
            self._now_ns = None
            return
        self.poke()
        self._rest(me)

    def dissolve(self) -> None:
        """End the turns: from now on, all threads wait in real time."""
        with self._lock:
            if self.over:
                return
            self.over = True
            left, self._members = self._members, []
        for ident, member in list(MEMBERS.items()):
            if member.company is self:
                del MEMBERS[ident]
        for member in left:
            if member is not self.running:
                member.bell.release()
        self.when_over()

    # turns

    def wait(
        self,
        me: Member,
        ready: Callable[[], bool],
        until_ns: int,
        what: str,
        descriptors: tuple[int, ...] = (),
    ) -> bool | None:
        """Let others run until `ready()` or `until_ns`; return whether it was ready, None if the turns are over."""
        if self.over:
            return None
        me.ready, me.until_ns, me.what, me.descriptors = ready, until_ns, what, descriptors
        me.asked, me.answer, me.error = 0, False, None
        self._hand_on(me, stays=True)
        me.ready = None
        if self._is_over():  # meanwhile
            return None
        error, me.error = me.error, None
        if error is not None:
            raise error
        return me.answer

    def _is_over(self) -> bool:
        return self.over

    def poke(self) -> None:
        """Report from any thread input that the hub does not know of."""
        with self._lock:
            if self._poked.locked():
                self._poked.release()

    def _hand_on(self, me: Member, *, stays: bool) -> None:
        try:
            found = self._next(me)
        except BaseException:
            if stays:
                me.ready = None
                raise
            self.dissolve()  # no thread here can get the error: each of the others gets it by itself
            return
        if found is None:
            return
        self.turns += 1
        if found is not me:
            self.running = found
            found.bell.release()
            if stays:
                self._rest(me)

    def _rest(self, me: Member) -> None:
        """Wait for the next turn; an interruption (Ctrl-C) is raised then."""
        try:
            me.bell.acquire()
        except BaseException:
            me.until_ns = 0
            self.poke()
            me.bell.acquire()
            raise

    def _next(self, me: Member) -> Member | None:
        """Return the thread with the next turn; let time pass until one can continue. None if no thread is left."""
        while not self.over:
            found = self._able(me)
            if found is not None:
                self._quiet_since_ns = self.now_ns()
                return found
            with self._lock:
                left = bool(self._members)
            if left:
                self._let_pass(me)
                continue
            if not self.keeper.lost:
                self.keeper.leave()
            with self._lock:
                if not self._members:
                    self.running = None
                    return None
            self.keeper.rejoin()
        return None

    def _able(self, me: Member) -> Member | None:
        """Return the first thread after this one that can continue."""
        now_ns = self.now_ns()
        members = self._members
        behind = bisect_right(members, me.number, key=_number_of)
        for one in members[behind:] + members[:behind]:
            if one.ready is not never and _is_ready(one):
                one.answer = True
                return one
            if one.until_ns <= now_ns:
                return one
        return None

    def _let_pass(self, me: Member) -> None:
        until_ns = min((one.until_ns for one in self._members), default=NEVER)
        if self.keeper.lost:
            self.keeper = ByTheClock(self._last_ns)
        end_ns = self._quiet_since_ns + SILENCE_NS if self.keeper.alone else NEVER
        if self.keeper.alone and until_ns >= NEVER and self.now_ns() >= end_ns:
            self._stand_still()
            return
        me.outside += 1
        try:
            now_ns = self.keeper.pass_time(self.now_ns(), until_ns if until_ns < NEVER else end_ns)
            self._now_ns = self._last_ns = now_ns
        except HubLost:
            self.keeper = ByTheClock(self._last_ns)
        finally:
            me.outside -= 1

    def _stand_still(self) -> None:
        """All threads wait without a timeout: wait for a thread outside or for descriptors, or raise HubError."""
        if self._away:
            self._poked.acquire()
            return
        text = describe(self._members, self._quiet_since_ns)
        descriptors = tuple(found for one in self._members for found in one.descriptors)
        if descriptors:
            wait_for_descriptors(descriptors, None if self._told else text)
            self._told = True
            return
        victim = self.founder if self.founder in self._members else self._members[0]
        victim.error, victim.ready, victim.until_ns = HubError(text), None, 0


def _is_ready(one: Member) -> bool:
    """Return whether `ready` of this thread is true; if `ready` raises an error, True, and the thread gets it."""
    if one.ready is None:
        return False
    try:
        return one.ready()
    except BaseException as error:
        one.error = error
        return True
