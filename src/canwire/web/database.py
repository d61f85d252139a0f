"""Names and signals of frames, if network descriptions are open: `canwire.Database` for the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadSignals, BadValue, Frame, LinFrame

if TYPE_CHECKING:
    import numpy

    import canwire
    from canwire import MessageDescription, SignalDescription


class Signal(NamedTuple):
    """A signal's value as text for the page."""

    name: str
    value: str
    unit: str
    comment: str


class Input(NamedTuple):
    """A signal that can be entered: its initial value and its possible values."""

    name: str
    usual: str
    unit: str
    choices: list[str]
    range: str
    minimum: float
    maximum: float


class Database:
    """The descriptions of one bus; if several define a message or a frame, the first of them is used."""

    def __init__(self, files: Sequence[canwire.Database] = ()) -> None:
        self._files = tuple(files)

    @cached_property
    def names(self) -> dict[str, str]:
        """Message names by "1A2", with eight digits ("000001A2") for a 29-bit identifier, with two for LIN."""
        return {_key(message): name for name, message in reversed(self._messages.items())}

    def name_of(self, frame: Frame | LinFrame) -> str:
        """Return the name of the frame's message, for J1939 by its parameter group; "" if it is unknown."""
        found = (file.message_of(frame) for file in self._files)
        return next((message.name for message in found if message is not None), "")

    def signals(self, frame: Frame | LinFrame) -> list[Signal]:
        """Decode the frame; returns no signals if no file defines the frame, or if its data do not fit."""
        file = next((one for one in self._files if one.message_of(frame) is not None), None)
        decoded = None if file is None else file.decode(frame)
        if decoded is None:
            return []
        told = decoded.description.signals
        return [
            Signal(name, _shown(value), told[name].unit, told[name].comment)
            for name, value in decoded.signals.items()
        ]

    def number(self, frame: Frame | LinFrame, name: str) -> float | None:
        """Return a signal's physical value; None if the frame does not contain it."""
        decoded = next((one for file in self._files if (one := file.decode(frame)) is not None), None)
        found = None if decoded is None else decoded.numbers.get(name)
        return None if found is None or isinstance(found, list) else float(found)

    def ids_with(self, name: str) -> list[int]:
        """Return the identifiers of the messages with a signal of this name, plus 1 << 31 for 29-bit identifiers."""
        return [
            message.id | (1 << 31 if message.extended else 0)
            for message in self._messages.values()
            if name in message.signals and not message.lin
        ]

    def parsed(self, name: str, text: str) -> float:
        """Parse a typed value of a signal, a number or a text of the file, to its physical value; raises ValueError."""
        for message in self._messages.values():
            if name in message.signals:
                signal = message.signals[name]
                value = signal.parse(_typed(signal, text))
                if isinstance(value, str):
                    raw = next((raw for raw, said in signal.choices.items() if said == value), None)
                    if raw is None:
                        break
                    value = raw * signal.scale + signal.offset
                return float(value)
        raise ValueError(f"{name}: {text}")

    def values_of(self, records: numpy.ndarray, name: str) -> Iterator[tuple[numpy.ndarray, numpy.ndarray]]:
        """Yield, file by file, the places of the CAN records that contain this signal, and its physical values."""
        for file in self._files:
            for columns in file.decode_arrays(records).values():
                if name in columns.signals:
                    present = columns.present[name]
                    there = slice(None) if present is None else present
                    yield columns.rows[there], columns.signals[name][there]

    def inputs(self, name: str) -> list[Input]:
        """Return the signals of a message that can be entered; none for an unknown message."""
        message = self._messages.get(name)
        return [] if message is None else [_input(signal) for signal in message.signals.values()]

    def encode(self, name: str, values: Mapping[str, str]) -> Frame | LinFrame:
        """Return the message's frame with these values, numbers or texts; raises BadSignals with the valid ranges."""
        file = next((file for file in self._files if name in file.messages), None)
        if file is None:
            raise BadSignals(name, {"message": name})
        message = file.messages[name]
        given = {
            signal.name: signal.parse(_typed(signal, values[signal.name]))
            for signal in message.signals.values()
            if values.get(signal.name, "").strip()
        }
        chosen = file.signals_in(name, given)  # the form has those of every multiplexer value
        try:
            return file.encode(name, {one: given[one] for one in chosen if one in given}, fill=0)
        except BadSignals as bad:
            raise BadSignals(name, {one: _range(message.signals[one]) for one in bad.faults}) from None
        except BadValue as error:
            raise BadSignals(name, {"message": str(error)}) from None

    def messages(self) -> list[str]:
        """The names of all messages, in their order."""
        return sorted(self._messages)

    def messages_of(self) -> dict[str, list[str]]:
        """Return the names of the messages of CAN and of LIN separately."""
        return {
            kind: [name for name in self.messages() if self._messages[name].lin == (kind == "lin")]
            for kind in ("can", "lin")
        }

    @cached_property
    def _messages(self) -> dict[str, MessageDescription]:
        found: dict[str, MessageDescription] = {}
        for file in self._files:
            for name, message in file.messages.items():
                found.setdefault(name, message)
        return found


def _key(message: MessageDescription) -> str:
    if message.lin:
        return f"{message.id:02X}"
    return f"{message.id:08X}" if message.extended else f"{message.id:03X}"


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _typed(signal: SignalDescription, text: str) -> str:
    """Replace a decimal comma by a point; texts of the signal stay unchanged."""
    return text if text.strip() in signal.choices.values() else text.replace(",", ".")


def _input(signal: SignalDescription) -> Input:
    choices = list(dict.fromkeys(signal.choices.values()))
    usual = choices[0] if choices else f"{max(signal.minimum, 0):g}"
    return Input(signal.name, usual, signal.unit, choices, _range(signal), signal.minimum, signal.maximum)


def _range(signal: SignalDescription) -> str:
    named = ", ".join(dict.fromkeys(signal.choices.values()))
    return f"{signal.minimum:g} – {signal.maximum:g}" + (f", {named}" if named else "")
