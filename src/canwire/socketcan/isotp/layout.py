"""ISO-TP's four kinds of frames as bytes of data.

Source: ISO 15765-2:2016 9.6; padding is that of the kernel (linux/can/isotp.h).
"""

from __future__ import annotations

from canwire.socketcan.isotp.options import (
    CHK_PAD_DATA,
    CHK_PAD_LEN,
    LENGTHS,
    RX_PADDING,
    TX_PADDING,
    USUAL_PAD,
    Options,
)

SINGLE, FIRST, CONSECUTIVE, FLOW_CONTROL = 0x00, 0x10, 0x20, 0x30
CONTINUE, WAIT, OVERFLOW = 0, 1, 2
_LONGEST_SHORT = 4095  # length of a message that 12 bits can tell
_CLASSIC = 8
_STEPS_OF_100_US = range(0xF1, 0xFA)


def single(options: Options, data: bytes) -> bytes | None:
    """The whole message in one frame; None if it does not fit."""
    ahead = options.extended
    if len(data) <= _CLASSIC - 1 - ahead:
        return _padded(options, bytes((SINGLE | len(data),)) + data)
    if options.length > _CLASSIC and len(data) <= options.length - 2 - ahead:
        return _padded(options, bytes((SINGLE, len(data))) + data)
    return None


def first(options: Options, data: bytes) -> tuple[bytes, int]:
    """The first frame of a message, and the number of the message's bytes in it."""
    size = len(data)
    if size <= _LONGEST_SHORT:
        head = bytes((FIRST | size >> 8, size & 0xFF))
    else:
        head = bytes((FIRST, 0)) + size.to_bytes(4, "big")
    room = options.length - options.extended - len(head)
    return _padded(options, head + data[:room]), room


def consecutive(options: Options, number: int, data: bytes) -> tuple[bytes, int]:
    """The next frame, and the number of the message's bytes in it; `number` counts from 1."""
    room = options.length - options.extended - 1
    part = data[:room]
    return _padded(options, bytes((CONSECUTIVE | number & 0xF,)) + part), len(part)


def flow_control(options: Options, status: int) -> bytes:
    """The flow control that this side sends, with the padding for received messages."""
    body = bytes((FLOW_CONTROL | status, options.block_size, options.stmin))
    body = _address(options) + body
    return body.ljust(_CLASSIC, bytes((options.rx_pad,))) if options.flags & RX_PADDING else body


def gap_ns(stmin: int) -> int:
    """The separation time that a flow control requests; reserved values mean the longest (ISO 15765-2 9.6.5.4)."""
    if stmin <= 0x7F:
        return stmin * 1_000_000
    return (stmin - 0xF0) * 100_000 if stmin in _STEPS_OF_100_US else 127_000_000


def well_padded(options: Options, frame: bytes, used: int) -> bool:
    """True if the bytes after the first `used` ones of a received frame are the padding that this socket requires."""
    if not options.flags & (CHK_PAD_LEN | CHK_PAD_DATA):
        return True
    wanted = _fitting(used)
    if not options.flags & RX_PADDING:
        return len(frame) == (used if used <= _CLASSIC else wanted)
    if options.flags & CHK_PAD_LEN and len(frame) != max(_CLASSIC, wanted):
        return False
    return not options.flags & CHK_PAD_DATA or all(byte == options.rx_pad for byte in frame[used:])


def _padded(options: Options, body: bytes) -> bytes:
    body = _address(options) + body
    if options.flags & TX_PADDING:
        return body.ljust(_fitting(max(_CLASSIC, len(body))), bytes((options.tx_pad,)))
    return body.ljust(_fitting(len(body)), bytes((USUAL_PAD,)))


def _address(options: Options) -> bytes:
    return bytes((options.address,)) if options.extended else b""


def _fitting(size: int) -> int:
    """The next length that a frame can have."""
    return size if size <= _CLASSIC else next(length for length in LENGTHS if length >= size)
