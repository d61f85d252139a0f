"""The text form of LIN frames, events and log lines, beside candump's for CAN; both directions.

    10#0102                 identifier 0x10 (two hex digits, without parity), two data bytes, enhanced checksum
    10#01.02                dots between bytes are read, never written
    10#0102_C   3E#01_E     the checksum that is unusual there: classic (LIN 1.x), enhanced from 3E on
    3C#00FFFFFFFFFFFFFF     diagnostic frames are classic always and carry no mark
    10#R   10#R4            a header alone, asking for as many bytes as come, for four

    ERROR#CHKSUM@10         an error, with the identifier of its frame where it is known; the kinds are those
                            of LinErrorKind: BIT CHKSUM PARITY SLNORE SYNC NOBUS OTHER WAKEUP
    STATE#ASLEEP            a change of state: OPERATIONAL INITIALISING ASLEEP STOPPED
    INFO#STARTED  WAKEUP#  SLEEP#  TIME_OVERRUN#1

    (1436509052.249713) lin0 10#0102                 log line
    (1436509052.249713) lin0 10#0102 T               with its direction: T, this node sent the response, or R

An identifier of CAN has three hex digits or eight, so a log may hold lines of both. Times have microseconds on
output; finer parts are cut. Input may have 1 to 9 decimals. A parser raises BadText, which says what is wrong with
which text, and nothing else. An event keeps its state only in STATE, and its status bits nowhere.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from canwire.errors import BadFrame, BadText
from canwire.values.checks import instance
from canwire.values.event import InfoCode
from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind, LinState
from canwire.values.lin.frame import MASTER_REQUEST, LinFrame
from canwire.values.text import parse_time

_FRAME = re.compile(
    r"(?P<id>[0-9A-Fa-f]{2})#(?:(?P<header>[Rr])(?P<asked>[0-8])?"
    r"|(?P<data>(?:\.?[0-9A-Fa-f]{2})*)\.?(?:_(?P<model>[CE]))?)",
    re.ASCII,
)
_EVENT = re.compile(r"(?P<kind>[A-Z_]+)#(?P<what>[A-Z]+|\d{1,3})?(?:@(?P<id>[0-9A-Fa-f]{2}))?", re.ASCII)
_LINE = re.compile(r"\((\d{1,20})\.(\d{1,9})\)\s+([^\s()]+)\s+(\S+)(?:\s+([RT]))?\s*", re.ASCII)


class LinLogLine(NamedTuple):
    """One line of a log: when (ns since the epoch, or since the log's own zero), where, what.

    `direction` is "R" (received), "T" (transmitted) or None where the log does not say.
    """

    timestamp_ns: int
    interface: str
    content: LinFrame | LinEvent
    direction: str | None = None

    @property
    def frame(self) -> LinFrame | None:
        """The frame; None for a line about an event, which is the `content` then."""
        return self.content if isinstance(self.content, LinFrame) else None


def parse_lin_frame(text: str) -> LinFrame:
    """The frame that a text like `10#01.02` describes; raises BadText."""
    content = parse_lin_content(text)
    if isinstance(content, LinFrame):
        return content
    raise BadText(f"{_shown(text)} is an event, not a frame that can be sent")


def parse_lin_content(text: str, timestamp_ns: int = 0, *, sent: bool = False) -> LinFrame | LinEvent:
    """The frame or the event that a text describes; raises BadText."""
    match = _FRAME.fullmatch(text)
    try:
        if match is not None:
            return _frame(match, timestamp_ns, sent)
        event = _EVENT.fullmatch(text)
        if event is not None and event["kind"] in LinEventKind.__members__:
            return _event(event, timestamp_ns, sent)
    except (BadFrame, BadText) as error:
        raise BadText(f"{_shown(text)}: {error}") from None
    raise BadText(_complaint(text))


def format_lin_frame(frame: LinFrame) -> str:
    """The text form; upper-case hex, no dots."""
    instance("frame", frame, LinFrame)
    if frame.header_only:
        return f"{frame.id:02X}#R{frame.length or ''}"
    return f"{frame.id:02X}#{frame.data.hex().upper()}{_mark(frame)}"


def format_lin_content(content: LinFrame | LinEvent) -> str:
    """The text form of a frame or an event."""
    if isinstance(content, LinFrame):
        return format_lin_frame(content)
    about = f"@{content.id:02X}" if content.id >= 0 else ""
    return f"{content.kind.name}#{_what(content)}{about}"


def parse_lin_log_line(line: str) -> LinLogLine:
    """A line of a log, line end included or not; raises BadText."""
    match = _LINE.fullmatch(line)
    if match is None:
        raise BadText(
            f"{_shown(line)} is no log line; expected: (seconds.decimals) interface frame, and perhaps R or T"
        )
    seconds, decimals, interface, text, direction = match.groups()
    timestamp_ns = parse_time(seconds, decimals)
    content = parse_lin_content(text, timestamp_ns, sent=direction == "T")
    return LinLogLine(timestamp_ns, interface, content, direction)


def format_lin_log_line(line: LinLogLine) -> str:
    """The line of a log, without the line end; with its direction where that is known."""
    instance("line", line, LinLogLine)
    micros = str(line.timestamp_ns // 1000).zfill(16)  # ten digits of seconds at least
    direction = f" {line.direction}" if line.direction else ""
    return f"({micros[:-6]}.{micros[-6:]}) {line.interface} {format_lin_content(line.content)}{direction}"


def _mark(frame: LinFrame) -> str:
    if frame.enhanced == (frame.id < MASTER_REQUEST):
        return ""
    return "_E" if frame.enhanced else "_C"


def _what(event: LinEvent) -> str:
    if event.kind is LinEventKind.ERROR:
        return event.error.name
    if event.kind is LinEventKind.STATE:
        return event.state.name
    if event.kind is LinEventKind.INFO:
        return InfoCode(event.code).name
    return str(event.code) if event.kind is LinEventKind.TIME_OVERRUN else ""


def _frame(match: re.Match[str], timestamp_ns: int, sent: bool) -> LinFrame:
    id = int(match["id"], 16)
    if match["header"]:
        return LinFrame(
            id, header_only=True, length=int(match["asked"] or 0), timestamp_ns=timestamp_ns, sent=sent
        )
    data = bytes.fromhex(match["data"].replace(".", ""))
    enhanced = {"C": False, "E": True, None: None}[match["model"]]
    return LinFrame(id, data, enhanced=enhanced, timestamp_ns=timestamp_ns, sent=sent)


def _event(match: re.Match[str], timestamp_ns: int, sent: bool) -> LinEvent:
    kind, what = LinEventKind[match["kind"]], match["what"] or ""
    error, state, code = LinErrorKind.NONE, LinState.OPERATIONAL, 0
    try:
        if kind is LinEventKind.ERROR:
            error = LinErrorKind[what]
        elif kind is LinEventKind.STATE:
            state = LinState[what]
        elif kind is LinEventKind.INFO:
            code = InfoCode[what]
        elif kind is LinEventKind.TIME_OVERRUN:
            code = int(what)
        elif what:
            raise KeyError(what)
    except (KeyError, ValueError):
        raise BadText(f"{kind.name} has no {what or 'kind'!r}") from None
    id = int(match["id"], 16) if match["id"] else -1
    if id > 0x3F:
        raise BadText(f"identifier {id:#x}: from 0 to 3F")
    return LinEvent(kind, timestamp_ns, error, state, id, sent, code=code)


def _complaint(text: str) -> str:
    """The reason why a text is no LIN frame."""
    shown = _shown(text)
    head, hash_, rest = text.partition("#")
    if not hash_:
        return f"{shown} has no #: a LIN frame looks like 10#0102, 10#0102_C or 10#R4, an event like ERROR#CHKSUM@10"
    if not re.fullmatch(r"[0-9A-Fa-f]{2}", head, re.ASCII):
        return f"{shown}: {_shown(head)} is neither an identifier of 2 hex digits nor an event"
    if rest[:1] in ("R", "r"):
        return f"{shown}: after R comes nothing, or the number of bytes, 0 to 8"
    return f"{shown}: data {_shown(rest)} must be pairs of hex digits, _C or _E (the checksum) behind them or not"


def _shown(text: str) -> str:
    """The text for a message, cut where it is long."""
    return repr(text if len(text) <= 120 else text[:117] + "...")
