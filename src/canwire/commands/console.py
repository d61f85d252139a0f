"""Functions of all verbs for output on a terminal."""

from __future__ import annotations

import sys


def complain(what: str) -> None:
    """One line for people, beside the output."""
    print(f"canwire: {what}", file=sys.stderr, flush=True)
