"""A row of the list as it was typed: every fault at its field."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from canwire import BadFrame, BadSignals, Frame
from canwire.web.database import Database
from canwire.web.send.transmit_list import Row

if TYPE_CHECKING:
    from canwire.web.fields import Fields
    from canwire.web.words import Words

SLOWEST_MS = 3_600_000
_FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


def typed_row(fields: Fields, word: Words, database: Database) -> Row:
    """Fields: number (0: a new one), line, cycle, most, key, comment; raises BadFields.

    The frame is format, id, data or dlc; or message, and each of its signals as "signal.NAME".
    """
    number = fields.whole("number", 0, 1_000_000) if fields.text("number") else 0
    line = fields.text("line", longest=80, empty=False)
    cycle_ms = fields.real("cycle", 1, SLOWEST_MS) if fields.text("cycle") not in ("", "0") else 0.0
    most = fields.whole("most", 0, 1_000_000_000) if fields.text("most") else 0
    key = fields.text("key", longest=1).lower()
    if key and not re.fullmatch(r"[a-z0-9]", key):
        fields.fault("key", word("send.bad-key"))
    comment = fields.text("comment")
    message = fields.text("message", longest=200)
    frame = _by_signals(fields, word, database, message) if message else _typed_frame(fields, word)
    fields.check()
    signals = tuple((one.name, fields.text(f"signal.{one.name}")) for one in database.inputs(message))
    return Row(number, line, frame, cycle_ms, key, most, comment, message, signals)


def _typed_frame(fields: Fields, word: Words) -> Frame:
    extended = fields.flag("extended")
    kind = fields.choice("format", ("classic", "remote", "fd", "fdbrs"))
    identifier = fields.hexadecimal("id", 0, 0x1FFFFFFF if extended else 0x7FF)
    remote, fd = kind == "remote", kind in ("fd", "fdbrs")
    data = b"" if remote else _typed_data(fields, word, fd)
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


def _by_signals(fields: Fields, word: Words, database: Database, message: str) -> Frame:
    values = {one.name: fields.text(f"signal.{one.name}") for one in database.inputs(message)}
    try:
        return database.encode(message, values)
    except BadSignals as bad:
        for name, fitting in bad.faults.items():
            if name in values:
                fields.fault(f"signal.{name}", word("send.bad-signal", fitting=fitting))
            else:
                fields.fault("message", word("base.no-choice", value=message[:40]))
        return Frame(0)


def _typed_data(fields: Fields, word: Words, fd: bool) -> bytes:
    text = re.sub(r"[\s.,:]", "", fields.text("data"))
    if not re.fullmatch(r"(?:[0-9A-Fa-f]{2})*", text):
        fields.fault("data", word("send.bad-data"))
        return b""
    data = bytes.fromhex(text)
    lengths = _FD_LENGTHS if fd else range(9)
    if len(data) not in lengths:
        fields.fault("data", word("send.bad-length", count=len(data), lengths=_shown(fd)))
        return b""
    return data


def _shown(fd: bool) -> str:
    return "0–8, 12, 16, 20, 24, 32, 48, 64" if fd else "0–8"
