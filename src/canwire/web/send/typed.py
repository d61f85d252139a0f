"""Makes a row of the list from typed values, with every fault at its field."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import BadFrame, BadSignals, BadValue, Frame, LinFrame
from canwire.web.send import changing, steps
from canwire.web.send.row import Content, Row

if TYPE_CHECKING:
    from canwire.web.database import Database
    from canwire.web.fields import Fields
    from canwire.web.words import Words

SLOWEST_MS = 3_600_000
LONGEST_STEPS = 20_000
CAN_FORMATS, LIN_FORMATS = ("classic", "remote", "fd", "fdbrs"), ("lin", "header")
FORMATS = (*CAN_FORMATS, *LIN_FORMATS, "sequence", "linsequence")
_FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)
DatabaseOf = Callable[[str], "Database"]


def typed_row(fields: Fields, word: Words, database_of: DatabaseOf) -> Row:
    """Return the row of the fields number (0: a new row), line, cycle, most, key, comment, exact; raises BadFields.

    The frame is format, id, data or dlc; or message, and each of its signals as "signal.NAME"; or a sequence, `steps`.
    `changes` are the values that change between frames. `database_of` returns the description of a line's bus.
    """
    number = fields.whole("number", 0, 1_000_000) if fields.text("number") else 0
    line = fields.text("line", longest=80, empty=False)
    cycle_ms = fields.real("cycle", 1, SLOWEST_MS) if fields.text("cycle") not in ("", "0") else 0.0
    most = fields.whole("most", 0, 1_000_000_000) if fields.text("most") else 0
    key = fields.text("key", longest=1).lower()
    if key and not re.fullmatch(r"[a-z0-9]", key):
        fields.fault("key", word("send.bad-key"))
    content = Typing(fields, word, database_of(line)).content()
    exact = fields.flag("exact")
    if exact:
        _check_exact(fields, word, content, cycle_ms, most)
    fields.check()
    return Row(number, line, content, cycle_ms, key, most, fields.text("comment"), exact)


def _check_exact(fields: Fields, word: Words, content: Content, cycle_ms: float, most: int) -> None:
    counted = [change for change in content.changes if not change.counts]
    if content.lin or content.steps or counted or len(content.changes) > 1 or most > 65_535:
        fields.fault("exact", word("send.not-exact"))
    elif not cycle_ms:
        fields.fault("cycle", word("base.needed"))


class Typing:
    """The content of a row by its fields; faults are noted in the fields, and a meaningless content is returned."""

    def __init__(self, fields: Fields, word: Words, database: Database) -> None:
        self._fields = fields
        self._word = word
        self._database = database

    def content(self) -> Content:
        message = self._fields.text("message", longest=200)
        kind = self._fields.choice("format", FORMATS) if not message else ""
        if kind in ("sequence", "linsequence"):
            return self._sequence(kind == "linsequence")
        signals: dict[str, str] = {}
        if message:
            signals = {
                one.name: self._fields.text(f"signal.{one.name}") for one in self._database.inputs(message)
            }
            frame = self._by_signals(message, signals)
        else:
            frame = self._lin_frame(kind == "header") if kind in LIN_FORMATS else self._can_frame(kind)
        return Content(
            frame, message, signals, changes=self._changes(frame, message, signals), encode=self._encode
        )

    def _encode(self, message: str, signals: dict[str, str]) -> Frame | LinFrame:
        return self._database.encode(message, signals)

    def _sequence(self, lin: bool) -> Content:
        try:
            text = self._fields.text("steps", longest=LONGEST_STEPS, empty=False)
            found = steps.parsed(text, self._database, lin=lin)
        except BadValue as bad:
            self._fields.fault("steps", self._word("send.bad-step", part=str(bad)[:200]))
            return Content(Frame(0))
        return Content(found[0].frame, steps=found, text=text)

    def _changes(
        self, frame: Frame | LinFrame, message: str, signals: dict[str, str]
    ) -> tuple[changing.Change, ...]:
        part = ""
        try:
            found = changing.parsed(self._fields.text("changes", longest=1000))
            for part, change in ((change.name, change) for change in found):
                if change.byte >= len(frame.data) or (change.byte < 0 and change.name not in signals):
                    raise BadValue(part)
                if change.byte < 0:
                    for value in (change.low, change.high):
                        self._encode(message, {**signals, change.name: f"{value:.12g}"})
        except (BadValue, BadSignals) as bad:
            self._fields.fault("changes", self._word("send.bad-change", part=part or str(bad)[:100]))
            return ()
        return found

    def _can_frame(self, kind: str) -> Frame:
        fields = self._fields
        extended = fields.flag("extended")
        identifier = fields.hexadecimal("id", 0, 0x1FFFFFFF if extended else 0x7FF)
        remote, fd = kind == "remote", kind in ("fd", "fdbrs")
        data = b"" if remote else self._data(_FD_LENGTHS if fd else range(9), _shown(fd))
        dlc = fields.whole("dlc", 0, 8) if remote and fields.text("dlc") else 0 if remote else None
        try:
            return Frame(
                identifier,
                data,
                extended=extended,
                remote=remote,
                fd=fd,
                bit_rate_switch=kind == "fdbrs",
                dlc=dlc,
            )
        except BadFrame as error:
            fields.fault("data", str(error))
            return Frame(0)

    def _lin_frame(self, header: bool) -> LinFrame:
        fields = self._fields
        identifier = fields.hexadecimal("id", 0, 0x3F)
        data = b"" if header else self._data(range(9), "0–8")
        length = fields.whole("dlc", 0, 8) if header and fields.text("dlc") else 0
        enhanced = False if fields.flag("checksum") else None
        if header:
            return LinFrame(identifier, header_only=True, length=length)
        return LinFrame(identifier, data, enhanced=enhanced)

    def _by_signals(self, message: str, signals: dict[str, str]) -> Frame | LinFrame:
        try:
            return self._database.encode(message, signals)
        except BadSignals as bad:
            for name, fitting in bad.faults.items():
                if name in signals:
                    self._fields.fault(f"signal.{name}", self._word("send.bad-signal", fitting=fitting))
                else:
                    self._fields.fault("message", self._word("base.no-choice", value=message[:40]))
            return Frame(0)

    def _data(self, lengths: tuple[int, ...] | range, shown: str) -> bytes:
        text = re.sub(r"[\s.,:]", "", self._fields.text("data"))
        if not re.fullmatch(r"(?:[0-9A-Fa-f]{2})*", text):
            self._fields.fault("data", self._word("send.bad-data"))
            return b""
        data = bytes.fromhex(text)
        if len(data) not in lengths:
            self._fields.fault("data", self._word("send.bad-length", count=len(data), lengths=shown))
            return b""
        return data


def _shown(fd: bool) -> str:
    return "0–8, 12, 16, 20, 24, 32, 48, 64" if fd else "0–8"
