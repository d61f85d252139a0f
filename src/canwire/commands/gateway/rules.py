"""Rules of a gateway from the command line: --filter, --map, --change, --rate."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence

from canwire import BadValue, Frame, GatewayRules
from canwire.commands.dump.filters import parse_capture

_MAP = re.compile(r"([0-9A-Fa-f]{1,8})=([0-9A-Fa-f]{1,8})")
_CHANGE = re.compile(r"([0-9A-Fa-f]{1,8}):(\d{1,2})=([0-9A-Fa-f]{2})(?:/([0-9A-Fa-f]{2}))?")
_Ids = dict[int | tuple[int, bool], int | tuple[int, bool]]
_Change = tuple[tuple[int, bool], int, int, int]  # frame, byte, value, mask


def add_rule_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --filter, --map, --change, --rate and --one-way."""
    parser.add_argument(
        "--filter",
        action="append",
        default=[],
        metavar="ID:MASK",
        help="pass only these frames on, as in `canwire dump --filter`",
    )
    parser.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="ID=ID",
        help="give frames another identifier; the opposite direction restores the original one",
    )
    parser.add_argument(
        "--change",
        action="append",
        default=[],
        metavar="ID:BYTE=VALUE[/MASK]",
        help="set these bits of a data byte (0 is the first) in frames from LINE to OTHER; "
        "ID is the new identifier",
    )
    parser.add_argument(
        "--rate", type=float, metavar="N", help="pass on at most N frames in any second, in each direction"
    )
    parser.add_argument("--one-way", action="store_true", help="pass frames on from LINE to OTHER only")


def rules_by(arguments: argparse.Namespace) -> tuple[GatewayRules, GatewayRules | None]:
    """The rules from LINE to OTHER and the rules back (None with --one-way). Raises BadValue."""
    ids: _Ids = dict(_mapping(text) for text in arguments.map)
    capture = parse_capture(arguments.filter, (), False)
    changes = [_change(text) for text in arguments.change]

    names: _Ids = {new: old for old, new in ids.items()}
    if len(names) != len(ids):
        raise BadValue(
            "--map: two identifiers would become one; a gateway could not tell them apart on the way back"
        )
    wanted = capture.accepts if capture.filters else None
    change = (lambda frame: _applied(frame, changes)) if changes else None
    there = GatewayRules(wanted, ids, change, arguments.rate)
    return there, None if arguments.one_way else GatewayRules(wanted, names, rate=arguments.rate)


def _applied(frame: Frame, changes: Sequence[_Change]) -> Frame:
    data = bytearray(frame.data)
    for which, place, value, mask in changes:
        if which == (frame.id, frame.extended) and place < len(data):
            data[place] = (data[place] & ~mask) | (value & mask)
    if data == frame.data:
        return frame
    return Frame(
        frame.id,
        bytes(data),
        extended=frame.extended,
        fd=frame.fd,
        bit_rate_switch=frame.bit_rate_switch,
        timestamp_ns=frame.timestamp_ns,
    )


def _mapping(text: str) -> tuple[tuple[int, bool], tuple[int, bool]]:
    found = _MAP.fullmatch(text)
    if found is None:
        raise BadValue(f"--map {text!r}: two identifiers in hex: 100=200, or 18FEF100=18FEF200")
    return _identifier(found[1]), _identifier(found[2])


def _change(text: str) -> _Change:
    found = _CHANGE.fullmatch(text)
    if found is None:
        raise BadValue(
            f"--change {text!r}: identifier, byte and value in hex: 123:2=FF, or 123:2=01/0F for these bits only"
        )
    return _identifier(found[1]), int(found[2]), int(found[3], 16), int(found[4] or "FF", 16)


def _identifier(digits: str) -> tuple[int, bool]:
    """Eight digits, or a number above 7FF, are 29 bits, as in candump's texts."""
    number = int(digits, 16)
    return number, len(digits) == 8 or number > 0x7FF
