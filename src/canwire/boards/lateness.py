"""The warning about buses that cannot keep up with the clock."""

from __future__ import annotations

_NOTEWORTHY_NS = 100_000_000


def lateness_text(behind_ns: int, skipped_ns: int) -> str:
    """The delay as a sentence; "" if it is less than a tenth of a second.

    >>> lateness_text(250_000_000, 0)
    'bus time is 0.25 s behind the clock: the buses have more to do than this machine can simulate, or it was stopped'
    """
    told = []
    if behind_ns >= _NOTEWORTHY_NS:
        told.append(f"bus time is {behind_ns / 1e9:.2f} s behind the clock")
    if skipped_ns >= _NOTEWORTHY_NS:
        told.append(f"{skipped_ns / 1e9:.2f} s were left out since the hub began")
    if not told:
        return ""
    return f"{', '.join(told)}: the buses have more to do than this machine can simulate, or it was stopped"
