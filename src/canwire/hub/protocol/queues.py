"""The places of a channel's queues in the memory that hub and client share."""

from __future__ import annotations

from canwire.ring import ring_size, rounded_capacity

_LINE = 64  # bytes of a cache line: what two processes write never shares one


def transmit_offset(receive: int) -> int:
    """Return the byte at which the transmit ring begins: after a receive ring for this many frames."""
    return -(-ring_size(rounded_capacity(receive)) // _LINE) * _LINE
