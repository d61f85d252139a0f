"""What candump prints on a screen, both directions.

      can0  123   [2]  11 22                                   classic; length in brackets
      can0  12345678   [0]                                     29-bit identifier
      can0  123   [4]  remote request
      can0  123  [08]  11 22 33 44 55 66 77 88                 CAN FD: two digits
      can0  20000080   [8]  00 00 00 00 00 00 00 00   ERRORFRAME
     (1436509052.249713)  can0  123   [0]                      candump -ta
      can0  TX B -  123  [01]  11                              candump -x: direction, BRS, ESI
      can0       123   [1]  41                        'A'      -a, indented behind 29-bit ones
      can0  123   {9}  11 22 33 44 55 66 77 88                 candump -8: raw data length code
      can0  123   [2]  22`11                                   candump -S: the last byte first

What the line does not show is not kept: BRS and ESI of an FD frame without a direction, the raw
data length code without -8, the time without -ta. Binary data (-i) are not read.

Source: linux-can/can-utils lib.c and candump.c; compared with log2long in the tests.
"""

from __future__ import annotations

import re

from canwire.errors import BadFrame, BadText
from canwire.values.checks import instance, whole
from canwire.values.error_frame import ERROR_FLAG, decode_error_frame, encode_error_frame
from canwire.values.event import BusEvent
from canwire.values.frame import Frame
from canwire.values.text import LogLine, parse_time

_SWAPPED = "`"
_WIDEST = 1000  # of an interface name
_LINE = re.compile(
    r"\s*(?:\((?P<seconds>\d{1,20})\.(?P<decimals>\d{1,9})\)\s+)?(?P<interface>[^\s()]+)\s+"
    r"(?:(?P<direction>[RT])X (?P<brs>[B-]) (?P<esi>[E-])\s+)?"
    r"(?P<id>[0-9A-Fa-f]{8}|[0-9A-Fa-f]{3})\s+"
    r"(?:\[(?P<length>\d{1,2})\]|\{(?P<code>[0-9A-Fa-f])\})"
    r"(?P<remote>\s+remote request)?"
    r"(?: {1,2}(?P<swapped>[0-9A-Fa-f]{2}(?:`[0-9A-Fa-f]{2})+)(?![^\s])|(?P<data>(?: {1,2}[0-9A-Fa-f]{2}(?![^\s]))*))"
    r"(?P<rest>\s*(?:ERRORFRAME|'.{0,8}'|`.{0,8}`)?)\s*",
    re.ASCII,
)


def format_candump_line(
    line: LogLine,
    *,
    timestamp: bool = False,
    indent: bool = False,
    ascii: bool = False,
    raw_dlc: bool = False,
    swap: bool = False,
    width: int = 0,
) -> str:
    """The line as candump prints it on a screen, without the line end.

    `timestamp` puts the time before it (-ta); `indent` moves 11-bit identifiers right, as candump
    does once a 29-bit one was seen; `ascii` adds the data as characters (-a); `raw_dlc` shows the
    raw data length code (-8); `swap` shows the last byte first, with other marks (-S); `width` pads the
    interface name on the left. A direction in the line is shown as -x does.
    """
    instance("line", line, LogLine)
    whole("width", width, 0, _WIDEST)
    stamp = ""
    if timestamp:
        micros = line.timestamp_ns // 1000
        stamp = f"({micros // 1_000_000:010d}.{micros % 1_000_000:06d}) "
    content = line.content
    if isinstance(content, Frame):
        body = _frame_body(content, indent, raw_dlc, ascii, swap)
    else:
        id, data = encode_error_frame(content)
        body = f"{id:08X}   [8] {_spaced(data, swap)}   ERRORFRAME"
    return f" {stamp} {line.interface:>{width}}{_direction(line)}  {body}"


def parse_candump_line(text: str) -> LogLine:
    """A screen line of candump, line end included or not; raises BadText saying what is wrong."""
    match = _LINE.fullmatch(text)
    shown = repr(text if len(text) <= 120 else text[:117] + "...")
    if match is None:
        raise BadText(f"{shown} is no line of candump: interface, identifier, [length], data bytes")
    try:
        timestamp_ns = parse_time(match["seconds"], match["decimals"]) if match["seconds"] else 0
        content = _content(match, timestamp_ns)
    except (BadFrame, BadText) as error:
        raise BadText(f"{shown}: {error}") from None
    return LogLine(timestamp_ns, match["interface"], content, match["direction"])


def _frame_body(frame: Frame, indent: bool, raw_dlc: bool, ascii: bool, swap: bool) -> str:
    if frame.extended:
        id = f"{frame.id:08X}"
    else:
        id = f"     {frame.id:03X}" if indent else f"{frame.id:03X}"
    data = frame.data
    if frame.fd:
        length = f"[{len(data):02d}]"
    elif raw_dlc:
        length = f" {{{frame.dlc:X}}}"
    else:
        length = f" [{min(frame.dlc, 8)}]"
    if frame.remote:
        return f"{id}  {length}  remote request"
    shown = f"{id}  {length} {_spaced(data, swap)}"
    if not ascii or len(data) > 8:
        return shown
    characters = "".join(chr(byte) if 0x1F < byte < 0x7F else "." for byte in (data[::-1] if swap else data))
    mark = _SWAPPED if swap else "'"
    return f"{shown}{'   ' * (8 - len(data))}   {mark}{characters}{mark}"


def _spaced(data: bytes, swap: bool) -> str:
    """` 11 22`: a space before every byte; swapped: ` 22`11`."""
    if swap:
        return " " + data[::-1].hex(_SWAPPED).upper() if data else ""
    return " " + data.hex(" ").upper() if data else ""


def _direction(line: LogLine) -> str:
    if line.direction is None:
        return ""
    frame = line.content
    brs = "B" if isinstance(frame, Frame) and frame.bit_rate_switch else "-"
    esi = "E" if isinstance(frame, Frame) and frame.error_state_indicator else "-"
    return f"  {line.direction}X {brs} {esi}"


def _content(match: re.Match[str], timestamp_ns: int) -> Frame | BusEvent:
    id = int(match["id"], 16)
    extended = len(match["id"]) == 8
    data = bytes.fromhex((match["swapped"] or "").replace(_SWAPPED, ""))[::-1] or bytes.fromhex(
        match["data"] or ""
    )
    if extended and id & ERROR_FLAG:
        return decode_error_frame(id, data, timestamp_ns)
    code = int(match["code"], 16) if match["code"] else int(match["length"])
    if match["remote"]:
        return Frame(id, extended=extended, remote=True, dlc=code, timestamp_ns=timestamp_ns)
    if match["code"]:
        return Frame(id, data, extended=extended, dlc=code, timestamp_ns=timestamp_ns)
    if code != len(data):
        raise BadText(f"[{match['length']}], but {len(data)} data bytes")
    return Frame(
        id,
        data,
        extended=extended,
        fd=len(match["length"]) == 2,
        bit_rate_switch=match["brs"] == "B",
        error_state_indicator=match["esi"] == "E",
        timestamp_ns=timestamp_ns,
    )
