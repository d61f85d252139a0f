"""Messages and signals of a file, in one form for all kinds of files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Number = int | float
Value = int | float | str | list[int]
"""A signal's value: a physical one, its text in the file, or the bytes of a LIN array."""


@dataclass(frozen=True, slots=True)
class SignalDescription:
    """One signal of a message.

    `minimum` and `maximum` are physical values: those of the file, limited to the range of the bits. `choices` are
    texts by raw value. `start` is the physical start value, None if the file gives none. `multiplexer` names the
    multiplexer: this signal is in the frame if the raw value of the multiplexer is one of `multiplexer_ids`; "" if
    this signal is always in the frame. `start_bit` counts as in DBC files: the place of the lowest bit (little
    endian) or the highest bit (big endian); byte 0 holds the bits 0 to 7. `spn` is its number in J1939.
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
        """The raw value of a physical value, or of a text of `choices`."""
        if isinstance(value, str):
            return next(raw for raw, text in self.choices.items() if text == value)
        if self.is_float:
            return (value - self.offset) / self.scale
        return round((value - self.offset) / self.scale)

    def parse(self, text: str) -> Number | str:
        """The value of a typed text: a text of `choices`, or a number (also 0x10). Other text stays as it is."""
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
        """The possible values as text: "0 to 16000 rpm, off, on"."""
        ends = f"{self.minimum:.10g} to {self.maximum:.10g}" + (f" {self.unit}" if self.unit else "")
        return ", ".join([ends, *dict.fromkeys(self.choices.values())])


@dataclass(frozen=True, slots=True)
class MessageDescription:
    """One message: `length` in bytes, `cycle_s` its period in seconds or None, `senders` names of nodes.

    `j1939` messages are recognised by their PGN, with any priority and source; `lin` messages are LIN frames.
    `contained` are the messages in a container, which itself contains no signals. `protection` names the protection
    of the data ("E2E profile 2", "E2E profile 5"), "" without any in the file.
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
        """Whether the message can contain signals: False for a container of other messages."""
        return not self.contained

    @property
    def selectors(self) -> dict[str, set[int]]:
        """The known raw values of each multiplexer: those that choose signals, and those with a text."""
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
