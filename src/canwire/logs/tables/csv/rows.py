"""Converts a row of a CSV file of canwire, python-can or GVRET to an entry."""

from __future__ import annotations

import base64
from collections.abc import Callable

from canwire.errors import BadText
from canwire.logs.entry import LogEntry
from canwire.logs.tables.columns import FLAGS, Row
from canwire.values.error_frame import decode_error_frame
from canwire.values.event import BusEvent, ErrorKind, EventKind
from canwire.values.frame import Frame
from canwire.values.text import parse_time

HEADER = "time_s,channel,direction,type,id,extended,remote,fd,brs,esi,dlc,data,detail"
PYTHON_CAN = "timestamp,arbitration_id,extended,remote,error,dlc,data"
GVRET = "Time Stamp,ID,Extended,"
Parse = Callable[[list[str]], LogEntry]


def parser_of(header: str) -> Parse:
    """Return the function that parses rows below this header; canwire's format is the default."""
    if header.startswith(PYTHON_CAN):
        return _of_python_can
    return _of_gvret if header.startswith(GVRET) else row_of_ours


def row_of_ours(row: list[str]) -> LogEntry:
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
    """Parse a row: time stamp, identifier in hex, flags, data in base 64; it contains no channel and no CAN FD."""
    time_s, id, extended, remote, error, dlc, data = row
    time_ns = ns_of_float(time_s)
    content = base64.b64decode(data)
    if error == "1":
        return LogEntry(time_ns, "can0", error_of_python_can(int(id, 16), content, time_ns))
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


_FAR = 1e16  # seconds or microseconds: no stamp that a record holds


def ns_of_float(seconds: str | float) -> int:
    """Convert python-can's time stamp, a float, which for dates since 1970 is exact only to microseconds."""
    value = _finite(seconds)
    return round(value * 1e9) if value < 1e6 else round(value * 1e6) * 1000


def _finite(stamp: str | float) -> float:
    value = float(stamp)
    if not abs(value) < _FAR:
        raise BadText(f"time {stamp!r}: no stamp")
    return value


def error_of_python_can(id: int, data: bytes, time_ns: int) -> BusEvent:
    """Return the event of an error frame; without SocketCAN's error classes, as from most interfaces, its kind is
    OTHER."""
    try:
        return decode_error_frame(id | 0x2000_0000, data[:8], time_ns)
    except BadText:
        return BusEvent(EventKind.ERROR, time_ns, error=ErrorKind.OTHER)


def _of_gvret(row: list[str]) -> LogEntry:
    """Parse SavvyCAN's row: stamp in microseconds, identifier in hex, true/false, [direction,] bus, length, bytes in
    hex."""
    directed = row[3].strip() in ("Rx", "Tx")
    direction = {"Rx": "R", "Tx": "T"}.get(row[3].strip())
    bus, length = (int(value) for value in row[3 + directed : 5 + directed])
    begin = 5 + directed
    time_ns = round(_finite(row[0]) * 1000)
    data = bytes(int(byte, 16) for byte in row[begin : begin + length])
    if len(data) != length:
        raise BadText(f"length {length}, but {len(data)} bytes")
    frame = Frame(
        int(row[1], 16), data, extended=row[2].strip().lower() == "true", fd=length > 8, timestamp_ns=time_ns
    )
    return LogEntry(time_ns, f"can{bus}", frame, direction)
