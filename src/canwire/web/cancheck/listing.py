"""The lists of CanCheck's windows: rows of text, all numbers hexadecimal, the newest kept, and a log of all of them.

Source: CANDRV manual, 10.4.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue
from canwire.candrv import CanbusEvent
from canwire.candrv.filters import aligned

if TYPE_CHECKING:
    from typing import TextIO

    from canwire.candrv import Event
    from canwire.web.cancheck.recipe import Outgoing

KEPT = 5_000
DWORD = 0xFFFF_FFFF
PAUSED = "-Paused-"
Row = tuple[str, ...]
_EMPTY: Row = ("", "", "", "", "")


class Since(NamedTuple):
    """`rows` that a viewer has not seen, the first of which is number `start`.

    Those before `first` are not in the list any more; `total` is the number of the next one.
    """

    first: int
    start: int
    total: int
    rows: list[Row]


class Listing:
    """Any thread may use it. `changed` is called after every change."""

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self._lock = threading.Lock()
        self._rows: deque[Row] = deque(maxlen=KEPT)
        self._total = 0
        self._changed = changed
        self._log: TextIO | None = None
        self.log_name = ""
        self.trouble = ""

    def append(self, *rows: Row) -> None:
        """Add rows, which are shown and logged."""
        with self._lock:
            self._rows.extend(rows)
            self._total += len(rows)
            for row in rows if self._log is not None else ():
                self._write(row)
        if rows:
            self._changed()

    def clear(self) -> None:
        """Show nothing of it any more; the log stays as it is."""
        with self._lock:
            self._rows.clear()
        self._changed()

    def rows(self) -> list[Row]:
        with self._lock:
            return list(self._rows)

    def since(self, number: int, most: int) -> Since:
        """The newest rows from this number on, at most so many."""
        with self._lock:
            first = self._total - len(self._rows)
            start = max(number, first, self._total - most)
            rows = [self._rows[place] for place in range(start - first, self._total - first)]
            return Since(first, start, self._total, rows)

    def open_log(self, path: Path, *, overwrite: bool = False) -> None:
        """Write what comes from now on to a file, too; raises FileExistsError, OSError, BadValue where one is open."""
        with self._lock:
            if self._log is not None:
                raise BadValue(f"{self.log_name} is open; close it first")
            self._log = path.open("w" if overwrite else "x", encoding="utf-8", newline="\n", buffering=1)
            self.log_name, self.trouble = path.name, ""
        self._changed()

    def close_log(self) -> None:
        """A second time does nothing."""
        with self._lock:
            log, self._log, self.log_name = self._log, None, ""
            if log is not None:
                log.close()
        self._changed()

    def _write(self, row: Row) -> None:
        if self._log is None:
            return
        try:
            self._log.write("\t".join(row).rstrip() + "\n")
        except OSError as error:
            self.trouble = f"{self.log_name}: {error.strerror}; the log ends here"
            log, self._log, self.log_name = self._log, None, ""
            with suppress(OSError):  # the same once more: what could not be written is still in its buffer
                log.close()


def shown_time(time_ms: int) -> str:
    """The low word of a CAN_TIME."""
    return f"{time_ms & DWORD:08X}"


def event_row(event: Event) -> Row:
    """Event, Time, Lost, Frm, ID, R, L, Data; the last five only for received, transmitted and aborted messages."""
    kind = CanbusEvent(event.event).name or f"{event.event:X}"
    head = (kind, shown_time(event.time), f"{event.lost:X}")
    if not event.has_message:
        return (*head, *_EMPTY)
    frame = "EXT" if event.fmt == 2 else "STD"
    return (
        *head,
        frame,
        f"{event.identifier:08X}",
        f"{event.rtr:X}",
        f"{event.dlc:X}",
        event.data[:8].hex(" ").upper(),
    )


def message_row(time: str, index: int, message: Outgoing, align: int) -> Row:
    """The cells of a generated message: Time, Gen., Frm, ID, R, L, Data."""
    return (
        time,
        f"{index:X}",
        "EXT" if message.extended else "STD",
        f"{aligned(message.identifier, message.extended, align):08X}",
        f"{message.rtr:X}",
        f"{message.dlc:X}",
        message.data.hex(" ").upper(),
    )
