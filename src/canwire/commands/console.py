"""What the verbs do alike on a terminal."""

from __future__ import annotations

import signal
import sys
from contextlib import ExitStack, suppress


def complain(what: str) -> None:
    """One line for people, beside the output."""
    print(f"canwire: {what}", file=sys.stderr, flush=True)


def let_terminate(closing: ExitStack) -> None:
    """SIGTERM, and the end of the terminal, end like Ctrl-C, with the numbers; only a main thread may ask for that."""
    with suppress(ValueError):
        for number in ending_signals() - {signal.SIGINT}:
            closing.callback(signal.signal, number, signal.signal(number, signal.default_int_handler))


def ending_signals() -> set[int]:
    """What ends a program in an orderly way: also that its terminal is gone, unless it was started by nohup."""
    numbers = {signal.SIGTERM, signal.SIGINT}
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        numbers.add(signal.SIGHUP)
    return {int(number) for number in numbers}
