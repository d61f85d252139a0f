"""What the verbs do alike on a terminal."""

from __future__ import annotations

import signal
import sys
from contextlib import ExitStack, suppress


def complain(what: str) -> None:
    """One line for people, beside the output."""
    print(f"canwire: {what}", file=sys.stderr, flush=True)


def let_terminate(closing: ExitStack) -> None:
    """SIGTERM ends like Ctrl-C, with the numbers; only a main thread may ask for that."""
    with suppress(ValueError):
        closing.callback(
            signal.signal, signal.SIGTERM, signal.signal(signal.SIGTERM, signal.default_int_handler)
        )
