"""Reports the faults of a log on stderr."""

from __future__ import annotations

from canwire import Log, Trace
from canwire.commands.console import complain

_SHOWN = 10
_WIDEST = 200


def tell_faults(log: Log | Trace) -> None:
    """Report the first faults one by one, then the number of further ones."""
    for fault in log.faults[:_SHOWN]:
        complain(f"{log.path}: {clipped(str(fault))}")
    if log.fault_count > _SHOWN:
        complain(f"{log.path}: {log.fault_count - _SHOWN} more faults")


def clipped(what: str) -> str:
    """The text without control characters, fit for a terminal."""
    shown = "".join(one if one.isprintable() else "\N{REPLACEMENT CHARACTER}" for one in what)
    return shown if len(shown) <= _WIDEST else f"{shown[:_WIDEST]}..."
