"""Spans of time as callers give them: seconds, checked, in nanoseconds."""

from __future__ import annotations

from canwire.errors import BadValue

LONGEST_NS = 1 << 62  # 146 years


def nanoseconds(name: str, seconds: float) -> int:
    """A span in whole nanoseconds; raises BadValue naming what is negative, not finite or beyond 146 years."""
    if not 0 <= seconds * 1e9 <= LONGEST_NS:
        raise BadValue(f"{name} {seconds}: a finite time, not negative, of at most 146 years")
    return round(seconds * 1e9)
