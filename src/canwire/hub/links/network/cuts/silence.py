"""Whether the network was cut before a connection ended: then at least one direction was silent before."""

from __future__ import annotations


def was_cut(silent_ns: int, lease_s: float) -> bool:
    """True if it was not closed: one end had received nothing from the other for that long already."""
    return silent_ns > lease_s * 1e9 / 2
