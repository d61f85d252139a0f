"""Conditions of `canwire record --start-on` and `--stop-on`.

123, 100-1FF, 123:7FF, ~123    a frame with this identifier, as in `canwire dump --filter`
123#11..F0                     a frame whose data begin with these digits; a dot matches any hex digit
error, state, bus-off          an error frame, any change of the line's state, bus-off
EngineSpeed>3000               a signal's value, with --db; also <, <=, >=, =, !=, and Message.Signal; texts: Gear=R
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import BadValue, BusEvent, ErrorState, EventKind, LinFrame, LogEntry
from canwire.commands.dump.filters import parse_capture

if TYPE_CHECKING:
    from canwire import Database

Condition = Callable[[LogEntry], bool]

_SIGNAL = re.compile(r"(?:(?P<message>\w+)\.)?(?P<signal>\w+) *(?P<compare><=|>=|!=|<|>|=) *(?P<value>\S+)")
_DATA = re.compile(r"(?P<id>~?[0-9A-Fa-f:~-]+)#(?P<data>[0-9A-Fa-f.]*)")
_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "=": operator.eq, "!=": operator.ne,
}  # fmt: skip


def any_of(texts: list[str], option: str, database: Database | None) -> Condition | None:
    """True where one of these conditions holds; None without any. Raises BadValue."""
    conditions = [_parsed(text, option, database) for text in texts]
    if not conditions:
        return None
    return lambda entry: any(condition(entry) for condition in conditions)


def _parsed(text: str, option: str, database: Database | None) -> Condition:
    if text in ("error", "state", "bus-off"):
        return lambda entry: _is_event(entry, text)
    if found := _SIGNAL.fullmatch(text):
        if database is None:
            raise BadValue(f"{option} {text}: signals need the database that describes them: --db FILE")
        return _signal(found, option, database)
    if found := _DATA.fullmatch(text):
        has_id, pattern = _filter(found["id"], option), re.compile(found["data"].upper())
        return lambda entry: has_id(entry) and pattern.match(_data(entry)) is not None
    return _filter(text, option)


def _filter(text: str, option: str) -> Condition:
    try:
        capture = parse_capture([text], [], errors=False)
    except BadValue as error:
        raise BadValue(f"{option}: {str(error).removeprefix('--filter ')}, error, state, bus-off") from None
    return lambda entry: entry.frame is not None and capture.accepts(entry.frame)


def _data(entry: LogEntry) -> str:
    return "" if entry.frame is None else entry.frame.data.hex().upper()


def _is_event(entry: LogEntry, what: str) -> bool:
    event = entry.content
    if not isinstance(event, BusEvent):
        return False
    if what == "bus-off":
        return event.kind is EventKind.STATE and event.state is ErrorState.BUS_OFF
    return event.kind is (EventKind.ERROR if what == "error" else EventKind.STATE)


def _signal(found: re.Match[str], option: str, database: Database) -> Condition:
    """Holds for frames of a message that has the signal, with such a value."""
    names = [found["message"]] if found["message"] else list(database.messages)
    messages = [name for name in names if found["signal"] in database.message(name).signals]
    if not messages:
        raise BadValue(f"{option} {found[0]}: {database.path} has no such signal")
    compare, wanted, name = found["compare"], found["value"], found["signal"]
    number = _number(wanted)
    if number is None and compare not in ("=", "!="):
        raise BadValue(f"{option} {found[0]}: {wanted!r} is a text, which = and != compare")

    def holds(entry: LogEntry) -> bool:
        frame = entry.frame or (entry.content if isinstance(entry.content, LinFrame) else None)
        about = None if frame is None else database.message_of(frame)
        if frame is None or about is None or about.name not in messages:
            return False
        message = database.decode(frame)
        if message is None or name not in message.signals:
            return False  # another page of a multiplexed message
        if number is None:
            return (message.signals[name] == wanted) == (compare == "=")
        value = message.numbers[name]
        return not isinstance(value, list) and _COMPARE[compare](value, number)

    return holds


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
