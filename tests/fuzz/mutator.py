"""Inputs made of good ones: bits flipped, numbers made extreme, pieces cut, doubled, moved and taken from others."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

LARGEST = 1 << 16  # bytes of an input
_NUMBERS = tuple(
    number.to_bytes(size, order)
    for size in (1, 2, 4, 8)
    for number in {
        0,
        1,
        0x7F,
        0xFF,
        (1 << 8 * size - 1) - 1,
        1 << 8 * size - 1,
        (1 << 8 * size) - 1,
        1 << 4 * size,
    }
    if number < 1 << 8 * size
    for order in ("little", "big")
)
_WORDS = (
    *(b"\n", b"\0", b"\r", b'"', b"\xff", b"-1", b"1e999", b"nan", b"0", b"99999999999999999999"),
    *(b"[[[[", b"{", b"#", b" ", b","),
)

Change = Callable[[random.Random, bytearray, Sequence[bytes]], None]


def mutated(random: random.Random, seeds: Sequence[bytes]) -> bytes:
    """One of the seeds with one to eight changes."""
    data = bytearray(random.choice(seeds))
    for _ in range(random.choice((1, 1, 1, 2, 3, 5, 8))):
        random.choice(_CHANGES)(random, data, seeds)
    return bytes(data[:LARGEST])


def _place(random: random.Random, data: bytearray) -> int:
    return random.randrange(len(data) + 1)


def _flip(random: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    if data:
        data[random.randrange(len(data))] ^= 1 << random.randrange(8)


def _number(random: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    put, at = random.choice(_NUMBERS), _place(random, data)
    data[at : at + len(put)] = put


def _word(random: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    at = _place(random, data)
    data[at : at + random.randrange(3)] = random.choice(_WORDS) * random.choice((1, 1, 1, 2, 50))


def _cut(random: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    at = _place(random, data)
    del data[at : at + random.choice((1, 2, 4, 16, 64, len(data)))]


def _double(random: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    at = _place(random, data)
    piece = data[at : at + random.choice((1, 4, 16, 64, 256))]
    data[at:at] = piece * random.choice((1, 2, 10, 100))


def _move(random: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    at, size = _place(random, data), random.choice((1, 4, 16, 64))
    piece = data[at : at + size]
    del data[at : at + size]
    to = _place(random, data)
    data[to:to] = piece


def _take(random: random.Random, data: bytearray, seeds: Sequence[bytes]) -> None:
    other, at = random.choice(seeds), _place(random, data)
    begin = random.randrange(len(other) + 1)
    data[at : at + random.choice((0, 8, 64))] = other[begin : begin + random.choice((8, 64, 512))]


_CHANGES: tuple[Change, ...] = (_flip, _flip, _number, _number, _word, _cut, _double, _move, _take)
