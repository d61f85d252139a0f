"""The transmit list: rows with a frame each, sent by hand or repeatedly. One list for all viewers."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from canwire import BadValue, CanwireError
from canwire.web.send.row import Row, Sent
from canwire.web.words import Trouble

MOST_ROWS = 200
_RETRY_S = 0.002  # a sequence waits for its last frame to be acknowledged, in such steps


class Exact(Protocol):
    """Sends rows at exact cycles, by the hub's cyclic lists."""

    def start(self, row: Row) -> None:
        """Begin, or continue with the row's present values; raises CanwireError."""

    def stop(self, number: int) -> None:
        """Send no more frames of this row."""

    def over(self, number: int) -> str | None:
        """Return None while the row is sent; afterwards the error that ended it, "" if it was sent as often as
        requested."""


class TransmitList:
    """The list. `send(row, line, frame)` queues a frame or raises CanwireError; `drop(row)` discards its waiting
    frames.

    A separate thread runs cycles until `close`; `exact` runs those of exact rows.
    """

    def __init__(
        self,
        send: Callable[[int, str, Sent], None],
        drop: Callable[[int], None],
        exact: Exact,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._send = send
        self._drop = drop
        self._exact = exact
        self._clock_s = clock_s
        self._changed = threading.Condition()  # reentrant: its lock is an RLock
        self._rows: dict[int, Row] = {}
        self._due_s: dict[int, float] = {}
        self._begun_s: dict[int, float] = {}  # when a sequence's round began
        self._next = 1
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="transmit list")
        self._thread.start()

    @property
    def rows(self) -> list[Row]:
        """The present rows, in the order in which they were made."""
        with self._changed:
            for row in list(self._rows.values()):
                if row.exact and row.running and (why := self._exact.over(row.number)) is not None:
                    self._exact.stop(row.number)
                    self._rows[row.number] = replace(row, running=False, trouble=why)
            return list(self._rows.values())

    def row(self, number: int) -> Row:
        """Return a row; raises BadValue if it does not exist."""
        with self._changed:
            return self._row(number)

    def put(self, row: Row) -> Row:
        """Add a row (number 0), or change one, whose cycle continues; raises BadValue if the list is full.

        Raises CanwireError if the hub's cyclic list refuses the changed exact row, which is then stopped.
        """
        with self._changed:
            if row.number == 0:
                if len(self._rows) >= MOST_ROWS:
                    raise BadValue(f"the list has {MOST_ROWS} rows; remove one first")
                row, self._next = replace(row, number=self._next), self._next + 1
                self._rows[row.number] = row
                return row
            before = self._row(row.number)
            running = before.running and (row.cycle_ms > 0 or bool(row.content.steps))
            row = replace(row, queued=before.queued, failed=before.failed, left=row.most)
            due_s = self._due_s.pop(row.number, None)
            if before.exact and not (running and row.exact):
                self._exact.stop(row.number)
            self._rows[row.number] = row
            if running:
                self._begin(row, due_s)
            return self._rows[row.number]

    def remove(self, number: int) -> None:
        """Remove a row; raises BadValue if it does not exist."""
        with self._changed:
            self.stop(number)
            del self._rows[number]

    def send_now(self, number: int) -> None:
        """Send a row, or a whole sequence, once. An error that prevents queuing the frame is counted and raised."""
        with self._changed:
            row = self._row(number)
            if row.content.steps:
                self._rows[number] = replace(row, left=1, running=True, step=0)
                self._wake(number, self._clock_s())
                return
            try:
                self._send(row.number, row.line, row.content.at(row.queued))
            except CanwireError as error:
                self._rows[number] = row.refused(Trouble.of(error))
                raise
            self._rows[number] = row.sent()

    def start(self, number: int) -> None:
        """Begin a row's cycle, with a frame immediately; raises BadValue for a row without a cycle.

        An exact row's first frame is sent after one cycle; raises CanwireError if the hub's list refuses it.
        """
        with self._changed:
            row = self._row(number)
            if not row.cycle_ms:
                raise BadValue(f"row {number} has no cycle time")
            self._begin(replace(row, left=row.most, step=0), self._clock_s())

    def stop(self, number: int) -> None:
        """End a row's cycle; its waiting frames are discarded. Raises BadValue if the row does not exist."""
        with self._changed:
            row = self._row(number)
            self._rows[number] = replace(row, running=False, step=0)
            self._due_s.pop(number, None)
            if row.exact:
                self._exact.stop(number)
            self._drop(number)

    def stop_all(self) -> None:
        for row in self.rows:
            self.stop(row.number)

    def close(self) -> None:
        """End all cycles; a second call does nothing."""
        with self._changed:
            self._ends = True
            self._changed.notify()
        self._thread.join()

    def fire(self) -> float | None:
        """Send all rows that are due, each once; returns the seconds until the next one, None if no cycle runs."""
        with self._changed:
            now_s = self._clock_s()
            for number in [number for number, due_s in self._due_s.items() if due_s <= now_s]:
                row = self._rows[number]
                if row.content.steps:
                    self._fire_step(row, now_s)
                else:
                    self._fire(row, now_s)
            return max(0.0, min(self._due_s.values()) - self._clock_s()) if self._due_s else None

    def _begin(self, row: Row, due_s: float | None) -> None:
        if row.exact:
            try:
                self._exact.start(row)
            except CanwireError as error:
                self._rows[row.number] = row.refused(Trouble.of(error))
                raise
            self._rows[row.number] = replace(row, running=True, trouble="")
            return
        self._rows[row.number] = replace(row, running=True)
        now_s = self._clock_s()
        self._wake(row.number, now_s if due_s is None else min(due_s, now_s + row.cycle_ms / 1000))

    def _wake(self, number: int, due_s: float) -> None:
        self._due_s[number] = due_s
        self._begun_s[number] = due_s
        self._changed.notify()

    def _fire(self, row: Row, now_s: float) -> None:
        try:
            self._send(row.number, row.line, row.content.at(row.queued))
            row = row.sent()
        except CanwireError as error:
            row = row.refused(Trouble.of(error))
        self._again(row, self._due_s[row.number], now_s)

    def _fire_step(self, row: Row, now_s: float) -> None:
        """Send one frame of a sequence; a frame that cannot be sent yet is tried again later, so that the order is
        kept."""
        steps = row.content.steps
        try:
            self._send(row.number, row.line, steps[row.step].frame)
        except CanwireError as error:
            self._rows[row.number] = replace(row, trouble=Trouble.of(error))
            self._due_s[row.number] = now_s + _RETRY_S
            return
        pause_s = steps[row.step].pause_ms / 1000
        row = replace(row.sent(), step=row.step + 1)
        if row.step < len(steps):
            self._rows[row.number] = row
            self._due_s[row.number] = max(self._due_s[row.number] + pause_s, now_s)
            return
        begun_s = self._begun_s[row.number]
        self._again(replace(row, step=0), begun_s, max(now_s, self._due_s[row.number] + pause_s))

    def _again(self, row: Row, begun_s: float, earliest_s: float) -> None:
        """Schedule the row's next round, unless this was the last one."""
        if row.left == 1 or not row.cycle_ms:
            self._rows[row.number] = replace(row, running=False, left=0)
            del self._due_s[row.number]
            return
        self._rows[row.number] = replace(row, left=max(0, row.left - 1))
        # a row that is late by more than a cycle leaves those out instead of sending a burst
        self._due_s[row.number] = max(begun_s + row.cycle_ms / 1000, earliest_s)
        self._begun_s[row.number] = self._due_s[row.number]

    def _row(self, number: int) -> Row:
        if number not in self._rows:
            raise BadValue(f"row {number} is not in the list any more")
        return self._rows[number]

    def _run(self) -> None:
        while True:
            pause_s = self.fire()
            with self._changed:
                if self._ends:
                    return
                if pause_s != 0.0:
                    self._changed.wait(pause_s)
