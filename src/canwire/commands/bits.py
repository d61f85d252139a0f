"""`canwire bits`: a frame as it stands on the wire, bit by bit.

canwire bits 123#DEADBEEF                     fields, stuff bits in (), CRC, duration, and a drawing
canwire bits 123##1AABB --data-bit-rate 4000000
canwire bits 123#R4 --json                    bits, length, stuff_bits, crc, duration_ns, fields

Source: ISO 11898-1:2015 10.4.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Iterator
from fractions import Fraction
from itertools import groupby
from typing import Any, NamedTuple

from canwire import FIELDS, NON_ISO, BadTiming, BitLayout, Frame, format_frame, parse_frame
from canwire.commands.lab.waveform import draw

_PLAIN_WIDTH = 100
_MARGIN = 2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument("frame", metavar="FRAME", help="as in a log: 123#DEADBEEF, 123#R4, 123##1AABB")
    parser.add_argument("--bit-rate", type=int, default=500_000, metavar="BIT/S", help="default: 500000")
    parser.add_argument(
        "--data-bit-rate", type=int, default=2_000_000, metavar="BIT/S", help="after BRS; default: 2000000"
    )
    parser.add_argument("--non-iso", action="store_true", help="CAN FD as Bosch defined it: no stuff count")
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(arguments: argparse.Namespace) -> int:
    """Print the frame's bits; BadText for no frame, BadTiming for a rate of 0 or less."""
    for name in ("bit_rate", "data_bit_rate"):
        if getattr(arguments, name) <= 0:
            raise BadTiming(f"--{name.replace('_', '-')} {getattr(arguments, name)}: more than 0 bit/s")
    frame = parse_frame(arguments.frame)
    layout = BitLayout(frame, fd_mode=NON_ISO) if arguments.non_iso else BitLayout(frame)
    layout.levels[layout.ack_slot()] = 0  # somebody acknowledges
    duration_ns = frame_time_ns(layout, frame, arguments.bit_rate, arguments.data_bit_rate)
    parts = fields_of(layout, frame)
    if arguments.json:
        print(json.dumps(_facts(layout, parts, duration_ns), indent=2))
    else:
        print(*_page(arguments, frame, layout, parts, duration_ns), sep="\n")
    return 0


class Field(NamedTuple):
    """A stretch of the frame; `bits` has its stuff bits too, and `stuffed` a 1 at each of them."""

    name: str
    start: int
    bits: str
    stuffed: bytes

    @property
    def marked(self) -> str:
        """The bits with stuff bits in parentheses."""
        return "".join(f"({bit})" if stuff else bit for bit, stuff in self._pairs())

    @property
    def value(self) -> int:
        """The number in the field, stuff bits left out."""
        return int("".join(bit for bit, stuff in self._pairs() if not stuff), 2)

    @property
    def stuff_places(self) -> list[int]:
        """Where the stuff bits are, counted from SOF."""
        return [self.start + k for k, stuff in enumerate(self.stuffed) if stuff]

    def facts(self) -> dict[str, Any]:
        """For --json."""
        return {"name": self.name, "start": self.start, "bits": self.bits, "stuff": self.stuff_places}

    def _pairs(self) -> Iterator[tuple[str, int]]:
        return zip(self.bits, self.stuffed, strict=True)


def frame_time_ns(layout: BitLayout, frame: Frame, bit_rate: int, data_bit_rate: int) -> Fraction:
    """From SOF to the end of EOF, exactly.

    BRS and the CRC delimiter change rate at their sample points: together they last one nominal and
    one data bit. Source: reference/can-protocol.md section 4.
    """
    fast = layout.data_bits + 1 if frame.bit_rate_switch else 0
    return Fraction((len(layout.levels) - fast) * 10**9, bit_rate) + Fraction(fast * 10**9, data_bit_rate)


def fields_of(layout: BitLayout, frame: Frame) -> list[Field]:
    """The frame's fields in order, under the names that they have in this format."""
    found = []
    for index, group in groupby(range(len(layout.levels)), key=layout.fields.__getitem__):
        places = list(group)
        bits = "".join(str(layout.levels[k]) for k in places)
        stuffed = bytes(layout.stuffed[k] for k in places)
        found.append(Field(_name(FIELDS[index], frame), places[0], bits, stuffed))
    return found


def _name(field: str, frame: Frame) -> str:
    """ISO's name: some bits are called differently in each format."""
    if field == "RTR":
        return "SRR" if frame.extended else "RRS" if frame.fd else "RTR"
    if field == "RTR2":
        return "RRS" if frame.fd else "RTR"
    if field == "FDF" and not frame.fd:
        return "r1" if frame.extended else "r0"
    return {"EXT": "ID EXT"}.get(field, field)


def _facts(layout: BitLayout, parts: list[Field], duration_ns: Fraction) -> dict[str, Any]:
    """For --json. `stuff_bits` are the dynamic ones; a duration of no whole nanoseconds is a decimal."""
    return {
        "bits": "".join(str(level) for level in layout.levels),
        "length": len(layout.levels),
        "stuff_bits": layout.stuff_bits,
        "crc": layout.crc,
        "duration_ns": int(duration_ns) if duration_ns.denominator == 1 else float(duration_ns),
        "fields": [part.facts() for part in parts],
    }


def _page(
    arguments: argparse.Namespace, frame: Frame, layout: BitLayout, parts: list[Field], duration_ns: Fraction
) -> list[str]:
    """Everything for people: headline, fields, drawing."""
    on_terminal = sys.stdout.isatty()
    width = shutil.get_terminal_size().columns if on_terminal else _PLAIN_WIDTH
    fancy = on_terminal and "utf" in (sys.stdout.encoding or "").lower()
    rates = f"{arguments.bit_rate} bit/s"
    if frame.bit_rate_switch:
        rates += f", {arguments.data_bit_rate} bit/s after BRS"
    fixed = sum(layout.stuffed) - layout.stuff_bits
    stuff = f"{layout.stuff_bits} stuff bits" + (f" and {fixed} fixed ones" if fixed else "")
    head = [
        f"{format_frame(frame)}  {_kind(frame)}",
        f"{len(layout.levels)} bits from SOF to the end of EOF, {stuff} among them (in parentheses)",
        f"{float(duration_ns) / 1000:g} us at {rates}; 3 bits of intermission follow",
        "",
    ]
    column = max(len(part.name) for part in parts)
    listed = [f"{part.name:<{column}}  {_shown(part)}" for part in parts]
    starts = [(part.start, part.name) for part in parts]
    return head + listed + [""] + draw(layout.levels, layout.stuffed, starts, width - _MARGIN, fancy=fancy)


def _kind(frame: Frame) -> str:
    width = 29 if frame.extended else 11
    kind = "CAN FD frame" if frame.fd else "remote frame" if frame.remote else "data frame"
    return f"{kind}, {width}-bit identifier, DLC {frame.dlc}, {len(frame.data)} data bytes"


def _shown(part: Field) -> str:
    """A field's bits, with its value where that is a number."""
    if part.name in ("ID", "ID EXT", "DLC", "CRC"):
        return f"{part.marked}  {part.value:#x}"
    return part.marked
