"""Functions of all verbs for output on a terminal."""

from __future__ import annotations

import sys


def complain(what: str) -> None:
    """Print one line on stderr, apart from the output."""
    print(f"canwire: {what}", file=sys.stderr, flush=True)
