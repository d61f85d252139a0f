"""Words of a command line: a mistake shows the usage of the verb that it was made in, however deep that is."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

TIMES = {
    "real": "as the clock goes",
    "fast": "with the clock while buses rest, without waiting while they work",
    "lockstep": "virtual, and one for all programs that take part (CANWIRE_TIMED=1), who run in turns",
    "virtual": "without waiting, the same every time",
}


class Parser(argparse.ArgumentParser):
    """argparse lets the topmost parser complain of words that a verb does not know; here the verb does."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        found, unknown = super().parse_known_args(args, namespace)
        if unknown and self._subparsers is None:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return found, unknown


def add_time_argument(parser: argparse._ActionsContainer, offered: Sequence[str], why_not: str) -> None:
    """--time, by the same names in every verb; the first one `offered` is the default.

    A name that means something elsewhere is refused with `why_not`.
    """

    def name(text: str) -> str:
        if text in TIMES and text not in offered:
            raise argparse.ArgumentTypeError(f"{text}: {why_not}; {' or '.join(offered)}")
        if text not in offered:
            raise argparse.ArgumentTypeError(f"{text!r}: {' or '.join(offered)}")
        return text

    meanings = "; ".join(f"{one}: {TIMES[one]}" for one in offered)
    parser.add_argument(
        "--time", type=name, metavar=f"{{{','.join(offered)}}}", help=f"{meanings} (default: {offered[0]})"
    )
