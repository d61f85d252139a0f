"""A J1939 message, and the 29-bit identifier of a frame that carries one.

Source: SAE J1939-21 5.2 (protocol data unit), linux/can/j1939.h.
"""

from __future__ import annotations

from dataclasses import dataclass

NO_ADDRESS, IDLE_ADDRESS, LARGEST_ADDRESS = 0xFF, 0xFE, 0xFD  # 0xFF: everybody, as a destination
NO_NAME = 0
NO_PGN, LARGEST_PGN, LARGEST_PDU1 = 0x40000, 0x3FFFF, 0x3FF00
REQUEST, ADDRESS_CLAIMED = 0xEA00, 0xEE00
LARGEST_SINGLE = 8  # bytes of a message that is one frame
USUAL_PRIORITY = 6


@dataclass(frozen=True)
class Message:
    """Names are 0 if unknown; `pgn` has no destination in it."""

    pgn: int
    source: int
    destination: int
    data: bytes
    priority: int = USUAL_PRIORITY
    source_name: int = NO_NAME
    destination_name: int = NO_NAME

    @property
    def is_broadcast(self) -> bool:
        return not self.destination_name and self.destination == NO_ADDRESS

    @property
    def requests_claims(self) -> bool:
        """True if it requests the address claims of all controllers."""
        asked = int.from_bytes(self.data[:3], "little")
        return self.pgn == REQUEST and len(self.data) >= 3 and asked == ADDRESS_CLAIMED

    @property
    def identifier(self) -> int:
        """The 29-bit identifier of its frame."""
        place = self.pgn & LARGEST_PGN
        if has_destination(self.pgn):
            place = self.pgn & LARGEST_PDU1 | self.destination
        return self.priority << 26 | place << 8 | self.source


def has_destination(pgn: int) -> bool:
    """True for PDU format 1: the low byte of the PGN in the identifier is a destination."""
    return pgn & 0xFF00 < 0xF000


def is_one_s(address: int) -> bool:
    """True for an address that a single controller may have."""
    return address <= LARGEST_ADDRESS


def message_of(identifier: int, data: bytes) -> Message:
    """The message in a frame with this identifier; its names are not known yet."""
    pgn, destination = identifier >> 8 & LARGEST_PGN, NO_ADDRESS
    if has_destination(pgn):
        pgn, destination = pgn & LARGEST_PDU1, pgn & 0xFF
    return Message(pgn, identifier & 0xFF, destination, data, identifier >> 26 & 7)
