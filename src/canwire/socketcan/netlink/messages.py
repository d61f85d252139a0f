"""Netlink messages and attributes as bytes.

Source: linux/netlink.h, linux/rtnetlink.h, RFC 3549.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

ERROR, DONE = 2, 3
NEW_LINK, DELETE_LINK, GET_LINK, SET_LINK = 16, 17, 18, 19
MULTI, ACKNOWLEDGE, DUMP, WITH_ATTRIBUTES = 0x2, 0x4, 0x300, 0x200  # the last one of answers
_HEADER = struct.Struct("<IHHII")
_ATTRIBUTE = struct.Struct("<HH")
_NESTED = 0x3FFF  # of a kind: without NLA_F_NESTED and NLA_F_NET_BYTEORDER
_WORD = struct.Struct("<i")
_TEXT = 1  # NLMSGERR_ATTR_MSG


class Request(NamedTuple):
    """`whole` is the message with its header."""

    kind: int
    flags: int
    sequence: int
    body: bytes
    whole: bytes

    @property
    def dumps(self) -> bool:
        return self.flags & DUMP == DUMP


def requests_in(data: bytes) -> Iterator[Request]:
    """The complete messages in these bytes; an incomplete one is ignored."""
    while len(data) >= _HEADER.size:
        length, kind, flags, sequence, _ = _HEADER.unpack_from(data)
        if not _HEADER.size <= length <= len(data):
            return
        yield Request(kind, flags, sequence, data[_HEADER.size : length], data[:length])
        data = data[_aligned(length) :]


def message(kind: int, flags: int, sequence: int, port: int, body: bytes) -> bytes:
    """The bytes of a message, padded so that others can follow."""
    length = _HEADER.size + len(body)
    return _HEADER.pack(length, kind, flags, sequence, port) + body + bytes(-length % 4)


def readdressed(data: bytes, port: int) -> bytes:
    """The same messages, as answers to this port."""
    return b"".join(message(one.kind, one.flags, one.sequence, port, one.body) for one in requests_in(data))


def answer_to(request: Request, port: int, error: int, text: str = "") -> bytes:
    """NLMSG_ERROR: an errno, or 0; the text is for the user."""
    told = attribute(_TEXT, text.encode() + b"\0") if text else b""
    flags = WITH_ATTRIBUTES if told else 0
    whole = request.whole + bytes(-len(request.whole) % 4)
    return message(ERROR, flags, request.sequence, port, _WORD.pack(-error) + whole + told)


def attribute(kind: int, value: bytes) -> bytes:
    length = _ATTRIBUTE.size + len(value)
    return _ATTRIBUTE.pack(length, kind) + value + bytes(-length % 4)


def attributes_in(data: bytes) -> dict[int, bytes]:
    """The attributes by kind, up to the first invalid one."""
    found: dict[int, bytes] = {}
    while len(data) >= _ATTRIBUTE.size:
        length, kind = _ATTRIBUTE.unpack_from(data)
        if not _ATTRIBUTE.size <= length <= len(data):
            break
        found[kind & _NESTED] = data[_ATTRIBUTE.size : length]
        data = data[_aligned(length) :]
    return found


def _aligned(length: int) -> int:
    return length + -length % 4
