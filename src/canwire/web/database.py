"""Names and signals of frames by a network description, as far as there is one."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

from canwire import BadDescription, ExtraMissing, Frame


class Signal(NamedTuple):
    """A signal's value for people."""

    name: str
    value: str
    unit: str
    comment: str


class Input(NamedTuple):
    """A signal to be given: what it is before anybody says anything, and what it may be."""

    name: str
    usual: str
    unit: str
    choices: list[str]
    range: str


class BadSignals(Exception):
    """Values that do not fit: for each signal what would."""

    def __init__(self, faults: Mapping[str, str]) -> None:
        super().__init__(", ".join(faults))
        self.faults = dict(faults)


class Database:
    """`path` is a DBC, KCD, SYM or ARXML file, "" for none; raises BadDescription, ExtraMissing when made."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.name = os.path.basename(path)
        self._database: Any = _loaded(path) if path else None

    @cached_property
    def names(self) -> dict[str, str]:
        """Message names by "1A2" or, with eight digits, "000001A2" for a 29-bit identifier."""
        if self._database is None:
            return {}
        return {
            f"{message.frame_id:08X}"
            if message.is_extended_frame
            else f"{message.frame_id:03X}": message.name
            for message in self._database.messages
        }

    def signals(self, frame: Frame) -> list[Signal]:
        """Decoded; none for a frame that the file does not know, or whose data do not fit it."""
        message = self._message(frame)
        if message is None or frame.remote:
            return []
        try:
            values = message.decode(frame.data, decode_choices=True, allow_truncated=True, scaling=True)
        except (ValueError, KeyError):  # no signal could be read, or no such multiplexer
            return []
        return [
            Signal(signal.name, _shown(values[signal.name]), signal.unit or "", signal.comment or "")
            for signal in message.signals
            if signal.name in values
        ]

    def inputs(self, name: str) -> list[Input]:
        """The signals of a message that can be given; none for a message that is not there."""
        message = self._named(name)
        return [] if message is None else [_input(signal) for signal in message.signals]

    def encode(self, name: str, values: Mapping[str, str]) -> Frame:
        """The message's frame with these values, numbers or their names; raises BadSignals for what does not fit."""
        message = self._named(name)
        if message is None:
            raise BadSignals({"message": name})
        numbers: dict[str, Any] = {}
        faults: dict[str, str] = {}
        for signal in message.signals:
            try:
                numbers[signal.name] = _number(signal, values.get(signal.name, "").strip())
            except ValueError:
                faults[signal.name] = _range(signal)
        if faults:
            raise BadSignals(faults)
        data = message.encode(numbers, strict=False)
        return Frame(message.frame_id, data, extended=message.is_extended_frame, fd=message.is_fd)

    def messages(self) -> list[str]:
        """The names of all messages, in their order."""
        return sorted(self.names.values())

    def _message(self, frame: Frame) -> Any:
        if self._database is None:
            return None
        return self._named(self.names.get(f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}", ""))

    def _named(self, name: str) -> Any:
        return self._database.get_message_by_name(name) if name in self.names.values() else None


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _input(signal: Any) -> Input:
    choices = [str(one) for one in (signal.choices or {}).values()]
    low, _ = _limits(signal)
    usual = choices[0] if choices else f"{low if low > 0 else 0:g}"
    return Input(signal.name, usual, signal.unit or "", choices, _range(signal))


def _limits(signal: Any) -> tuple[float, float]:
    """The least and the greatest value: those told, within what the bits can say."""
    bits = signal.length
    raw = (-(1 << bits - 1), (1 << bits - 1) - 1) if signal.is_signed else (0, (1 << bits) - 1)
    ends = sorted(float(signal.raw_to_scaled(one, decode_choices=False)) for one in raw)
    low = ends[0] if signal.minimum is None else max(ends[0], float(signal.minimum))
    high = ends[1] if signal.maximum is None else min(ends[1], float(signal.maximum))
    return (low, high) if low <= high else (ends[0], ends[1])


def _range(signal: Any) -> str:
    low, high = _limits(signal)
    named = ", ".join(str(one) for one in (signal.choices or {}).values())
    return f"{low:g} – {high:g}" + (f", {named}" if named else "")


def _number(signal: Any, text: str) -> Any:
    """A number within the limits, or the name of a value; ValueError for anything else."""
    if text in {str(one) for one in (signal.choices or {}).values()}:
        return text
    number = float(text.replace(",", ".") or "0")
    low, high = _limits(signal)
    if not low <= number <= high:
        raise ValueError(text)
    return number


def _loaded(path: str) -> Any:
    try:
        import cantools
    except ModuleNotFoundError:
        raise ExtraMissing("cantools", "databases") from None
    try:
        return cantools.database.load_file(path)
    except (OSError, ValueError, cantools.Error) as error:
        raise BadDescription(f"--db {path}: {error}") from None
