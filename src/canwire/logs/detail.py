"""Fields of an event, a LIN frame or a mark that have no column in a table, as one JSON object.

{"kind": "ERROR", "error": "STUFF", "bit": 12}: fields with default values are left out, enumerations are names.
An unusual LIN frame has {"enhanced": false} or {"header_only": true, "length": 4}.
"""

from __future__ import annotations

import json
from dataclasses import MISSING, fields
from enum import IntEnum
from typing import Any

from canwire.errors import BadText, BadValue
from canwire.logs.entry import Content, LogKind, LogMark, MarkKind
from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind
from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind, LinState
from canwire.values.lin.frame import LinFrame

_NAMED: dict[type, dict[str, type[IntEnum]]] = {
    BusEvent: {"kind": EventKind, "error": ErrorKind, "state": ErrorState},
    LinEvent: {"kind": LinEventKind, "error": LinErrorKind, "state": LinState},
    LogMark: {"kind": MarkKind},
}
_CLASSES = {LogKind.CAN_EVENT: BusEvent, LogKind.LIN_EVENT: LinEvent, LogKind.MARK: LogMark}


def detail_of(content: Content) -> str:
    """The fields as JSON; "" for a CAN frame, and for a LIN frame with default values."""
    if isinstance(content, BusEvent | LinEvent | LogMark):
        return json.dumps(_told(content), separators=(",", ":"))
    if not isinstance(content, LinFrame):
        return ""
    told: dict[str, Any] = {}
    if content.enhanced != LinFrame(content.id).enhanced:
        told["enhanced"] = content.enhanced
    if content.header_only:
        told |= {"header_only": True, "length": content.length}
    return json.dumps(told, separators=(",", ":")) if told else ""


def content_of_detail(kind: LogKind, text: str, timestamp_ns: int) -> BusEvent | LinEvent | LogMark:
    """An event or a mark from its JSON; raises BadText for invalid JSON."""
    wanted = _CLASSES[kind]
    try:
        told = _object(text)
        for name, named in _NAMED[wanted].items():
            if name in told:
                told[name] = named[told[name]]
        found: BusEvent | LinEvent | LogMark = wanted(**told, timestamp_ns=timestamp_ns)
    except (KeyError, TypeError, BadValue, ValueError) as error:
        raise BadText(f"detail {text[:120]!r}: {error}") from None
    return found


def lin_frame_of_detail(text: str, id: int, data: bytes, timestamp_ns: int, sent: bool) -> LinFrame:
    """A LIN frame from its columns; raises BadText for invalid JSON, BadFrame for invalid values."""
    told = _object(text) if text else {}
    known = {"enhanced", "header_only", "length"}
    if set(told) - known:
        raise BadText(f"detail {text[:120]!r}: a LIN frame has {', '.join(sorted(known))}")
    content = b"" if told.get("header_only") else data
    try:
        return LinFrame(id, content, timestamp_ns=timestamp_ns, sent=sent, **told)
    except TypeError as error:
        raise BadText(f"detail {text[:120]!r}: {error}") from None


def _told(content: Any) -> dict[str, Any]:
    told = {}
    for field in fields(content):
        value = getattr(content, field.name)
        if field.name != "timestamp_ns" and (field.default is MISSING or value != field.default):
            told[field.name] = value.name if isinstance(value, IntEnum) else value
    return told


def _object(text: str) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadText(f"detail {text[:120]!r}: {error}") from None
    if not isinstance(found, dict):
        raise BadText(f"detail {text[:120]!r}: no JSON object")
    return found
