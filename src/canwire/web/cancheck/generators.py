"""Message generators: their due times, their messages, and their pauses.

This file uses neither thread nor clock: the caller calls `fire`, which returns when to call it next.
Source: CANDRV manual, 10.4, send dialog; rulings.md 35.
"""

from __future__ import annotations

import heapq
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from canwire import BadValue, CanwireError
from canwire.web.cancheck.recipe import Outgoing, Recipe
from canwire.web.words import Trouble

MS = 1_000_000  # ns
RETRY_NS = 5 * MS  # before looking again for room in the send buffer
BURST = 64  # messages of one `fire`, so that others get their turn


class Row(NamedTuple):
    """A generator as the list shows it. `due_ns` None: paused. `message` is the next message.

    `waits`: the generator is due, but the send buffer is full. `trouble`: the error that paused it, "" if none did.
    """

    number: int
    due_ns: int | None
    message: Outgoing
    waits: bool
    trouble: str


@dataclass(eq=False)
class _Generator:
    number: int
    recipe: Recipe
    active: bool = False
    due_ns: int = 0
    step: int = 0
    turn: int = 0  # of those that are due at one time, who sent longest ago is the next
    waits: bool = False
    trouble: str = ""
    before: tuple[bool, int] | None = None  # state and time from which it was taken for editing


class Generators:
    """Any number of generators, for use by any thread. `send(index, message)` returns whether there was room, or raises
    CanwireError."""

    def __init__(self, send: Callable[[int, Outgoing], bool], clock_ns: Callable[[], int]) -> None:
        self._send = send
        self._clock_ns = clock_ns
        self._changed = threading.Condition(threading.RLock())
        self._all: list[_Generator] = []
        self._queue: list[
            tuple[int, int, int]
        ] = []  # due_ns, turn and number; of active ones the latest entry counts
        self._turns = 0

    def rows(self) -> list[Row]:
        with self._changed:
            return [
                Row(
                    number,
                    one.due_ns if one.active else None,
                    one.recipe.message(one.step),
                    one.active and one.waits,
                    one.trouble,
                )
                for number, one in enumerate(self._all)
            ]

    def recipe(self, index: int) -> Recipe:
        """Return the recipe of a generator; raises BadValue for an unknown index, like all methods with an index."""
        with self._changed:
            return self._one(index).recipe

    def add(self, recipe: Recipe, *, active: bool) -> int:
        """Add a generator; returns its index."""
        with self._changed:
            index = len(self._all)
            self._all.append(_Generator(index, recipe))
            if active:
                self.activate(index)
            return index

    def begin_edit(self, index: int) -> Recipe:
        """Begin to edit a generator: it is paused until `cancel_edit` or `change`."""
        with self._changed:
            one = self._one(index)
            if one.before is None:
                one.before = one.active, one.due_ns
            one.active = False
            return one.recipe

    def cancel_edit(self, index: int) -> None:
        """Restore the state before `begin_edit`; do nothing if the generator was activated, paused or changed since."""
        with self._changed:
            one = self._one(index)
            if one.before is not None:
                active, due_ns = one.before
                one.before = None
                if active:
                    self._begin(one, due_ns)

    def change(self, index: int, recipe: Recipe, *, active: bool) -> None:
        """Replace the recipe of a generator; its values restart at From."""
        with self._changed:
            one = self._one(index)
            one.recipe, one.step = recipe, 0
            if active:
                self.activate(index)
            else:
                self.pause(index)

    def activate(self, index: int) -> None:
        """Make the next message due immediately; a generator that is already active keeps its due time."""
        with self._changed:
            one = self._one(index)
            one.before, one.trouble = None, ""
            if not one.active:
                self._begin(one, self._clock_ns())

    def pause(self, index: int) -> None:
        """Pause a generator; it keeps its values, and continues with them when it is activated again."""
        with self._changed:
            one = self._one(index)
            one.before, one.trouble, one.active = None, "", False

    def activate_all(self) -> None:
        with self._changed:
            for index in range(len(self._all)):
                self.activate(index)

    def pause_all(self) -> None:
        with self._changed:
            for index in range(len(self._all)):
                self.pause(index)

    def fire(self) -> int | None:
        """Send all due messages; returns nanoseconds until the next one is due, None while all
        generators are paused."""
        with self._changed:
            if self._next() is None:
                return None
            now_ns = self._clock_ns()
            for _ in range(BURST):
                due = self._next()
                if due is None or due.due_ns > now_ns:
                    break
                if not self._fire(due, now_ns):
                    return RETRY_NS
            due = self._next()
            return None if due is None else max(0, due.due_ns - now_ns)

    def wait(self, pause_ns: int | None) -> None:
        """Wait for `pause_ns` of the clock (None: no limit), or until a generator was activated."""
        with self._changed:
            if pause_ns is not None or self._next() is None:
                self._changed.wait(None if pause_ns is None else pause_ns / 1e9)

    def wake(self) -> None:
        """End a `wait`."""
        with self._changed:
            self._changed.notify_all()

    def _fire(self, one: _Generator, now_ns: int) -> bool:
        """Send one message of a generator; returns whether there was room."""
        try:
            room = self._send(one.number, one.recipe.message(one.step))
        except CanwireError as error:
            one.active, one.waits, one.trouble = False, False, Trouble.of(error)
            return True
        one.waits = not room
        if room:
            self._sent(one, now_ns)
        return room

    def _sent(self, one: _Generator, now_ns: int) -> None:
        self._turns += 1
        one.turn = self._turns
        one.step += 1
        delay_ns = one.recipe.delay_ms * MS
        # one that was late, or waited for room, makes no burst of what it missed
        one.due_ns = one.due_ns + delay_ns if one.due_ns + delay_ns > now_ns else now_ns + delay_ns
        if one.recipe.ends and one.step >= one.recipe.cycle:
            one.active, one.step = False, 0
        else:
            self._wait_for_turn(one)

    def _begin(self, one: _Generator, due_ns: int) -> None:
        one.active, one.due_ns = True, due_ns
        self._wait_for_turn(one)
        self._changed.notify_all()

    def _wait_for_turn(self, one: _Generator) -> None:
        heapq.heappush(self._queue, (one.due_ns, one.turn, one.number))

    def _next(self) -> _Generator | None:
        """Return the active generator that is due first; drop outdated entries of the queue."""
        while self._queue:
            due_ns, turn, number = self._queue[0]
            one = self._all[number]
            if one.active and (one.due_ns, one.turn) == (due_ns, turn):
                return one
            heapq.heappop(self._queue)
        return None

    def _one(self, index: int) -> _Generator:
        if not 0 <= index < len(self._all):
            raise BadValue(f"generator {index:X}: there are {len(self._all)}")
        return self._all[index]
