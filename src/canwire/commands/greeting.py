"""The option --greeting-seconds of verbs that other programs connect to: how long a connection may stay silent."""

from __future__ import annotations

import argparse

_DEFAULT, _MOST = 30, 86_400  # as [limits] of canwire.toml has it for the hub itself


def add_greeting_argument(parser: argparse.ArgumentParser, until: str) -> None:
    """The option, for clients that are silent `until` something."""
    parser.add_argument(
        "--greeting-seconds",
        type=_seconds,
        default=_DEFAULT,
        metavar="N",
        help=f"close a connection that has not {until} within N seconds (default: {_DEFAULT})",
    )


def _seconds(text: str) -> int:
    if not (text.isdecimal() and 1 <= int(text) <= _MOST):
        raise argparse.ArgumentTypeError(f"{text!r}: a whole number of seconds from 1 to {_MOST}")
    return int(text)
