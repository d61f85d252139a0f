"""The lists of CanCheck's windows: rows of text with hexadecimal numbers. The newest rows are kept; a log gets all
rows.

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
    """`rows` that a viewer has not received yet; the first one has the number `start`.

    Rows before `first` are no longer in the list; `total` is the number of the next row.
    """

    first: int
    start: int
    total: int
    rows: list[Row]


class Listing:
    """A list of rows, for use by any thread. `changed` is called after every change."""

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self._lock = threading.Lock()
        self._rows: deque[Row] = deque(maxlen=KEPT)
        self._total = 0
        self._changed = changed
        self._log: TextIO | None = None
        self.log_name = ""
        self.trouble = ""

    def append(self, *rows: Row) -> None:
        """Append rows to the list, and to the log if one is open."""
        with self._lock:
            self._rows.extend(rows)
            self._total += len(rows)
            for row in rows if self._log is not None else ():
                self._write(row)
        if rows:
            self._changed()

    def clear(self) -> None:
        """Remove all rows from the list; the log stays unchanged."""
        with self._lock:
            self._rows.clear()
        self._changed()

    def rows(self) -> list[Row]:
        with self._lock:
            return list(self._rows)

    def since(self, number: int, most: int) -> Since:
        """Return the newest rows from this number on, at most `most`."""
        with self._lock:
            first = self._total - len(self._rows)
            start = max(number, first, self._total - most)
            rows = [self._rows[place] for place in range(start - first, self._total - first)]
            return Since(first, start, self._total, rows)

    def open_log(self, path: Path, *, overwrite: bool = False) -> None:
        """Also write all rows from now on to a file; raises FileExistsError, OSError, and BadValue if a log is open."""
        with self._lock:
            if self._log is not None:
                raise BadValue(f"{self.log_name} is open; close it first")
            self._log = path.open("w" if overwrite else "x", encoding="utf-8", newline="\n", buffering=1)
            self.log_name, self.trouble = path.name, ""
        self._changed()

    def close_log(self) -> None:
        """Close the log; a second call does nothing."""
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
    """Return the low 32 bits of a CAN_TIME in hex."""
    return f"{time_ms & DWORD:08X}"


def event_row(event: Event) -> Row:
    """Return the cells of an event: Event, Time, Lost, Frm, ID, R, L, Data; the last five only if it has a message."""
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
    """Return the cells of a generated message: Time, Gen., Frm, ID, R, L, Data."""
    return (
        time,
        f"{index:X}",
        "EXT" if message.extended else "STD",
        f"{aligned(message.identifier, message.extended, align):08X}",
        f"{message.rtr:X}",
        f"{message.dlc:X}",
        message.data.hex(" ").upper(),
    )
