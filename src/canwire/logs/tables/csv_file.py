"""CSV, a row for an entry (columns.py); read are python-can's and GVRET's (SavvyCAN's) as well."""

from __future__ import annotations

import base64
import csv
import io
from collections.abc import Callable, Iterator
from itertools import islice
from typing import TYPE_CHECKING, ClassVar

from canwire.errors import BadFrame, BadText
from canwire.logs.batch import LogBatch
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.form import FormWriter
from canwire.logs.source import Source
from canwire.logs.tables.columns import FLAGS, Row, rows_of
from canwire.values.error_frame import decode_error_frame
from canwire.values.frame import Frame
from canwire.values.text import parse_time

if TYPE_CHECKING:
    import numpy

_HEADER = "time_s,channel,direction,type,id,extended,remote,fd,brs,esi,dlc,data,detail"
_PYTHON_CAN = "timestamp,arbitration_id,extended,remote,error,dlc,data"
_GVRET = "Time Stamp,ID,Extended,"
_AT_ONCE = 20_000
_PIECE = 4096


class Writer(FormWriter):
    """Rows below a header line."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)

    def begin(self) -> None:
        self.out(f"{_HEADER}\n".encode())

    def put(self, records: numpy.ndarray) -> None:
        for at in range(0, len(records), _PIECE):
            rows = rows_of(records[at : at + _PIECE], self.channels)
            self.out("".join(map(_line, rows)).encode(), len(rows))


def recognises(head: bytes) -> bool:
    """By the header line."""
    return head.decode("utf-8", "replace").lstrip("\ufeff").startswith((_HEADER, _PYTHON_CAN, _GVRET))


def read(source: Source) -> Iterator[LogBatch]:
    """Some ten thousand rows at a time; a row that means nothing is a fault."""
    text = io.TextIOWrapper(source.file, "utf-8-sig", errors="replace", newline="")
    try:
        rows = csv.reader(_without_nul(text))
        header = ",".join(next(rows, []))
        parse = _parser(header)
        entries = _entries(source, rows, parse)
        while batch := list(islice(entries, _AT_ONCE)):
            source.infer_date(batch[0].timestamp_ns)
            yield source.batch(batch)
    finally:
        text.detach()


def _without_nul(lines: Iterator[str]) -> Iterator[str]:
    return (line.replace("\0", "\N{REPLACEMENT CHARACTER}") for line in lines)


def _parser(header: str) -> Callable[[list[str]], LogEntry]:
    if header.startswith(_PYTHON_CAN):
        return _of_python_can
    return _of_gvret if header.startswith(_GVRET) else _of_ours


def _entries(
    source: Source, rows: Iterator[list[str]], parse: Callable[[list[str]], LogEntry]
) -> Iterator[LogEntry]:
    number = 1
    while True:
        number += 1
        try:
            row = next(rows)
            if row:
                yield parse(row)
        except StopIteration:
            return
        except (BadFrame, BadText, ValueError, IndexError, csv.Error) as error:
            source.fault(f"line {number}", str(error))


def _line(row: Row) -> str:
    seconds, rest = divmod(row.time_ns, 10**9)
    id = "" if row.id is None else f"{row.id:08X}" if row.extended else f"{row.id:X}"
    detail = '"' + row.detail.replace('"', '""') + '"' if row.detail else ""
    dlc = "" if row.dlc is None else row.dlc
    return (
        f"{seconds}.{rest:09d},{_quoted(row.channel)},{row.direction or ''},{row.type},{id},{row.extended},"
        f"{row.remote},{row.fd},{row.brs},{row.esi},{dlc},{row.data.hex().upper()},{detail}\n"
    )


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(one in text for one in ',"\r\n') else text


def _of_ours(row: list[str]) -> LogEntry:
    time_s, channel, direction, kind, id, *flags, dlc, data, detail = row
    if len(flags) != len(FLAGS):
        raise BadText(f"{len(row)} columns: a row has 13")
    seconds, _, decimals = time_s.partition(".")
    extended, remote, fd, brs, esi = (int(flag or 0) for flag in flags)
    return Row(
        parse_time(seconds, decimals or "0"),
        channel,
        direction or None,
        kind,
        int(id, 16) if id else None,
        extended,
        remote,
        fd,
        brs,
        esi,
        int(dlc) if dlc else None,
        bytes.fromhex(data),
        detail,
    ).entry()


def _of_python_can(row: list[str]) -> LogEntry:
    """timestamp, identifier in hex, flags, data in base 64; it has no channel and no FD."""
    time_s, id, extended, remote, error, dlc, data = row
    time_ns = round(float(time_s) * 1e9)
    content = base64.b64decode(data)
    if error == "1":
        return LogEntry(time_ns, "can0", decode_error_frame(int(id, 16) | 0x2000_0000, content[:8], time_ns))
    is_remote, fd = remote == "1", len(content) > 8
    frame = Frame(
        int(id, 16),
        b"" if is_remote else content,
        extended=extended == "1",
        remote=is_remote,
        fd=fd,
        dlc=None if fd else int(dlc),
        timestamp_ns=time_ns,
    )
    return LogEntry(time_ns, "can0", frame)


def _of_gvret(row: list[str]) -> LogEntry:
    """SavvyCAN's: stamp in microseconds, identifier in hex, true/false, [direction,] bus, length, bytes in hex."""
    directed = row[3].strip() in ("Rx", "Tx")
    direction = {"Rx": "R", "Tx": "T"}.get(row[3].strip())
    bus, length = (int(value) for value in row[3 + directed : 5 + directed])
    begin = 5 + directed
    time_ns = round(float(row[0]) * 1000)
    data = bytes(int(byte, 16) for byte in row[begin : begin + length])
    if len(data) != length:
        raise BadText(f"length {length}, but {len(data)} bytes")
    frame = Frame(
        int(row[1], 16), data, extended=row[2].strip().lower() == "true", fd=length > 8, timestamp_ns=time_ns
    )
    return LogEntry(time_ns, f"can{bus}", frame, direction)
