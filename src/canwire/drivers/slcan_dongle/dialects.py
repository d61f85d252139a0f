"""What serial adapters understand, and how to tell them apart by what they answer to V.

Sources: CANBUS manual, rulings 26 to 29; reference/can-protocol.md, appendix (CAN232, CANable). Others than these
are known only as far as they follow LAWICEL's CAN232.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

_CANBUS_RATES = {10_000: b"0", 20_000: b"1", 50_000: b"2", 100_000: b"3", 125_000: b"4", 250_000: b"5",
                 500_000: b"6", 800_000: b"7", 1_000_000: b"8"}  # fmt: skip
_CANBUS_BTR = {"311C": b"0", "181C": b"1", "091C": b"2", "041C": b"3", "031C": b"4", "011C": b"5",
               "001C": b"6", "0016": b"7", "0014": b"8"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Dialect:
    """One way to talk. `rates` by bit/s: the digit behind S; `data_rates`: behind Y, with CAN FD only.

    With `registers` it takes s and BTR0, BTR1; with `filters` M and m; `numbered` answers N, `flags` F, `stamps` Z.
    One that does not `answer` says nothing to commands that only do something. `listen` opens it only to listen,
    b"" where it cannot; `normal` undoes that before O.
    """

    name: str
    version: re.Pattern[bytes]
    rates: Mapping[int, bytes]
    btr: Mapping[str, bytes]
    data_rates: Mapping[int, bytes] | None = None
    answers: bool = True
    registers: bool = True
    filters: bool = True
    numbered: bool = True
    flags: bool = True
    stamps: bool = True
    listen: bytes = b"L"
    normal: bytes = b""

    @property
    def fd(self) -> bool:
        return self.data_rates is not None


CANBUS = Dialect("CANBUS", re.compile(rb"V[0-9A-Fa-f]{4}\Z"), _CANBUS_RATES, _CANBUS_BTR)
CANABLE = Dialect(
    "CANable",
    re.compile(rb"(?i).*(canable|slcan)"),
    {
        **{rate: digit for rate, digit in _CANBUS_RATES.items() if rate != 800_000},
        750_000: b"7",
        83_300: b"9",
    },
    {},
    data_rates={1_000_000: b"1", 2_000_000: b"2", 4_000_000: b"4", 5_000_000: b"5"},
    answers=False,
    registers=False,
    filters=False,
    numbered=False,
    flags=False,
    stamps=False,
    listen=b"M1",
    normal=b"M0",
)
PLAIN = Dialect(
    "plain slcan",
    re.compile(rb"[Vv].*"),
    _CANBUS_RATES,
    {},
    registers=False,
    filters=False,
    flags=False,
    stamps=False,
    listen=b"",
)
"""Something that says a version nobody here knows: only what all of them share."""

DIALECTS = (CANBUS, CANABLE, PLAIN)


def recognised(version: bytes) -> Dialect | None:
    """The dialect of an adapter that answers this to V; None for what is no version at all."""
    return next((dialect for dialect in DIALECTS if dialect.version.match(version)), None)
