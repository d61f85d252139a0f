"""A line of JSON for each frame and event, for programs that read what `canwire dump` prints."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from canwire import BusEvent, Frame, LogLine
from canwire.commands.dump.words import in_words

if TYPE_CHECKING:
    from canwire import DecodedMessage


def format_json(line: LogLine, message: DecodedMessage | None = None) -> str:
    """`time_s` is in seconds since 1970; data and identifiers are hex. `message` is what a database says of it."""
    content = line.content
    found: dict[str, Any] = {"time_s": line.timestamp_ns / 1e9, "line": line.interface}
    found |= _frame(content) if isinstance(content, Frame) else _event(content)
    if message is not None:
        found |= {"message": message.name, "signals": dict(message.signals)}
    return json.dumps(found)


def _frame(frame: Frame) -> dict[str, Any]:
    found: dict[str, Any] = {"id": f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}"}
    if frame.remote:
        found |= {"remote": True, "dlc": frame.dlc}
    else:
        found |= {"data": frame.data.hex().upper(), "dlc": frame.dlc}
    if frame.fd:
        found |= {"fd": True, "bit_rate_switch": frame.bit_rate_switch, "esi": frame.error_state_indicator}
    return found


def _event(event: BusEvent) -> dict[str, Any]:
    found: dict[str, Any] = {"event": event.kind.name.lower(), "state": event.state.name.lower()}
    if event.error:
        found |= {"error": event.error.name.lower(), "transmitting": event.transmitting}
    if event.bit >= 0:
        found["bit"] = event.bit
    return {**found, "tec": event.tec, "rec": event.rec, "text": in_words(event)}
