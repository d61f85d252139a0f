"""Suggests similar names."""

from __future__ import annotations

from collections.abc import Iterable

_SHOWN = 12


def near(wrong: str, names: Iterable[str]) -> str:
    """ "did you mean EngineData?", or the known names if none is similar."""
    from difflib import get_close_matches  # only where something went wrong

    by_lower = {name.lower(): name for name in names}
    close = [by_lower[found] for found in get_close_matches(wrong.lower(), by_lower, n=3)]
    if close:
        return f"did you mean {' or '.join(close)}?"
    there = list(by_lower.values())
    more = f" and {len(there) - _SHOWN} more" if len(there) > _SHOWN else ""
    return f"there are {', '.join(there[:_SHOWN]) or 'none'}{more}"
