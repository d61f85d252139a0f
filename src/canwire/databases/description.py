"""What a file says of messages and signals, in one form for all kinds of files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Number = int | float
Value = int | float | str | list[int]
"""A signal's value: a physical one, the text that the file gives it, or a LIN array's bytes."""


@dataclass(frozen=True, slots=True)
class SignalDescription:
    """One signal of a message.

    `minimum` and `maximum` are physical values: those that the file tells, within what the bits can say. `choices` are
    texts by raw value. `start` is the physical value that a sender begins with, None where the file gives none.
    `multiplexer` names the signal by whose raw value, one of `multiplexer_ids`, this one is in the frame; "" for one
    that always is. `start_bit` counts as DBC files do: the lowest bit's place (little endian), the highest bit's (big
    endian), byte 0 holding the bits 0 to 7. `spn` is J1939's number of it.
    """

    name: str
    start_bit: int
    length: int
    minimum: float
    maximum: float
    big_endian: bool = False
    signed: bool = False
    is_float: bool = False
    scale: Number = 1
    offset: Number = 0
    unit: str = ""
    comment: str = ""
    choices: Mapping[int, str] = field(default_factory=dict)
    start: Value | None = None
    multiplexer: str = ""
    multiplexer_ids: tuple[int, ...] = ()
    spn: int | None = None

    def raw(self, value: Number | str) -> Number:
        """What stands in the bits for a physical value, or for a text of `choices`."""
        if isinstance(value, str):
            return next(raw for raw, text in self.choices.items() if text == value)
        if self.is_float:
            return (value - self.offset) / self.scale
        return round((value - self.offset) / self.scale)

    def parse(self, text: str) -> Number | str:
        """What people type: a text of `choices`, or a number (0x10, too). What is neither stays text, for `encode`."""
        text = text.strip()
        if text in self.choices.values():
            return text
        try:
            return int(text, 0)
        except ValueError:
            pass
        try:
            return float(text)
        except ValueError:
            return text

    @property
    def range(self) -> str:
        """What may be given, for people: "0 to 16000 rpm, off, on"."""
        ends = f"{self.minimum:.10g} to {self.maximum:.10g}" + (f" {self.unit}" if self.unit else "")
        return ", ".join([ends, *dict.fromkeys(self.choices.values())])


@dataclass(frozen=True, slots=True)
class MessageDescription:
    """One message: `length` in bytes, `cycle_s` its period in seconds or None, `senders` names of nodes.

    `j1939` messages are known by their PGN, whatever their priority and source; `lin` ones are LIN frames.
    `contained` are the messages that a container holds; it has no signals of its own. `protection` names what guards
    the data ("E2E profile 2", "E2E profile 5"), "" where the file says nothing.
    """

    name: str
    id: int
    length: int
    signals: Mapping[str, SignalDescription]
    extended: bool = False
    fd: bool = False
    bit_rate_switch: bool = False
    j1939: bool = False
    lin: bool = False
    cycle_s: float | None = None
    senders: tuple[str, ...] = ()
    comment: str = ""
    contained: tuple[MessageDescription, ...] = ()
    protection: str = ""

    @property
    def decodable(self) -> bool:
        """It has signals of its own: it is no container of other messages."""
        return not self.contained

    @property
    def selectors(self) -> dict[str, set[int]]:
        """By multiplexer the raw values that are known: those that choose signals, and those that have a text."""
        known: dict[str, set[int]] = {}
        for signal in self.signals.values():
            if signal.multiplexer:
                decides = self.signals[signal.multiplexer]
                known.setdefault(decides.name, set(decides.choices)).update(signal.multiplexer_ids)
        return known

    @property
    def pgn(self) -> int | None:
        """The parameter group number of a J1939 message."""
        return pgn_of(self.id) if self.j1939 else None


def pgn_of(id: int) -> int:
    """The parameter group number in a 29-bit identifier; of a PDU1 format the destination is left out.

    Source: SAE J1939-21 5.1.2.

    >>> hex(pgn_of(0x0CF00417)), hex(pgn_of(0x18EAFF17))
    ('0xf004', '0xea00')
    """
    pgn = id >> 8 & 0x3FFFF
    return pgn if pgn >> 8 & 0xFF >= 240 else pgn & 0x3FF00
