"""Frames by pattern: the syntax of --id, --length and --data, and the frames made from them.

--id      123             always this identifier; eight digits: extended
          123,124,7FF     in turn
          100-1FF         one after the other, then from the first again
          random          random identifiers; random:100-1FF random in this range
--length  8  0-8  random  the same in bytes; CAN FD frames use the lengths that exist
--data    1122AABB        always these bytes; x is a random digit: 11xx22
          random          random bytes
          increment       a counter of the frames, the lowest byte first
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Sequence
from itertools import count, cycle
from typing import NamedTuple

from canwire import BadValue, Frame, dlc_to_length

_HEX = "[0-9A-Fa-f]{1,8}"
_SPAN = re.compile(rf"({_HEX})-({_HEX})")
_RANDOM = "random"
_LARGEST, _LARGEST_STANDARD = 0x1FFF_FFFF, 0x7FF
_CLASSIC, _FD = tuple(range(9)), tuple(dlc_to_length(code, fd=True) for code in range(16))


class Kind(NamedTuple):
    """The format of the frames; `dlc` is the raw code 9..15 of a classic frame of 8 bytes."""

    extended: bool = False
    remote: bool = False
    fd: bool = False
    bit_rate_switch: bool = False
    error_state_indicator: bool = False
    dlc: int | None = None

    def frame(self, id: int, extended: bool, data: bytes, length: int) -> Frame:
        if self.remote:
            return Frame(id, extended=extended, remote=True, dlc=length if self.dlc is None else self.dlc)
        return Frame(
            id,
            data,
            extended=extended,
            fd=self.fd,
            bit_rate_switch=self.bit_rate_switch,
            error_state_indicator=self.error_state_indicator,
            dlc=self.dlc,
        )


def frames(id: str, length: str, data: str, kind: Kind, chance: random.Random) -> Iterator[Frame]:
    """Yields frames without end, the same for the same `chance`. Raises BadValue for an invalid pattern."""
    _check_kind(kind)
    identifiers = _identifiers(id, kind.extended, chance)
    fixed = None if data in (_RANDOM, "increment") else data.replace(".", "").replace(" ", "")
    if fixed is not None:
        _check_data(data, fixed, kind)
        length = str(len(fixed) // 2) if kind.dlc is None else "8"
    lengths = _lengths("8" if kind.dlc is not None else length, _FD if kind.fd else _CLASSIC, chance)
    return _frames(identifiers, lengths, fixed, data, kind, chance)


def _frames(
    identifiers: Iterator[tuple[int, bool]],
    lengths: Iterator[int],
    fixed: str | None,
    data: str,
    kind: Kind,
    chance: random.Random,
) -> Iterator[Frame]:
    for number, (id, extended), length in zip(count(), identifiers, lengths, strict=False):
        if fixed is not None:
            content = bytes.fromhex(_filled(fixed, chance))
        elif data == _RANDOM:
            content = chance.randbytes(length)
        else:
            content = (number % (1 << 8 * length)).to_bytes(length, "little") if length else b""
        yield kind.frame(id, extended, content, length)


def _check_kind(kind: Kind) -> None:
    if kind.remote and kind.fd:
        raise BadValue("--remote: CAN FD has no remote frames; leave --fd, --brs and --esi out")
    if kind.dlc is not None and (kind.fd or not 9 <= kind.dlc <= 15):
        raise BadValue(
            f"--dlc {kind.dlc}: 9 to 15, the raw length code of classic frames; --length says how many bytes"
        )


def _identifiers(text: str, extended: bool, chance: random.Random) -> Iterator[tuple[int, bool]]:
    if text == _RANDOM or text.startswith(f"{_RANDOM}:"):
        _, _, within = text.partition(":")
        first, last, wide = (
            _span(within) if within else (0, _LARGEST if extended else _LARGEST_STANDARD, extended)
        )
        return ((chance.randint(first, last), wide or extended) for _ in count())
    if "-" in text:
        first, last, wide = _span(text)
        return ((id, wide or extended) for id in cycle(range(first, last + 1)))
    found = [_identifier(part) for part in text.split(",")]
    return cycle([(id, wide or extended) for id, wide in found])


def _span(text: str) -> tuple[int, int, bool]:
    match = _SPAN.fullmatch(text)
    if match is None:
        raise BadValue(f"--id {text!r}: from the lower to the higher identifier, in hex: 100-1FF")
    (first, wide), (last, also_wide) = _identifier(match[1]), _identifier(match[2])
    if last < first:
        raise BadValue(f"--id {text}: from the lower to the higher identifier")
    return first, last, wide or also_wide


def _identifier(text: str) -> tuple[int, bool]:
    if not re.fullmatch(_HEX, text):
        raise BadValue(f"--id {text!r}: 123, 123,124, 100-1FF, random or random:100-1FF, in hex")
    id, wide = int(text, 16), len(text) > 3
    if id > (_LARGEST if wide else _LARGEST_STANDARD):
        raise BadValue(f"--id {text}: no identifier of {29 if wide else 11} bits")
    return id, wide


def _lengths(text: str, possible: Sequence[int], chance: random.Random) -> Iterator[int]:
    if text == _RANDOM:
        return (chance.choice(possible) for _ in count())
    match = re.fullmatch(r"(\d{1,2})(?:-(\d{1,2}))?", text)
    within = [length for length in possible if match and int(match[1]) <= length <= int(match[2] or match[1])]
    if not within:
        raise BadValue(f"--length {text}: bytes, {possible[0]} to {possible[-1]}; 0-8 in turn, or random")
    return cycle(within)


def _check_data(data: str, digits: str, kind: Kind) -> None:
    possible = _FD if kind.fd else _CLASSIC
    if not re.fullmatch("(?:[0-9A-Fa-fxX]{2})*", digits):
        raise BadValue(f"--data {data}: pairs of hex digits (x: a random one), random or increment")
    if len(digits) // 2 not in possible:
        raise BadValue(f"--data {data}: {len(digits) // 2} bytes; one of {', '.join(map(str, possible))}")
    if kind.dlc is not None and len(digits) != 16:
        raise BadValue(f"--data {data}: 8 bytes with --dlc {kind.dlc}")


def _filled(digits: str, chance: random.Random) -> str:
    if "x" not in digits and "X" not in digits:
        return digits
    return "".join(f"{chance.randrange(16):X}" if digit in "xX" else digit for digit in digits)
