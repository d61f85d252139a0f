"""Records as lines: candump's on a screen, candump's in a log, JSON."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from canwire import (
    SELF_RECEPTION,
    TYPE_MASK,
    BusEvent,
    EventKind,
    Frame,
    LogLine,
    format_candump_line,
    format_log_line,
    frame_of_record,
)
from canwire.commands.dump.filters import Capture
from canwire.commands.dump.stamps import Stamps
from canwire.commands.dump.words import in_words
from canwire.commands.live.decoding import Decode
from canwire.commands.live.listening import RECORD, Record
from canwire.commands.shell.colour import RED, YELLOW

SCREEN, LOG, JSON = "screen", "log", "json"
_KEPT = 1 << 16  # kinds of frames whose text is remembered
_BY_LINE = ("36", "35", "34", "32")  # cyan, magenta, blue, green: one line's, where several are shown
_WIDEST_COLOURS = 3  # -c -c -c: the time, too
_LOG_TIME = "(0000000000.000000)"


class Known(NamedTuple):
    """What is in front of the data of all frames that have the same head, and how many bytes those have.

    `length` -1: each is written by itself.
    """

    head: str
    length: int


class Extras(NamedTuple):
    """What candump's -a, -x, -8, -S and -c add to lines on a screen; `colours` counts -c, 0: as it is usual here."""

    ascii: bool = False
    messages: bool = False
    raw_dlc: bool = False
    swap: bool = False
    colours: int = 0


class Printer:
    """Prints records in a style. `epoch_ns` is added to the times of logs and JSON; without `stamps`, lines on a screen
    have no time."""

    def __init__(
        self,
        style: str,
        capture: Capture,
        *,
        stamps: Stamps | None = None,
        epoch_ns: int = 0,
        decode: Decode | None = None,
        coloured: bool = False,
        several: bool = False,
        extras: Extras = Extras(),  # noqa: B008  frozen
    ) -> None:
        self._style = style
        self._capture = capture
        self._stamps = stamps
        self._epoch_ns = epoch_ns
        self._decode = decode
        self._coloured = coloured or extras.colours > 0
        self._several = several or extras.colours > 0
        self._extras = extras
        self._separator = " " if style == SCREEN else ""
        self._known: dict[str, dict[tuple[int, int], Known | None]] = {}

    def lines(self, name: str, records: Sequence[Record]) -> list[str]:
        """One for each record that is shown, without line ends; an error on a screen has a second one within."""
        known = self._known.setdefault(name, {})
        if len(known) > _KEPT:
            known.clear()
        stamped = self._stamp()
        separator = self._separator
        shown = []
        for record in records:
            time_ns, id, info, data = record
            try:
                found = known[id, info]
            except KeyError:
                found = known[id, info] = self._learnt(name, record)
            if found is None:
                continue
            head, length = found
            if length < 0:
                line = self._whole(name, record)
                if line:
                    shown.append(line)
            elif separator:
                shown.append(f"{stamped(time_ns)}{head}{data[:length].hex(separator).upper()}")
            else:
                shown.append(f"{stamped(time_ns)}{head}{data[:length].hex().upper()}")
        return shown

    def _stamp(self) -> Callable[[int], str]:
        if self._style == LOG:
            return self._log_time
        stamps = self._stamps
        return _nothing if stamps is None else lambda time_ns: f" {stamps.text(time_ns)}"

    def _log_time(self, time_ns: int) -> str:
        micros = (time_ns + self._epoch_ns) // 1000
        return f"({micros // 1_000_000:010d}.{micros % 1_000_000:06d})"

    def _learnt(self, name: str, record: Record) -> Known | None:
        """How such frames are written; None where they are not shown."""
        if record[2] & TYPE_MASK:
            return Known("", -1)
        frame = frame_of_record(RECORD.pack(*record))
        if not self._capture.of(name).accepts(frame):
            return None
        by_itself = self._decode is not None or (self._coloured and self._several)
        by_itself = by_itself or self._extras.ascii or self._extras.swap
        if self._style == JSON or by_itself:
            return Known("", -1)
        length = 0 if frame.remote else len(frame.data)
        text = self._written(LogLine(0, name, frame, self._direction(record))).removeprefix(_LOG_TIME)
        tail = record[3][:length].hex(*self._separator).upper()
        return Known(text[: len(text) - len(tail)], length) if text.endswith(tail) else Known("", -1)

    def _whole(self, name: str, record: Record) -> str:
        """Of one record, by itself; "" where it is not shown."""
        packed = RECORD.pack(*record)
        content = BusEvent.from_record(packed) if record[2] & TYPE_MASK else frame_of_record(packed)
        if not self._capture.of(name).accepts(content):
            return ""
        message = (
            self._decode(content, name) if self._decode is not None and isinstance(content, Frame) else None
        )
        line = LogLine(self._epoch_ns + record[0], name, content, self._direction(record))
        if self._style == JSON:
            from canwire.commands.dump.as_json import format_json

            return format_json(line, message)
        if self._style == LOG:
            return self._written(line)
        text = self._written(line)
        if message is not None:
            text = f"{text}  :: {message}"
        stamp, colour = self._stamp()(record[0]), self._colour(name, content)
        if not colour:
            return f"{stamp}{text}"
        if self._extras.colours >= _WIDEST_COLOURS:
            return f"\x1b[{colour}m{stamp}{text}\x1b[0m"
        end = text.index(name) + len(name) if self._extras.colours == 1 else len(text)
        return f"{stamp}\x1b[{colour}m{text[:end]}\x1b[0m{text[end:]}"

    def _direction(self, record: Record) -> str | None:
        """Shown with -x; what the line itself sent is T."""
        if not self._extras.messages:
            return None
        return "R" if record[2] & TYPE_MASK or not record[2] & SELF_RECEPTION else "T"

    def _written(self, line: LogLine) -> str:
        if self._style == LOG:
            return format_log_line(line)
        extras = self._extras
        text = format_candump_line(line, ascii=extras.ascii, raw_dlc=extras.raw_dlc, swap=extras.swap)
        return f"{text}\n\t{in_words(line.content)}" if isinstance(line.content, BusEvent) else text

    def _colour(self, name: str, content: Frame | BusEvent) -> str:
        """Return the colour of the content, "" for none."""
        if not self._coloured:
            return ""
        if isinstance(content, BusEvent):
            return RED if content.kind is EventKind.ERROR else YELLOW
        return _BY_LINE[list(self._known).index(name) % len(_BY_LINE)] if self._several else ""


def _nothing(time_ns: int) -> str:
    return ""
