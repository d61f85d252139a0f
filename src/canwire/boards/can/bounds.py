"""A line's filter as one pattern for each frame format, for a controller that has a hardware filter."""

from __future__ import annotations

from canwire.boards.can.message_filter import FormatFilter
from canwire.boards.can.modes import FilterMode

_SHUT = 1 << 31  # a pattern's bit that no frame has


def bounds(found: FormatFilter) -> tuple[int, int] | None:
    """(code, mask) of a pattern, in the form id << 1 | remote, that all passing frames match; None: no frame passes.

    A mask bit of 1 compares. Other frames may match the pattern as well.
    """
    if found.mode == FilterMode.LOCK:
        return None
    if found.mode != FilterMode.INCLUSIVE:
        return 0, 0
    full = (1 << found.width) - 1
    patterns = [(value, full) for value in found.listed]
    if not found.code & found.mask & _SHUT:
        patterns.append((found.code & full, found.mask & full))
    if not patterns:
        return None
    code, mask = patterns[0]
    for other, compared in patterns[1:]:
        mask &= compared & ~(code ^ other)
    return code & mask, mask
