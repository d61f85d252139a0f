"""The payloads of a loopback link besides requests and replies: events, and shared memory by the name of its file.

A payload that begins with one of these letters is not a message (messages begin with msgpack's mark of an array):

    S number    either way: the event of this number was signalled (0: the client's doorbell)
    P items     hub to client: memory and events that the next reply counts
    F           client to hub: the memory that came with the oldest P is open
    D number    client to hub: this copy of an event is closed
"""

from __future__ import annotations

import struct

import msgspec

from canwire.errors import BadMessage
from canwire.hub.protocol.messages import LENGTH

SIGNALLED, PASSED, FETCHED, DROPPED = b"S", b"P", b"F", b"D"
MEMORY, EVENT, BOTH_WAYS = "memory", "event", "both ways"
DOORBELL = 0
_NUMBER = struct.Struct("<I")
_items = msgspec.msgpack.Decoder(list[tuple[str, int, str]])


def framed(letter: bytes, content: bytes = b"") -> bytes:
    """Bytes to send."""
    return LENGTH.pack(1 + len(content)) + letter + content


def numbered(letter: bytes, number: int) -> bytes:
    """Bytes to send."""
    return framed(letter, _NUMBER.pack(number))


def number_in(payload: bytes) -> int:
    """Raises BadMessage."""
    if len(payload) != 1 + _NUMBER.size:
        raise BadMessage(f"{payload[:1]!r} of {len(payload)} bytes: {1 + _NUMBER.size}")
    return int(_NUMBER.unpack_from(payload, 1)[0])


def passed(items: list[tuple[str, int, str]]) -> bytes:
    """Bytes to send: kind, an event's number, a memory's file."""
    return framed(PASSED, msgspec.msgpack.encode(items))


def items_in(payload: bytes) -> list[tuple[str, int, str]]:
    """Raises BadMessage."""
    try:
        return _items.decode(payload[1:])
    except (msgspec.MsgspecError, ValueError) as error:
        raise BadMessage(f"memory and events in {len(payload)} bytes: {error}") from None
