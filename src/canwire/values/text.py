"""The one text form of frames, log lines and screen lines: candump's, both directions.

    123#1122                11-bit identifier, two data bytes
    12345678#               29-bit identifier (eight digits), no data; 00000123# is extended too
    123#11.22.33            dots between bytes are read, never written
    123#R   123#R4          remote frame, asking for no data, for four bytes
    123#1122334455667788_9  eight bytes with the raw data length code 9; 123#R8_9: a remote frame with it
    123##1AABB              CAN FD; the digit's bit 0 is BRS, bit 1 ESI. Bit 2 (FDF, which newer
                            candumps write) is read and never written; FD data of a length that
                            does not exist is padded with zeros to the next, as cansend does
    20000040#00...          error frame: see error_frame.py

    (1436509052.249713) can0 123#1122                log line, candump -L
    (1436509052.249713) can0 123#1122 T              log line with its direction, candump -L -x
      can0  123   [2]  11 22                         screen line, candump

Times have microseconds on output; finer parts are cut. Input may have 1 to 9 decimals. A parser
raises BadText, which says what is wrong with which text, and nothing else.

Source: linux-can/can-utils lib.h, lib.c, candump.c; compared with log2long in the tests.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from canwire.errors import BadFrame, BadText
from canwire.values.checks import instance
from canwire.values.dlc import FD_LENGTHS, length_to_dlc
from canwire.values.error_frame import ERROR_FLAG, decode_error_frame, encode_error_frame
from canwire.values.event import BusEvent
from canwire.values.frame import Frame

_HEX_ID = r"([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})"
_FRAME = re.compile(
    _HEX_ID + r"#(?:"
    r"(?P<remote>[Rr])(?P<asked>[0-8])?(?:_(?P<asked_code>[0-9A-Fa-f]))?"
    r"|(?:#(?P<flags>[0-9A-Fa-f]))?(?P<data>(?:\.?[0-9A-Fa-f]{2})*)\.?(?:_(?P<code>[0-9A-Fa-f]))?"
    r")",
    re.ASCII,
)
# The lines that logs are made of, in one match: classic data frames with a time in microseconds.
_PLAIN_LINE = re.compile(
    r"\((\d{1,10})\.(\d{6})\) +([^\s()]+) +" + _HEX_ID + r"#((?:[0-9A-Fa-f]{2}){0,8})(?: ([RT]))?\s*",
    re.ASCII,
)
_LINE = re.compile(r"\( *(\d{1,20})\.(\d{1,9})\)\s+([^\s()]+)\s+(\S+)(?:\s+([RT]))?\s*", re.ASCII)
_UPPER_HEX = "0123456789ABCDEF"


class LogLine(NamedTuple):
    """One line of a log: when (ns since the epoch, or since the log's own zero), where, what.

    `direction` is "R" (received), "T" (transmitted) or None where the log does not say. The
    content carries the same time.
    """

    timestamp_ns: int
    interface: str
    content: Frame | BusEvent
    direction: str | None = None

    @property
    def frame(self) -> Frame | None:
        """The frame; None for an error frame's line, whose `content` is a BusEvent."""
        return self.content if isinstance(self.content, Frame) else None


def parse_frame(text: str) -> Frame:
    """The frame that a text like `123#11.22` describes; raises BadText."""
    instance("text", text, str)
    content = parse_content(text)
    if isinstance(content, Frame):
        return content
    raise BadText(f"{_shown(text)} is an error frame, not a frame that can be sent")


def parse_content(text: str, timestamp_ns: int = 0) -> Frame | BusEvent:
    """The frame or, for an error frame, the event that a text describes; raises BadText."""
    match = _FRAME.fullmatch(text)
    if match is None:
        raise BadText(_complaint(text))
    id = int(match[1], 16)
    try:
        if len(match[1]) == 8 and id & ERROR_FLAG:
            return _error_event(id, match, timestamp_ns)
        return _frame(id, match, timestamp_ns)
    except (BadFrame, BadText) as error:
        raise BadText(f"{_shown(text)}: {_in_text(error, match[1])}") from None


def _in_text(error: BadFrame | BadText, id: str) -> str:
    """The error message, with a remedy for texts, which have no arguments such as extended=True."""
    if len(id) == 3 and int(id, 16) > 0x7FF:
        return f"identifier {id} needs more than 11 bits (000 to 7FF); write 8 hex digits for a 29-bit one: {id:0>8}"
    return str(error)


def format_frame(frame: Frame) -> str:
    """The text form; upper-case hex, no dots."""
    instance("frame", frame, Frame)
    head = f"{frame.id:08X}#" if frame.extended else f"{frame.id:03X}#"
    data = frame.data
    dlc = frame.dlc
    if dlc == len(data) and not frame.fd and not frame.remote:
        return head + data.hex().upper()
    if frame.fd:
        return f"{head}#{frame.bit_rate_switch | frame.error_state_indicator << 1}{data.hex().upper()}"
    code = f"_{_UPPER_HEX[dlc]}" if dlc > 8 else ""
    if frame.remote:
        return f"{head}R{min(dlc, 8)}{code}" if dlc else head + "R"
    return head + data.hex().upper() + code


def format_content(content: Frame | BusEvent) -> str:
    """The text form of a frame, or of an event as an error frame."""
    if isinstance(content, Frame):
        return format_frame(content)
    id, data = encode_error_frame(content)
    return f"{id:08X}#{data.hex().upper()}"


def parse_log_line(line: str) -> LogLine:
    """A line of `candump -L` or `-l`, line end included or not; raises BadText."""
    match = _PLAIN_LINE.fullmatch(line)
    if match is None:
        return _parse_any_log_line(line)
    seconds, micros, interface, id_text, data, direction = match.groups()
    timestamp_ns = int(seconds + micros) * 1000
    extended = len(id_text) == 8
    try:
        frame = Frame(int(id_text, 16), bytes.fromhex(data), extended=extended, timestamp_ns=timestamp_ns)
    except BadFrame:  # an error frame, or more than 29 bits
        return _parse_any_log_line(line)
    return LogLine(timestamp_ns, interface, frame, direction)


def format_log_line(line: LogLine) -> str:
    """The line as `candump -L` prints it, without the line end; with -x where a direction is known."""
    instance("line", line, LogLine)
    timestamp_ns, interface, content, direction = line
    micros = str(timestamp_ns // 1000).zfill(16)  # ten digits of seconds at least
    text = format_frame(content) if isinstance(content, Frame) else format_content(content)
    if direction is None:
        return f"({micros[:-6]}.{micros[-6:]}) {interface} {text}"
    return f"({micros[:-6]}.{micros[-6:]}) {interface} {text} {direction}"


def parse_time(seconds: str, decimals: str) -> int:
    """Nanoseconds of `seconds.decimals` (1 to 9 decimals); raises BadText beyond 64 bits."""
    timestamp_ns = int(seconds) * 1_000_000_000 + int(decimals.ljust(9, "0"))
    if timestamp_ns >> 64:
        raise BadText(f"time {seconds}.{decimals}: nanoseconds need more than 64 bits")
    return timestamp_ns


def _parse_any_log_line(line: str) -> LogLine:
    match = _LINE.fullmatch(line)
    if match is None:
        raise BadText(
            f"{_shown(line)} is no log line; expected: (seconds.decimals) interface frame, and perhaps R or T"
        )
    seconds, decimals, interface, text, direction = match.groups()
    timestamp_ns = parse_time(seconds, decimals)
    return LogLine(timestamp_ns, interface, parse_content(text, timestamp_ns), direction)


def _frame(id: int, match: re.Match[str], timestamp_ns: int) -> Frame:
    extended = len(match[1]) == 8
    if match["remote"]:
        dlc = int(match["asked"] or "0")
        if match["asked_code"]:
            dlc = _raw_code(match["asked_code"], dlc)
        return Frame(id, extended=extended, remote=True, dlc=dlc, timestamp_ns=timestamp_ns)
    data = bytes.fromhex(match["data"].replace(".", ""))
    if match["flags"]:
        return _fd_frame(id, match, data, timestamp_ns)
    code = _raw_code(match["code"], len(data)) if match["code"] else None
    return Frame(id, data, extended=extended, dlc=code, timestamp_ns=timestamp_ns)


def _fd_frame(id: int, match: re.Match[str], data: bytes, timestamp_ns: int) -> Frame:
    if match["code"]:
        raise BadText("a raw data length code after _ is for classic frames")
    if len(data) < 64:
        data = data.ljust(FD_LENGTHS[length_to_dlc(len(data))], b"\0")
    flags = int(match["flags"], 16)
    return Frame(
        id,
        data,
        extended=len(match[1]) == 8,
        fd=True,
        bit_rate_switch=bool(flags & 1),
        error_state_indicator=bool(flags & 2),
        timestamp_ns=timestamp_ns,
    )


def _error_event(id: int, match: re.Match[str], timestamp_ns: int) -> BusEvent:
    if match["remote"] or match["flags"] or match["code"]:
        raise BadText("an error frame carries up to 8 data bytes and nothing else")
    return decode_error_frame(id, bytes.fromhex(match["data"].replace(".", "")), timestamp_ns)


def _raw_code(digit: str, length: int) -> int:
    code = int(digit, 16)
    if code <= 8 or length != 8:
        raise BadText(f"_{digit}: a raw data length code is _9 to _F, after 8 bytes")
    return code


def _complaint(text: str) -> str:
    """The reason why a text is no frame."""
    shown = _shown(text)
    head, hash_, rest = text.partition("#")
    if not hash_:
        return f"{shown} has no #: a frame looks like 123#1122, 12345678#1122, 123#R4 or 123##1AABB"
    if not re.fullmatch(_HEX_ID, head, re.ASCII):
        return f"{shown}: identifier {_shown(head)} must have 3 hex digits, or 8 for a 29-bit one"
    if rest[:1] in ("R", "r"):
        return f"{shown}: after R comes nothing, a length from 0 to 8, or 8_9 to 8_F"
    if rest[:1] == "#" and not re.match(r"[0-9A-Fa-f]", rest[1:]):
        return f"{shown}: ## needs a digit of flags after it: bit 0 BRS, bit 1 ESI"
    return f"{shown}: data {_shown(rest.lstrip('#'))} must be pairs of hex digits, a dot between them or not"


def _shown(text: str) -> str:
    """The text for a message, shortened if it is long."""
    return repr(text if len(text) <= 120 else text[:117] + "...")
