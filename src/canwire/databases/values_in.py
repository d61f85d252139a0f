"""Completes and checks the values of a message; errors name every wrong value with its range."""

from __future__ import annotations

import math
from collections.abc import Mapping

from canwire.databases.description import MessageDescription, Number, SignalDescription, Value
from canwire.databases.near import near
from canwire.errors import BadSignals

_SLACK = 1e-6  # of one step, for what floating-point arithmetic leaves


def complete(
    message: MessageDescription, given: Mapping[str, Value], fill: Number | None = None
) -> dict[str, Value]:
    """Values of all signals in the frame: those given, else the file's start values, else `fill`.

    A multiplexer that is not given follows from the signals that are. Raises BadSignals.
    """
    known = {name: value for name, value in given.items() if name in message.signals}
    faults = {
        name: f"no such signal; {near(name, message.signals)}"
        for name in given
        if name not in message.signals
    }
    wanted = {**_implied(message, known), **known}
    values: dict[str, Value] = {}
    for signal in message.signals.values():
        if _chosen(message, signal, wanted, values):
            values[signal.name] = _value(signal, wanted, fill, faults)
    _check_multiplexers(message, values, faults)
    for name in known.keys() - values.keys():
        faults.setdefault(name, f"not in the frame: it needs another {message.signals[name].multiplexer}")
    if faults:
        raise BadSignals(message.name, faults)
    return values


def chosen_signals(message: MessageDescription, given: Mapping[str, Value]) -> list[str]:
    """The names of the signals in the frame with these values, or start values, of multiplexers."""
    return [signal.name for signal in message.signals.values() if _chosen(message, signal, given, {})]


def _check_multiplexers(
    message: MessageDescription, values: Mapping[str, Value], faults: dict[str, str]
) -> None:
    """Check the values of multiplexers: a value that the file does not define leaves the frame's contents undefined."""
    for name, ids in message.selectors.items():
        value = values.get(name)
        if name in faults or not isinstance(value, int | float | str):
            continue
        if message.signals[name].raw(value) not in ids:
            faults[name] = f"{value} chooses no signals; {', '.join(map(str, sorted(ids)))} do"


def fault_of(signal: SignalDescription, value: object) -> str:
    """Return why this value is wrong, "" if it is valid."""
    if isinstance(value, str):
        if value in signal.choices.values():
            return ""
        if not signal.choices:
            return f"{value!r} is no number; {signal.range} is possible"
        return f"no value {value!r}; {signal.range} is possible"
    if isinstance(value, list) and isinstance(signal.start, list):
        return ""  # an array of LIN's: the file's own code checks it
    if not isinstance(value, int | float):
        return f"{value!r} is no number; {signal.range} is possible"
    if isinstance(value, float) and not math.isfinite(value):
        return "" if signal.is_float else f"{value} is no value; {signal.range} is possible"
    slack = abs(signal.scale) * _SLACK
    if signal.minimum - slack <= value <= signal.maximum + slack:
        return ""
    if not signal.is_float and signal.raw(value) in signal.choices:
        return ""
    return f"{value:.10g} is out of range: {signal.range}"


def _value(
    signal: SignalDescription,
    given: Mapping[str, Value],
    fill: Number | None,
    faults: dict[str, str],
) -> Value:
    if signal.name in given:
        fault = fault_of(signal, given[signal.name])
        if fault:
            faults[signal.name] = fault
        return given[signal.name]
    value = fill if signal.start is None else signal.start
    if value is None:
        faults[signal.name] = f"no value given, and the file has no start value; {signal.range} is possible"
        return 0
    return _nearest(signal, value)


def _nearest(signal: SignalDescription, value: Value) -> Value:
    """Return a start value or `fill`, limited to the signal's range if it is outside."""
    if isinstance(value, int | float) and not fault_of(signal, value):
        return value
    if isinstance(value, int | float):
        return min(max(value, signal.minimum), signal.maximum)
    return value


def _implied(message: MessageDescription, given: Mapping[str, Value]) -> dict[str, Value]:
    """Return the multiplexers for which the given signals leave only one possible value."""
    possible: dict[str, set[int]] = {}
    for name in given:
        signal = message.signals[name]
        while signal.multiplexer:
            ids = set(signal.multiplexer_ids)
            possible[signal.multiplexer] = possible.get(signal.multiplexer, ids) & ids
            signal = message.signals[signal.multiplexer]
    return {
        name: next(iter(ids)) * message.signals[name].scale + message.signals[name].offset
        for name, ids in possible.items()
        if len(ids) == 1
    }


def _chosen(
    message: MessageDescription,
    signal: SignalDescription,
    wanted: Mapping[str, Value],
    values: dict[str, Value],
) -> bool:
    """Whether the signal is in the frame, by the values of its multiplexers."""
    if not signal.multiplexer:
        return True
    decides = message.signals[signal.multiplexer]
    value = values.get(decides.name, wanted.get(decides.name, decides.start))
    if not isinstance(value, int | float | str) or fault_of(decides, value):
        return False
    return decides.raw(value) in signal.multiplexer_ids and _chosen(message, decides, wanted, values)
