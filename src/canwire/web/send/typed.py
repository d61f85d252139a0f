"""A row of the list as it was typed: every fault at its field."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from canwire import BadFrame, Frame
from canwire.web.send.transmit_list import Row

if TYPE_CHECKING:
    from canwire.web.fields import Fields
    from canwire.web.words import Words

SLOWEST_MS = 3_600_000
_FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


def typed_row(fields: Fields, word: Words) -> Row:
    """Fields: number (0: a new one), line, format, id, data or dlc, cycle, most, key, comment. Raises BadFields."""
    number = fields.whole("number", 0, 1_000_000) if fields.text("number") else 0
    line = fields.text("line", longest=80, empty=False)
    cycle_ms = fields.real("cycle", 1, SLOWEST_MS) if fields.text("cycle") not in ("", "0") else 0.0
    most = fields.whole("most", 0, 1_000_000_000) if fields.text("most") else 0
    key = fields.text("key", longest=1).lower()
    if key and not re.fullmatch(r"[a-z0-9]", key):
        fields.fault("key", word("send.bad-key"))
    comment = fields.text("comment")
    frame = _typed_frame(fields, word)
    fields.check()
    return Row(number, line, frame, cycle_ms, key, most, comment)


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
