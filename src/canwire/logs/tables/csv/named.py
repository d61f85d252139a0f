"""CSV of any program, by the names of its columns: `Time;Bus;ID (hex);Extended;DLC;Data`.

An identifier and data are required, in one column or in one for each byte; other known columns are optional.
Identifiers and bytes are hex unless the header says dec. Without a column for the format, an identifier has 29 bits if
it is above 7FF, or has eight digits that do not begin with 00000. Without times all frames are at 0.
"""

from __future__ import annotations

import csv
import re
from datetime import datetime

from canwire.errors import BadText
from canwire.logs.dates import ns_of
from canwire.logs.entry import LogEntry
from canwire.values.frame import Frame

_NAMES = {
    "time": {"time", "timestamp", "timestamps", "t", "abstime", "timeabs", "timerel", "datetime", "date"},
    "id": {"id", "canid", "identifier", "arbitrationid", "messageid", "msgid", "frameid", "pgnid", "address"},
    "extended": {"extended", "ext", "ide", "isextended", "isextendedid", "xtd", "idtype", "format", "frametype"},
    "channel": {"channel", "bus", "ch", "port", "interface", "network", "buschannel", "canchannel"},
    "direction": {"dir", "direction", "rxtx", "txrx"},
    "dlc": {"dlc", "len", "length", "datalength", "size", "bytes", "datalen"},
    "data": {"data", "databytes", "payload", "databyte", "rawdata"},
    "remote": {"remote", "rtr", "isremote", "remoteframe"},
    "fd": {"fd", "fdf", "edl", "isfd", "canfd"},
    "brs": {"brs", "bitrateswitch"},
    "esi": {"esi", "errorstateindicator"},
}  # fmt: skip
_OURS = {"time_s", "type", "detail"}  # what no other program calls its columns, two of them at a time
_BYTE = re.compile(r"(?:d|db|data|byte|b|databyte)(\d+)")
_WORD = re.compile(r"[^a-z0-9]")
_UNITS = {"": 10**9, "s": 10**9, "sec": 10**9, "ms": 10**6, "us": 10**3, "µs": 10**3, "ns": 1}
_NO = {"", "0", "false", "no", "n", "std", "standard", "s", "11", "data", "can20a", "-"}
_TX = {"tx", "t", "transmit", "transmitted", "sent", "out", "1"}


def dialect_of(header: str) -> tuple[str, NamedColumns] | None:
    """Return the separator of cells and the columns that the header names; None for a header of no log."""
    line = header.lstrip("\ufeff").rstrip("\r\n").replace("\0", " ")
    for delimiter in ",;\t":
        try:
            cells = next(csv.reader([line], delimiter=delimiter), [])
        except csv.Error:  # a carriage return within
            return None
        if len(_OURS.intersection(cells)) > 1:
            return None  # damaged, but ours
        columns = NamedColumns(cells)
        if len(cells) > 1 and columns.enough:
            return delimiter, columns
    return None


class NamedColumns:
    """The meaning of each cell in a row."""

    def __init__(self, header: list[str]) -> None:
        self._at: dict[str, int] = {}
        self._bytes: list[int] = []
        self._unit_ns = _UNITS["s"]
        self._decimal: set[str] = set()
        numbered: dict[int, int] = {}
        for at, cell in enumerate(header):
            text = cell.strip().lower()
            told = re.search(r"[(\[](.*?)[)\]]", text)
            inside = told[1].strip() if told else ""
            plain = _WORD.sub("", text[: told.start()] if told else text)
            self._column(at, plain, inside)
            if (found := _BYTE.fullmatch(plain)) and plain not in _NAMES["data"]:
                numbered.setdefault(int(found[1]), at)
        self._bytes = [numbered[number] for number in sorted(numbered)]

    @property
    def enough(self) -> bool:
        """Whether the columns are enough for frames."""
        return "id" in self._at and ("data" in self._at or bool(self._bytes))

    def entry(self, row: list[str]) -> LogEntry:
        """Return the row's frame; raises BadText, BadFrame, ValueError, IndexError."""
        time_ns = self._time(self._cell(row, "time"))
        text = self._cell(row, "id").lower()
        id = self._number("id", text.removesuffix("x").removesuffix("h") or text)
        remote = self._flag(row, "remote") or self._cell(row, "extended").lower() in ("rtr", "remote")
        fd, length = self._flag(row, "fd"), self._cell(row, "dlc")
        data = b"" if remote else self._data(row, int(length) if length else None)
        if length and not remote and not fd and len(data) != int(length):
            raise BadText(f"length {length}, but {len(data)} bytes")
        frame = Frame(
            id,
            data,
            extended=self._extended(row, text, id),
            remote=remote,
            fd=fd or len(data) > 8,
            bit_rate_switch=self._flag(row, "brs"),
            error_state_indicator=self._flag(row, "esi"),
            dlc=int(length or 0) if remote else None,
            timestamp_ns=time_ns,
        )
        return LogEntry(time_ns, self._channel(row), frame, self._direction(row))

    def _column(self, at: int, plain: str, inside: str) -> None:
        """Note the meaning of a column; if several columns have one meaning, the first is used."""
        unit = next(
            (one for one in ("ms", "us", "ns", "sec", "s") if plain in (f"time{one}", f"timestamp{one}")), ""
        )
        if unit:
            plain = "time"
        name = next((name for name, words in _NAMES.items() if plain in words), "")
        if not name or name in self._at:
            return
        self._at[name] = at
        if name == "time":
            self._unit_ns = _UNITS.get(inside or unit, _UNITS["s"])
        if inside in ("dec", "decimal"):
            self._decimal.add(name)

    def _cell(self, row: list[str], name: str) -> str:
        at = self._at.get(name)
        return "" if at is None or at >= len(row) else row[at].strip()

    def _flag(self, row: list[str], name: str) -> bool:
        return self._cell(row, name).lower() not in _NO

    def _number(self, name: str, text: str) -> int:
        return int(text, 10 if name in self._decimal and not text.startswith("0x") else 16)

    def _time(self, text: str) -> int:
        if not text:
            return 0
        try:
            whole, _, part = text.replace(",", ".").partition(".")
            digits = f"{part or '0':0<18}"[:18]
            return int(whole) * self._unit_ns + int(digits) * self._unit_ns // 10**18
        except ValueError:
            return ns_of(datetime.fromisoformat(text))

    def _extended(self, row: list[str], text: str, id: int) -> bool:
        if "extended" in self._at and self._cell(row, "extended").lower() not in (
            "rtr",
            "remote",
            "fd",
            "canfd",
        ):
            return self._flag(row, "extended")
        digits = text.removeprefix("0x")
        return id > 0x7FF or text.endswith("x") or (len(digits) == 8 and not digits.startswith("00000"))

    def _data(self, row: list[str], length: int | None) -> bytes:
        if "data" not in self._at:
            cells = [row[at].strip() for at in self._bytes[:length] if at < len(row)]
            return bytes(self._number("data", cell) for cell in cells if cell)
        text = self._cell(row, "data")
        words = text.replace("-", " ").replace(":", " ").replace("|", " ").split()
        if len(words) == 1 and len(words[0]) > 2 and "data" not in self._decimal:
            return bytes.fromhex(words[0].removeprefix("0x"))
        return bytes(self._number("data", word) for word in words)

    def _channel(self, row: list[str]) -> str:
        text = self._cell(row, "channel")
        return f"can{int(text)}" if text.isdecimal() else text or "can0"

    def _direction(self, row: list[str]) -> str | None:
        text = self._cell(row, "direction").lower()
        return None if not text else "T" if text in _TX else "R"
