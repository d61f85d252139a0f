"""What is to be sent: rows with a frame each, sent by hand or over and over. One list for all viewers."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from canwire import BadValue, CanwireError, Frame

MOST_ROWS = 200


@dataclass(frozen=True)
class Row:
    """One frame for one line (its address). `cycle_ms` 0: by hand alone; `most` 0: without end, else so often.

    `message` and `signals` are what the frame was made of, where it was. `running`: it is sent in its cycle now;
    `queued` counts the frames since it was made, `failed` those that could not be, and `trouble` says why the last
    one could not.
    """

    number: int
    line: str
    frame: Frame
    cycle_ms: float = 0.0
    key: str = ""
    most: int = 0
    comment: str = ""
    message: str = ""
    signals: tuple[tuple[str, str], ...] = ()
    running: bool = False
    queued: int = 0
    left: int = 0
    failed: int = 0
    trouble: str = ""


class TransmitList:
    """`send(row, line, frame)` queues a frame or raises CanwireError; `drop(row)` takes back what still waits.

    Cycles run in a thread of its own until `close`.
    """

    def __init__(
        self,
        send: Callable[[int, str, Frame], None],
        drop: Callable[[int], None],
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._send = send
        self._drop = drop
        self._clock_s = clock_s
        self._changed = threading.Condition()
        self._rows: dict[int, Row] = {}
        self._due_s: dict[int, float] = {}
        self._next = 1
        self._ends = False
        self._thread = threading.Thread(target=self._run, name="transmit list")
        self._thread.start()

    @property
    def rows(self) -> list[Row]:
        """As they are now, in the order in which they were made."""
        with self._changed:
            return list(self._rows.values())

    def put(self, row: Row) -> Row:
        """Add a row (number 0), or change one, whose cycle goes on; raises BadValue where the list is full."""
        with self._changed:
            if row.number == 0:
                if len(self._rows) >= MOST_ROWS:
                    raise BadValue(f"the list has {MOST_ROWS} rows; remove one first")
                row, self._next = replace(row, number=self._next), self._next + 1
            else:
                before = self._row(row.number)
                running = before.running and row.cycle_ms > 0
                row = replace(row, queued=before.queued, failed=before.failed, running=running, left=row.most)
                if running:
                    self._due_s[row.number] = min(
                        self._due_s[row.number], self._clock_s() + row.cycle_ms / 1000
                    )
                    self._changed.notify()
                else:
                    self._due_s.pop(row.number, None)
            self._rows[row.number] = row
            return self._rows[row.number]

    def remove(self, number: int) -> None:
        """Raises BadValue for a row that is not there."""
        with self._changed:
            self._row(number)
            del self._rows[number]
            self._due_s.pop(number, None)
            self._drop(number)

    def send_now(self, number: int) -> None:
        """Once; raises what keeps the frame from being queued, and counts it."""
        with self._changed:
            row = self._row(number)
            try:
                self._send(row.number, row.line, row.frame)
            except CanwireError as error:
                self._rows[number] = replace(row, failed=row.failed + 1, trouble=str(error))
                raise
            self._rows[number] = replace(row, queued=row.queued + 1, trouble="")

    def start(self, number: int) -> None:
        """Begin its cycle, with a frame at once; raises BadValue for a row without one."""
        with self._changed:
            row = self._row(number)
            if not row.cycle_ms:
                raise BadValue(f"row {number} has no cycle time")
            self._rows[number] = replace(row, running=True, left=row.most)
            self._due_s[number] = self._clock_s()
            self._changed.notify()

    def stop(self, number: int) -> None:
        """End its cycle; nothing that still waits goes out. Raises BadValue for a row that is not there."""
        with self._changed:
            self._rows[number] = replace(self._row(number), running=False)
            self._due_s.pop(number, None)
            self._drop(number)

    def stop_all(self) -> None:
        for row in self.rows:
            self.stop(row.number)

    def close(self) -> None:
        """End all cycles; a second time does nothing."""
        with self._changed:
            self._ends = True
            self._changed.notify()
        self._thread.join()

    def fire(self) -> float | None:
        """Send whatever is due, each row once; seconds until the next one is, None if none is running."""
        with self._changed:
            now_s = self._clock_s()
            for number in [number for number, due_s in self._due_s.items() if due_s <= now_s]:
                self._fire(number, now_s)
            return max(0.0, min(self._due_s.values()) - self._clock_s()) if self._due_s else None

    def _fire(self, number: int, now_s: float) -> None:
        row = self._rows[number]
        try:
            self._send(row.number, row.line, row.frame)
            row = replace(row, queued=row.queued + 1, trouble="")
        except CanwireError as error:
            row = replace(row, failed=row.failed + 1, trouble=str(error))
        if row.most and row.left == 1:
            self._rows[number] = replace(row, running=False, left=0)
            del self._due_s[number]
            return
        self._rows[number] = replace(row, left=max(0, row.left - 1))
        period_s = row.cycle_ms / 1000
        # a row that is late by more than a cycle leaves those out instead of sending a burst
        self._due_s[number] = max(self._due_s[number] + period_s, now_s)

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
