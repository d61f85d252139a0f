"""Names and signals of frames by a network description, as far as there is one: `canwire.Database` for the page."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadSignals, BadValue, Frame, load_database

if TYPE_CHECKING:
    import numpy

    from canwire import MessageDescription, SignalDescription


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


class Database:
    """`path` is a DBC, KCD, SYM or ARXML file, "" for none; raises BadDescription, ExtraMissing when made."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.name = os.path.basename(path)
        self._database = load_database(path) if path else None

    @cached_property
    def names(self) -> dict[str, str]:
        """Message names by "1A2" or, with eight digits, "000001A2" for a 29-bit identifier."""
        return {
            f"{message.id:08X}" if message.extended else f"{message.id:03X}": name
            for name, message in self._messages.items()
        }

    def name_of(self, frame: Frame) -> str:
        """The message that a frame is, J1939's by its parameter group; "" for none."""
        message = None if self._database is None else self._database.message_of(frame)
        return "" if message is None else message.name

    def signals(self, frame: Frame) -> list[Signal]:
        """Decoded; none for a frame that the file does not know, or whose data do not fit it."""
        decoded = None if self._database is None else self._database.decode(frame)
        if decoded is None:
            return []
        told = decoded.description.signals
        return [
            Signal(name, _shown(value), told[name].unit, told[name].comment)
            for name, value in decoded.signals.items()
        ]

    def ids_with(self, name: str) -> list[int]:
        """Identifiers of the messages with a signal of this name, 1 << 31 added where they have 29 bits."""
        return [
            message.id | (1 << 31 if message.extended else 0)
            for message in self._messages.values()
            if name in message.signals
        ]

    def parsed(self, name: str, text: str) -> float:
        """A physical value of a signal as it was typed, a number or a text of the file's; raises ValueError."""
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

    def values_of(
        self, records: numpy.ndarray, name: str, text: str
    ) -> Iterator[tuple[numpy.ndarray, tuple[numpy.ndarray, float]]]:
        """Places of the records that have this signal, with its values, and beside them the value that was typed."""
        if self._database is None:
            return
        for columns in self._database.decode_arrays(records).values():
            if name in columns.signals:
                present, values = columns.present[name], columns.signals[name]
                there = slice(None) if present is None else present
                yield columns.rows[there], (values[there], self.parsed(name, text))

    def curve(self, records: numpy.ndarray, name: str) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Times (ns) and physical values of a signal in these records, which are of one message."""
        import numpy

        if self._database is not None:
            for columns in self._database.decode_arrays(records).values():
                if name in columns.signals:
                    present = columns.present[name]
                    there = slice(None) if present is None else present
                    return columns.time_ns[there], columns.signals[name][there].astype(float)
        return numpy.zeros(0), numpy.zeros(0)

    def inputs(self, name: str) -> list[Input]:
        """The signals of a message that can be given; none for a message that is not there."""
        message = self._messages.get(name)
        return [] if message is None else [_input(signal) for signal in message.signals.values()]

    def encode(self, name: str, values: Mapping[str, str]) -> Frame:
        """The message's frame with these values, numbers or their names; raises BadSignals with what would fit."""
        message = self._messages.get(name)
        if message is None or self._database is None:
            raise BadSignals(name, {"message": name})
        given = {
            signal.name: signal.parse(_typed(signal, values[signal.name]))
            for signal in message.signals.values()
            if values.get(signal.name, "").strip()
        }
        chosen = self._database.signals_in(name, given)  # the form has those of every multiplexer value
        try:
            frame = self._database.encode(name, {one: given[one] for one in chosen if one in given}, fill=0)
        except BadSignals as bad:
            raise BadSignals(name, {one: _range(message.signals[one]) for one in bad.faults}) from None
        except BadValue as error:
            raise BadSignals(name, {"message": str(error)}) from None
        assert isinstance(frame, Frame)
        return frame

    def messages(self) -> list[str]:
        """The names of all messages, in their order."""
        return sorted(self._messages)

    @property
    def _messages(self) -> dict[str, MessageDescription]:
        """Those of CAN."""
        there = {} if self._database is None else self._database.messages
        return {name: message for name, message in there.items() if not message.lin}


def _shown(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _typed(signal: SignalDescription, text: str) -> str:
    """With a point, as numbers have it here; names of values stay as they are."""
    return text if text.strip() in signal.choices.values() else text.replace(",", ".")


def _input(signal: SignalDescription) -> Input:
    choices = list(dict.fromkeys(signal.choices.values()))
    usual = choices[0] if choices else f"{max(signal.minimum, 0):g}"
    return Input(signal.name, usual, signal.unit, choices, _range(signal))


def _range(signal: SignalDescription) -> str:
    named = ", ".join(dict.fromkeys(signal.choices.values()))
    return f"{signal.minimum:g} – {signal.maximum:g}" + (f", {named}" if named else "")
