"""The details of one row: its content, its signals, and its bits on the wire."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from canwire import (
    BadFrame,
    BusEvent,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    LinErrorKind,
    LinEvent,
    LinEventKind,
    LinFrame,
    format_frame,
    format_lin_frame,
    frame_of_record,
)
from canwire.web.fields import BadFields
from canwire.web.trace.drawing import BITS, HEIGHT, WIDTH, Bit, Row, bits_of, rows_of
from canwire.web.trace.store.lin import is_lin, lin_message
from canwire.web.trace.store.rows import GAP, GONE, LOST, UNHEARD

if TYPE_CHECKING:
    from canwire.web.database import Database, Signal
    from canwire.web.words import Words

RECORD_BYTES = 80
_MARKS = {GAP: "trace.gap", LOST: "trace.lost-row", UNHEARD: "trace.unheard", GONE: "trace.gone-row"}
_INFO_AT, _DATA_AT = 12, 16
_EVENTS = {
    EventKind.STATE: "trace.state-change",
    EventKind.ARBITRATION_LOST: "trace.arbitration-lost",
    EventKind.OVERRUN: "trace.overrun",
}
_LIN_EVENTS = {
    LinEventKind.STATE: "trace.state-change",
    LinEventKind.WAKEUP: "trace.wake-up",
    LinEventKind.SLEEP: "trace.go-to-sleep",
}
_ERRORS = {
    ErrorKind.STUFF: "trace.error-stuff",
    ErrorKind.FORM: "trace.error-form",
    ErrorKind.ACK: "trace.error-ack",
    ErrorKind.BIT: "trace.error-bit",
    ErrorKind.FAST_DATA_BIT: "trace.error-fast-bit",
    ErrorKind.CRC: "trace.error-crc",
    ErrorKind.DLC: "trace.error-dlc",
}


@dataclass
class Details:
    """The values for details.jinja: facts as pairs of words, the drawing's rows, and for an error its place."""

    title: str
    facts: list[tuple[str, str]]
    signals: list[Signal] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    note: str = ""
    bits, width, height = BITS, WIDTH, HEIGHT


def details_of(record: str, following: str, database: Database, word: Words) -> Details:
    """Return the details of a record in hex; for an error `following` is the repeated frame. Raises BadFields."""
    content = _content(record, word)
    if isinstance(content, Frame):
        return _frame_details(content, database, word)
    if isinstance(content, LinFrame):
        return _lin_frame_details(content, database, word)
    if isinstance(content, LinEvent):
        return _lin_event_details(content, word)
    if isinstance(content, int):
        raw = int.from_bytes(bytes.fromhex(record)[_DATA_AT : _DATA_AT + 8], "little")
        name = _MARKS[content]
        return Details(word(name, count=raw, seconds=word.decimal(raw / 1000, 1)), [])
    repeated = _content(following, word) if following else None
    return _event_details(content, repeated if isinstance(repeated, Frame) else None, word)


def _time(content: Frame | BusEvent | LinFrame | LinEvent, word: Words) -> str:
    return f"{word.decimal(content.timestamp_ns / 1e9, 6)} s"


def _content(record: str, word: Words) -> Frame | BusEvent | LinFrame | LinEvent | int:
    try:
        octets = bytes.fromhex(record)
        if len(octets) != RECORD_BYTES:
            raise ValueError
        kind = octets[_INFO_AT]
        if kind in _MARKS:
            return kind
        if is_lin(kind):
            return lin_message(octets)
        return BusEvent.from_record(octets) if kind else frame_of_record(octets)
    except (ValueError, BadFrame):
        raise BadFields({"record": word("trace.no-record")}) from None


def _frame_details(frame: Frame, database: Database, word: Words) -> Details:
    kind = "fd" if frame.fd else "remote" if frame.remote else "classic"
    flags = [
        name
        for name, there in (("BRS", frame.bit_rate_switch), ("ESI", frame.error_state_indicator))
        if there
    ]
    bits = bits_of(frame)
    facts = [
        (word("trace.time"), _time(frame, word)),
        (word("trace.format"), ", ".join([word(f"trace.format-{kind}"), *flags])),
        (word("trace.id"), f"{frame.id:X} ({29 if frame.extended else 11} bit)"),
        ("DLC", f"{frame.dlc}"),
        (word("trace.text"), format_frame(frame)),
        (word("trace.on-the-wire"), word("trace.bit-count", bits=len(bits), stuff=_stuffed(bits))),
    ]
    name = database.name_of(frame)
    return Details(name or format_frame(frame), facts, database.signals(frame), rows_of(bits))


def _stuffed(bits: list[Bit]) -> int:
    return sum(bit.kind == "stuff" for bit in bits)


def _event_details(event: BusEvent, repeated: Frame | None, word: Words) -> Details:
    facts = [
        (word("trace.time"), _time(event, word)),
        (word("trace.seen-by"), word("trace.sender" if event.transmitting else "trace.receiver")),
        ("TEC / REC", f"{event.tec} / {event.rec}"),
        (word("trace.state"), word(f"boards.state-{ErrorState(event.state).name.lower().replace('_', '-')}")),
    ]
    if event.bit >= 0:
        facts.append((word("trace.at-bit"), str(event.bit)))
    if event.kind != EventKind.ERROR:
        return Details(word(_EVENTS.get(EventKind(event.kind), "trace.event")), facts)
    details = Details(word(_ERRORS.get(ErrorKind(event.error), "trace.error-other")), facts)
    if repeated is not None and event.bit >= 0:
        details.rows = rows_of(bits_of(repeated, event.bit))
        details.note = word("trace.repeated-note", frame=format_frame(repeated))
    return details


def _lin_frame_details(frame: LinFrame, database: Database, word: Words) -> Details:
    model = word("trace.enhanced" if frame.enhanced else "trace.classic")
    facts = [
        (word("trace.time"), _time(frame, word)),
        (word("trace.format"), word("trace.format-header" if frame.header_only else "trace.format-lin")),
        (word("trace.id"), f"{frame.id:02X} (PID {frame.pid:02X})"),
        (word("trace.length"), f"{frame.length}"),
        (word("trace.text"), format_lin_frame(frame)),
    ]
    if not frame.header_only:
        facts.append((word("trace.checksum"), f"{frame.checksum:02X} ({model})"))
    return Details(database.name_of(frame) or format_lin_frame(frame), facts, database.signals(frame))


def _lin_event_details(event: LinEvent, word: Words) -> Details:
    facts = [
        (word("trace.time"), _time(event, word)),
        (word("trace.state"), word(f"boards.state-lin-{event.state.name.lower()}")),
    ]
    if event.id >= 0:
        facts.append((word("trace.id"), f"{event.id:02X}"))
    if event.kind != LinEventKind.ERROR:
        return Details(word(_LIN_EVENTS.get(LinEventKind(event.kind), "trace.event")), facts)
    facts.insert(1, (word("trace.seen-by"), word("trace.sender" if event.transmitting else "trace.receiver")))
    return Details(word(f"trace.lin-error-{LinErrorKind(event.error).name.lower()}"), facts)
