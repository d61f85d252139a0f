"""socketcand's commands and answers as text.

    < open can0 > < rawmode > < bcmmode > < controlmode > < echo > < statistics 1000 >
    < send 123 2 11 22 >  < sendrtr 123 2 >  < fdsend 123 1 12 00 ... >          identifier [flags] length bytes
    < add 0 20000 123 2 11 22 >  < update 123 2 11 22 >  < delete 123 >          seconds microseconds ...
    < isotpmode > < isotpconf 123 321 0 0 0 > < sendpdu 112233 >
    < can0 B 500000 875 -1 -1 -1 -1 -1 -1 > < can0 C 0 0 0 >                     before a bus is opened
    < filter 0 0 123 1 FF >  < muxfilter ... >  < subscribe 0 0 123 >  < unsubscribe 123 >

Eight hex digits make a 29-bit identifier. Source: linux-can/socketcand, doc/protocol.md, and for fdsend and fdframe,
which that leaves out, what its daemon accepts and sends.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence

from canwire import BadText
from canwire.socketcan.bcm.message import (
    RX_DELETE,
    RX_FILTER_ID,
    RX_SETUP,
    SETTIMER,
    STARTTIMER,
    TX_DELETE,
    TX_SEND,
    TX_SETUP,
    Message,
)
from canwire.socketcan.constants import (
    CAN_EFF_FLAG,
    CAN_EFF_MASK,
    CAN_ERR_FLAG,
    CAN_MTU,
    CAN_RTR_FLAG,
    CAN_SFF_MASK,
    CANFD_BRS,
    CANFD_ESI,
)

_CLASSIC, _FD = struct.Struct("<IB3x8s"), struct.Struct("<IBBxx64s")
_HEX_ID = re.compile(r"[0-9A-Fa-f]{1,8}")
_MICRO = 1_000_000
_LONGEST_S = 1 << 31
_MOST_MUX = 257


def sent_frame(words: Sequence[str]) -> bytes:
    """The struct can_frame or canfd_frame of a send, sendrtr or fdsend command. Raises BadText."""
    if words[0] == "fdsend":
        _count(words, 4, 4 + 64)
        can_id, flags = identifier(words[1]), number(words[2], 16, 0xFF)
        data = _data(words[3], words[4:], 64)
        return _FD.pack(can_id, len(data), flags & (CANFD_BRS | CANFD_ESI), data)
    if words[0] == "sendrtr":
        _count(words, 3, 3)
        return _CLASSIC.pack(identifier(words[1]) | CAN_RTR_FLAG, number(words[2], 10, 8), b"")
    _count(words, 3, 3 + 8)
    return _classic(words[1], words[2], words[3:])


def request(words: Sequence[str]) -> Message:
    """A command of the BCM mode as a request to the broadcast manager. Raises BadText for an unknown command."""
    name = words[0]
    if name == "send":
        frame = sent_frame(words)
        return Message(TX_SEND, 0, 0, 0.0, 0.0, _id_of(frame), (frame,))
    if name == "update":
        _count(words, 3, 3 + 8)
        frame = _classic(words[1], words[2], words[3:])
        return Message(TX_SETUP, 0, 0, 0.0, 0.0, _id_of(frame), (frame,))
    if name in ("delete", "unsubscribe"):
        _count(words, 2, 2)
        return Message(TX_DELETE if name == "delete" else RX_DELETE, 0, 0, 0.0, 0.0, identifier(words[1]))
    if name not in ("add", "filter", "subscribe", "muxfilter"):
        raise BadText(f"{name}: unknown command")
    _count(words, 4, 4 + _MOST_MUX * 8 + 1)
    interval_s = number(words[1], 10, _LONGEST_S) + number(words[2], 10, _MICRO - 1) / _MICRO
    can_id = identifier(words[3])
    if name == "subscribe":
        return Message(RX_SETUP, RX_FILTER_ID | SETTIMER, 0, 0.0, interval_s, can_id)
    if name == "muxfilter":
        return Message(RX_SETUP, SETTIMER, 0, 0.0, interval_s, can_id, _masks(words[4:]))
    frame = _classic(words[3], words[4] if len(words) > 4 else "", words[5:])
    if name == "filter":
        return Message(RX_SETUP, SETTIMER, 0, 0.0, interval_s, can_id, (frame,))
    return Message(TX_SETUP, SETTIMER | STARTTIMER, 0, 0.0, interval_s, can_id, (frame,))


def heard(frame: bytes, stamp_ns: int, *, apart: bool) -> str:
    """The text of a struct can_frame or canfd_frame for a client; bytes are `apart` in the BCM mode only."""
    can_id = int.from_bytes(frame[:4], "little")
    length = frame[4]
    time = time_of(stamp_ns)
    if can_id & CAN_ERR_FLAG:
        return f"< error {can_id & CAN_EFF_MASK:03X} {time} >"
    id = f"{can_id & CAN_EFF_MASK:08X}" if can_id & CAN_EFF_FLAG else f"{can_id & CAN_SFF_MASK:03X}"
    if can_id & CAN_RTR_FLAG:
        return f"< rtr {id} {time} {length} >"
    data = frame[8 : 8 + length]
    shown = "".join(f"{byte:02X} " for byte in data) if apart else data.hex().upper()
    if len(frame) == CAN_MTU:
        return f"< frame {id} {time} {shown} >"
    return f"< fdframe {id} {frame[5]:02X} {time} {shown} >"


def time_of(stamp_ns: int) -> str:
    """Seconds and microseconds."""
    seconds, micro = divmod(stamp_ns // 1000, _MICRO)
    return f"{seconds}.{micro:06d}"


def _classic(id: str, length: str, data: Sequence[str]) -> bytes:
    content = _data(length, data, 8)
    return _CLASSIC.pack(identifier(id), len(content), content)


def _masks(words: Sequence[str]) -> tuple[bytes, ...]:
    """Frames whose data are the masks of a muxfilter."""
    count = number(words[0] if words else "", 10, _MOST_MUX)
    if count < 2 or len(words) != 1 + 8 * count:
        raise BadText(
            f"muxfilter: {count} masks of 8 bytes need {8 * count} bytes, {len(words) - 1} are there"
        )
    content = bytes(number(word, 16, 0xFF) for word in words[1:])
    return tuple(_CLASSIC.pack(0, 8, content[at : at + 8]) for at in range(0, len(content), 8))


def _data(length: str, words: Sequence[str], most: int) -> bytes:
    count = number(length, 10, most)
    if len(words) != count:
        raise BadText(f"length {count}: {len(words)} data bytes are there")
    return bytes(number(word, 16, 0xFF) for word in words)


def identifier(word: str) -> int:
    """The identifier word, with the flag for the 29-bit format. Raises BadText."""
    if not _HEX_ID.fullmatch(word):
        raise BadText(f"identifier {word[:12]!r}: up to eight hex digits")
    value = int(word, 16)
    extended = len(word) == 8
    if value > (CAN_EFF_MASK if extended else CAN_SFF_MASK):
        raise BadText(f"identifier {word}: 11 bits, or eight digits for 29 bits")
    return value | (CAN_EFF_FLAG if extended else 0)


def number(word: str, base: int, most: int) -> int:
    """A number from 0 to `most`. Raises BadText."""
    try:
        value = int(word, base)
    except ValueError:
        raise BadText(f"{word[:12]!r}: no number") from None
    if not 0 <= value <= most:
        raise BadText(f"{word[:12]}: 0 to {most}")
    return value


def _id_of(frame: bytes) -> int:
    return int.from_bytes(frame[:4], "little")


def _count(words: Sequence[str], least: int, most: int) -> None:
    if not least <= len(words) <= most:
        raise BadText(f"{words[0]}: too {'few' if len(words) < least else 'many'} words")
