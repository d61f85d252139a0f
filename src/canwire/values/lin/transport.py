"""LIN's transport layer: messages of up to 4095 bytes in diagnostic frames of eight. No I/O; callers pass the times.

A frame is NAD, PCI and six bytes: a single frame (up to 6 bytes), or a first frame (5 bytes) and consecutive ones
(6 bytes each, numbered 1 to 15, 0, 1 ...). It has no flow control; a wait that is too long ends the message.

Source: LIN 2.2A 3 (transport layer); reference/lin-protocol.md section 10.
"""

from __future__ import annotations

from typing import NamedTuple

from canwire.errors import BadValue

SLEEP_NAD = 0x00
FUNCTIONAL_NAD = 0x7E
BROADCAST_NAD = 0x7F
LONGEST_MESSAGE = 4095
TIMEOUT_NS = 1_000_000_000
"""N_As and N_Cr: until a frame that waits has gone out, and between consecutive frames."""
_SINGLE, _FIRST, _CONSECUTIVE = 0x00, 0x10, 0x20
_FILL = b"\xff"


class LinMessage(NamedTuple):
    """The content of the frames: `payload` is the service identifier (SID) and its data."""

    nad: int
    payload: bytes


def segments(nad: int, payload: bytes) -> list[bytes]:
    """The frames of a message, 8 bytes each. Raises BadValue for another length than 1 to 4095, or no NAD."""
    if not 0 <= nad <= 0xFF:
        raise BadValue(f"NAD {nad!r}: from 0 to 0xFF")
    if not 0 < len(payload) <= LONGEST_MESSAGE:
        raise BadValue(f"{len(payload)} bytes: a LIN message has 1 to {LONGEST_MESSAGE}")
    if len(payload) <= 6:
        return [_frame(nad, _SINGLE | len(payload), payload)]
    if nad == FUNCTIONAL_NAD:
        raise BadValue(
            f"{len(payload)} bytes to NAD 0x7E: a functional request is a single frame of 6 at most"
        )
    length = len(payload)
    frames = [_frame(nad, _FIRST | length >> 8, bytes([length & 0xFF]) + payload[:5])]
    for number, start in enumerate(range(5, length, 6), 1):
        frames.append(_frame(nad, _CONSECUTIVE | number & 0xF, payload[start : start + 6]))
    return frames


def _frame(nad: int, pci: int, data: bytes) -> bytes:
    return bytes([nad, pci]) + data.ljust(6, _FILL)


class LinReassembly:
    """Assembles messages from frames; `dropped` counts incomplete messages.

    `timeout_ns` is N_Cr. A frame of a message that is wrong (sequence, length, too late) ends it without a message.
    """

    def __init__(self, timeout_ns: int = TIMEOUT_NS) -> None:
        self.timeout_ns = timeout_ns
        self.dropped = 0
        self._nad = -1
        self._length = 0
        self._number = 0
        self._payload = bytearray()
        self._last_ns = 0

    @property
    def receiving(self) -> bool:
        """True while a message has begun and is not complete."""
        return self._length > 0

    def drop(self) -> None:
        """Discard the message that has begun."""
        if self._length:
            self.dropped += 1
            self._length = 0

    def frame(self, data: bytes, at_ns: int) -> LinMessage | None:
        """Process one frame (8 bytes) received at this time; returns the message that it completes."""
        nad, pci = data[0], data[1]
        kind = pci & 0xF0
        if kind == _CONSECUTIVE:
            return self._consecutive(nad, pci & 0xF, data, at_ns)
        if nad == FUNCTIONAL_NAD and kind == _SINGLE:
            return _single(nad, pci, data)  # does not touch what is under way
        self.drop()
        if kind == _SINGLE:
            return _single(nad, pci, data)
        length = (pci & 0xF) << 8 | data[2]
        if kind == _FIRST and length > 6 and nad != FUNCTIONAL_NAD:
            self._nad, self._length, self._number = nad, length, 0
            self._payload = bytearray(data[3:8])
            self._last_ns = at_ns
        else:
            self.dropped += 1
        return None

    def _consecutive(self, nad: int, number: int, data: bytes, at_ns: int) -> LinMessage | None:
        if not self._length or nad != self._nad:
            return None
        if number != (self._number + 1) & 0xF or at_ns - self._last_ns > self.timeout_ns:
            self.drop()
            return None
        self._number = number
        self._last_ns = at_ns
        self._payload += data[2:8]
        if len(self._payload) < self._length:
            return None
        payload, self._length = bytes(self._payload[: self._length]), 0
        return LinMessage(nad, payload)


def _single(nad: int, pci: int, data: bytes) -> LinMessage | None:
    length = pci & 0xF
    return LinMessage(nad, data[2 : 2 + length]) if 1 <= length <= 6 else None


class LinTransmission:
    """A message whose frames are fetched in order; discarded if a frame waits longer than N_As."""

    def __init__(self, message: LinMessage, ready_ns: int, timeout_ns: int = TIMEOUT_NS) -> None:
        self.timeout_ns = timeout_ns
        self.ready_ns = ready_ns
        self._frames = segments(*message)
        self._next = 0
        self._since_ns = ready_ns

    @property
    def expires_ns(self) -> int:
        """The time at which it is discarded if the waiting frame is not fetched."""
        return self._since_ns + self.timeout_ns

    def waiting(self, at_ns: int) -> bytes | None:
        """The frame to answer with; None before it is ready, after the last one, and once it was discarded."""
        if self._next == len(self._frames) or not self.ready_ns <= at_ns <= self.expires_ns:
            return None
        return self._frames[self._next]

    def fetched(self, at_ns: int) -> None:
        """Called when the waiting frame was sent."""
        self._next += 1
        self._since_ns = at_ns
