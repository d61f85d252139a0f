"""A message's bits as a picture: a row for each byte, a letter for each signal."""

from __future__ import annotations

from collections.abc import Iterator
from string import ascii_lowercase, ascii_uppercase, digits
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire import MessageDescription, SignalDescription

_LETTERS = ascii_uppercase + ascii_lowercase + digits
_FREE, _SEVERAL = ".", "*"


def picture_of(message: MessageDescription) -> Iterator[str]:
    """Rows of eight bits, the highest first; `.`: a bit of no signal, `*`: of several signals (on different pages)."""
    owners: dict[int, str] = {}
    letters = []
    for number, signal in enumerate(message.signals.values()):
        letter = _LETTERS[number % len(_LETTERS)]
        letters.append(f"{letter} {signal.name}")
        for bit in bits_of(signal):
            owners[bit] = letter if owners.get(bit, letter) == letter else _SEVERAL
    size = min(message.length, 64)
    yield "byte  7 6 5 4 3 2 1 0"
    for byte in range(size):
        row = " ".join(owners.get(8 * byte + bit, _FREE) for bit in range(7, -1, -1))
        yield f"{byte:>4}  {row}   {letters[byte] if byte < len(letters) else ''}".rstrip()
    for rest in letters[size:]:
        yield f"{'':21}   {rest}"


def bits_of(signal: SignalDescription) -> Iterator[int]:
    """The places of its bits: 8 * byte + bit, bit 0 the lowest of its byte."""
    if not signal.big_endian:
        yield from range(signal.start_bit, signal.start_bit + signal.length)
        return
    place = signal.start_bit
    for _ in range(signal.length):
        yield place
        place = place - 1 if place % 8 else place + 15
