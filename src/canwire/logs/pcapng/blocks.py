"""Blocks and options of a pcapng file."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

SECTION, INTERFACE, SIMPLE, STATISTICS, PACKET = 0x0A0D0D0A, 1, 3, 5, 6
BYTE_ORDER = 0x1A2B3C4D
COMMENT, IF_NAME, IF_TSRESOL, IF_TSOFFSET, EPB_FLAGS, ISB_DROPPED = 1, 2, 9, 14, 2, 5
_MOST = 1 << 24  # bytes of a block: larger ones are torn


class Block(NamedTuple):
    """One block: its place in the file, its type, its content; `order` is "<" or ">"."""

    at: int
    kind: int
    body: bytes
    order: str


class Torn(Exception):
    """Raised where the rest of the file contains no complete block."""

    def __init__(self, at: int, what: str) -> None:
        super().__init__(at, what)  # pickle calls `__init__` with these arguments
        self.at = at
        self.what = what

    def __str__(self) -> str:
        return self.what


def blocks(file: BinaryIO, at: int, order: str = "<") -> Iterator[Block]:
    """Yield every block from here on; raises Torn at the first incomplete or invalid block."""
    while head := file.read(8):
        kind = int.from_bytes(head[:4], "little")
        if kind == SECTION:
            peeked = file.read(4)
            order = "<" if peeked == BYTE_ORDER.to_bytes(4, "little") else ">"
        else:
            peeked = b""
        if len(head) < 8:
            raise Torn(at, "the file ends in the middle of a block")
        kind, size = struct.unpack(order + "II", head)
        if size < 12 + len(peeked) or size % 4 or size > _MOST:
            raise Torn(at, f"no block: type {kind:#x}, {size} bytes")
        rest = file.read(size - 8 - len(peeked))
        if len(rest) < size - 8 - len(peeked):
            raise Torn(at, "the file ends in the middle of a block")
        if rest[-4:] != head[4:]:
            raise Torn(at, f"the block of {size} bytes does not end with its size")
        yield Block(at, kind, peeked + rest[:-4], order)
        at += size


def options(body: bytes, at: int, order: str) -> dict[int, bytes]:
    """Return the options from this place of a block's body on, by their code."""
    found = {}
    while at + 4 <= len(body):
        code, size = struct.unpack_from(order + "HH", body, at)
        if not code:
            break
        found[code] = body[at + 4 : at + 4 + size]
        at += 4 + size + -size % 4
    return found


def block(kind: int, body: bytes, told: dict[int, bytes]) -> bytes:
    """Return the bytes of a little-endian block with its options."""
    listed = b"".join(
        struct.pack("<HH", code, len(value)) + value + b"\0" * (-len(value) % 4)
        for code, value in told.items()
    )
    content = body + b"\0" * (-len(body) % 4) + (listed + b"\0" * 4 if told else b"")
    size = struct.pack("<I", len(content) + 12)
    return struct.pack("<I", kind) + size + content + size
