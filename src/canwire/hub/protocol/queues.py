"""Where a channel's queues lie in the one memory that hub and client share."""

from __future__ import annotations

from canwire.ring import ring_size, rounded_capacity

_LINE = 64  # bytes of a cache line: what two processes write never shares one


def transmit_offset(receive: int) -> int:
    """The byte at which the transmit ring begins: behind a receive ring for so many frames."""
    return -(-ring_size(rounded_capacity(receive)) // _LINE) * _LINE
