"""`canwire bits`: a frame as it is on the wire, bit by bit.

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
from fractions import Fraction
from typing import Any

from canwire import (
    NON_ISO,
    BadTiming,
    BitLayout,
    Frame,
    WireField,
    format_frame,
    parse_frame,
    wire_fields,
)
from canwire.commands.lab.waveform import draw

_PLAIN_WIDTH = 100
_MARGIN = 2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
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
    parts = wire_fields(layout, frame)
    if arguments.json:
        print(json.dumps(_facts(layout, parts, duration_ns), indent=2))
    else:
        print(*_page(arguments, frame, layout, parts, duration_ns), sep="\n")
    return 0


def frame_time_ns(layout: BitLayout, frame: Frame, bit_rate: int, data_bit_rate: int) -> Fraction:
    """The exact time from SOF to the end of EOF.

    BRS and the CRC delimiter change rate at their sample points: together they last one nominal and
    one data bit. Source: reference/can-protocol.md section 4.
    """
    fast = layout.data_bits + 1 if frame.bit_rate_switch else 0
    return Fraction((len(layout.levels) - fast) * 10**9, bit_rate) + Fraction(fast * 10**9, data_bit_rate)


def _facts(layout: BitLayout, parts: list[WireField], duration_ns: Fraction) -> dict[str, Any]:
    """For --json. `stuff_bits` are the dynamic ones; a duration of no whole nanoseconds is a decimal."""
    return {
        "bits": "".join(str(level) for level in layout.levels),
        "length": len(layout.levels),
        "stuff_bits": layout.stuff_bits,
        "crc": layout.crc,
        "duration_ns": int(duration_ns) if duration_ns.denominator == 1 else float(duration_ns),
        "fields": [_field_facts(part) for part in parts],
    }


def _field_facts(field: WireField) -> dict[str, Any]:
    return {"name": field.name, "start": field.start, "bits": field.bits, "stuff": field.stuff_places}


def _page(
    arguments: argparse.Namespace,
    frame: Frame,
    layout: BitLayout,
    parts: list[WireField],
    duration_ns: Fraction,
) -> list[str]:
    """Return the lines of the text output: headline, fields, drawing."""
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


def _shown(part: WireField) -> str:
    """A field's bits, with its value where that is a number."""
    if part.name in ("ID", "ID EXT", "DLC", "CRC"):
        return f"{part.marked}  {part.value:#x}"
    return part.marked
