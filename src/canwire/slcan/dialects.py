"""The dialects of different makers' adapters: a table of commands for each, and its bit rates.

Sources: CANBUS manual, rulings 27 and 29; the CANable 2 firmware as the appendix of reference/can-protocol.md
describes it: it answers only V and E.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from canwire import BitTiming


class State(Enum):
    """The state of a dongle's channel, which is closed in the first two."""

    IDLE = "idle"
    INITIATED = "initiated"
    OPEN = "open"
    LISTENING = "listening"


IDLE, INITIATED, OPEN, LISTENING = State
CLOSED = frozenset((IDLE, INITIATED))
ON_BUS = frozenset((OPEN, LISTENING))
ALWAYS = frozenset(State)


class Rule(NamedTuple):
    """The states that accept a command, the number of characters after its letter, and its method of Dongle."""

    states: frozenset[State]
    length: int
    action: str


@dataclass(frozen=True, slots=True)
class Dialect:
    """The commands of one kind of adapter. `rates` and `data_rates` by the digit after S and Y.

    With `fd` it accepts CAN FD frames and is an FD controller on the bus. Without `answers` it does not reply to
    commands that return no value, whether they succeed or fail. Without `timing` a rate has to be set before O.
    """

    name: str
    rules: Mapping[bytes, Rule]
    rates: Mapping[bytes, BitTiming]
    version: str
    kinds: tuple[str, ...]  # boards to be plugged in for it, the first that there is
    data_rates: Mapping[bytes, BitTiming] | None = None
    fd: bool = False
    answers: bool = True
    timing: BitTiming | None = None
    data_timing: BitTiming | None = None


_CANBUS_RATES = ("311C", "181C", "091C", "041C", "031C", "011C", "001C", "0016", "0014")
_CANABLE_HZ = 80_000_000  # of the board that plays it


def _of_btr(text: str) -> BitTiming:
    return BitTiming.from_btr(int(text[:2], 16), int(text[2:], 16))


def _quanta(prescaler: int, quanta: int = 20) -> BitTiming:
    tseg2 = max(2, quanta // 5)
    return BitTiming(prescaler, quanta - 1 - tseg2, tseg2, tseg2, clock_hz=_CANABLE_HZ)


CANBUS = Dialect(
    name="canbus",
    rules={
        b"S": Rule(CLOSED, 1, "set_rate"),
        b"s": Rule(CLOSED, 4, "set_registers"),
        b"O": Rule(frozenset((INITIATED,)), 0, "open"),
        b"L": Rule(frozenset((INITIATED,)), 0, "listen"),
        b"C": Rule(ON_BUS, 0, "close"),
        b"F": Rule(ON_BUS, 0, "read_flags"),
        b"M": Rule(frozenset((INITIATED,)), 8, "set_code"),
        b"m": Rule(frozenset((INITIATED,)), 8, "set_mask"),
        b"V": Rule(ALWAYS, 0, "tell_version"),
        b"N": Rule(ALWAYS, 0, "tell_serial_number"),
        b"Z": Rule(CLOSED, 1, "set_stamps"),
    },
    rates={b"%d" % k: _of_btr(text) for k, text in enumerate(_CANBUS_RATES)},
    version="V1013",
    kinds=("canbus-dongle", "pc-i04"),
)

CANABLE = Dialect(
    name="canable",
    rules={
        b"S": Rule(CLOSED, 1, "set_rate"),
        b"Y": Rule(CLOSED, 1, "set_data_rate"),
        b"O": Rule(CLOSED, 0, "open"),
        b"C": Rule(ON_BUS, 0, "close"),
        b"M": Rule(CLOSED, 1, "set_silent"),
        b"m": Rule(CLOSED, 1, "set_silent"),
        b"A": Rule(CLOSED, 1, "set_repeating"),
        b"a": Rule(CLOSED, 1, "set_repeating"),
        b"V": Rule(ALWAYS, 0, "tell_version"),
        b"E": Rule(ALWAYS, 0, "tell_errors"),
    },
    rates={
        **{b"%d" % k: _quanta(p) for k, p in enumerate((400, 200, 80, 40, 32, 16, 8))},
        b"7": _quanta(2, 53),  # 754.7 kbit/s: 750 cannot be made from 80 MHz, nor could the real one make it
        b"8": _quanta(4),
        b"9": _quanta(48),
    },
    version="canwire canable2",
    kinds=("usb-to-can-fd",),
    data_rates={b"1": _quanta(4), b"2": _quanta(2), b"4": _quanta(2, 10), b"5": _quanta(2, 8)},
    fd=True,
    answers=False,
    timing=_quanta(32),
    data_timing=_quanta(2),
)

DIALECTS = {dialect.name: dialect for dialect in (CANBUS, CANABLE)}
