"""Whether a connection that is gone was cut: then there was silence before, one way at least."""

from __future__ import annotations


def was_cut(silent_ns: int, lease_s: float) -> bool:
    """Nobody closed it: one end had not heard the other for that long already."""
    return silent_ns > lease_s * 1e9 / 2
