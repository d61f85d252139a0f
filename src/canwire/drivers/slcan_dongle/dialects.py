"""The commands that serial adapters understand; an adapter's answer to V shows its dialect.

Sources: CANBUS manual, rulings 26 to 29; reference/can-protocol.md, appendix (CAN232, CANable). Other adapters are
supported if they follow LAWICEL's CAN232.
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
    """The commands of one kind of adapter. `rates`: the digit after S by bit/s; `data_rates`: after Y, for CAN FD.

    With `registers` it accepts s with BTR0 and BTR1; with `filters`, M and m; with `numbered`, N; with `flags`, F; with
    `stamps`, Z. Without `answer` it does not reply to commands that return no value. `listen` is the command that
    opens it in listen-only mode, b"" if it has none; `normal` undoes `listen` before O.
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
"""An adapter with an unknown version: only the commands that all dialects share."""

DIALECTS = (CANBUS, CANABLE, PLAIN)


def recognised(version: bytes) -> Dialect | None:
    """The dialect of an adapter that answers this to V; None if the answer is no version."""
    return next((dialect for dialect in DIALECTS if dialect.version.match(version)), None)
