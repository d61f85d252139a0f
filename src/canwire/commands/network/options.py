"""How a hub is offered to other machines: the same options for `canwire offer` and `canwire serve --network`."""

from __future__ import annotations

import argparse

_EACH = ("realm", "name", "access", "age", "silence")
_MANY = ("listen", "via", "relay")


def add_offer_arguments(parser: argparse._ActionsContainer) -> None:
    """Add the options for the endpoints, the names and the access of an offered hub."""
    parser.add_argument("--realm", metavar="NAME", help="first part of the hub's address (default: canwire)")
    parser.add_argument("--name", metavar="NAME", help="the hub's name (default: this machine's)")
    parser.add_argument(
        "--listen",
        action="append",
        metavar="ENDPOINT",
        help="listen at tcp/ADDRESS:PORT or tls/ADDRESS:PORT (default: tcp/127.0.0.1:7449)",
    )
    parser.add_argument("--via", action="append", metavar="ENDPOINT", help="connect to this Zenoh router")
    parser.add_argument(
        "--relay",
        action="append",
        metavar="ENDPOINT",
        help="also listen for relays, at tcp/ADDRESS:PORT (see canwire relay)",
    )
    parser.add_argument(
        "--access", metavar="FILE", help="file of users, their rights, and certificates (TOML)"
    )
    parser.add_argument(
        "--age",
        type=_seconds,
        metavar="SECONDS",
        help="refuse commands that were sent longer ago (default: 2; 0: no limit)",
    )
    parser.add_argument(
        "--silence",
        type=_span,
        metavar="SECONDS",
        help="in lockstep mode: drop a program after this time without a message from it (default: 30)",
    )
    parser.add_argument(
        "--insecure", action="store_true", help="give full access to all who can reach an endpoint"
    )


def _seconds(text: str) -> str:
    """Return the text unchanged, for another process; raises an error if it is not a number from 0 to 3600."""
    if not 0 <= float(text) <= 3600:
        raise argparse.ArgumentTypeError(f"{text}: 0 to 3600 seconds")
    return text


def _span(text: str) -> str:
    if not 1 <= float(text) <= 3600:
        raise argparse.ArgumentTypeError(f"{text}: 1 to 3600 seconds")
    return text


def words_of(arguments: argparse.Namespace) -> list[str]:
    """Return the given options as words for the command line of another process."""
    words = ["--insecure"] if arguments.insecure else []
    for option in _EACH:
        value = getattr(arguments, option)
        words += [f"--{option}", value] if value is not None else []
    for option in _MANY:
        for value in getattr(arguments, option) or ():
            words += [f"--{option}", value]
    return words


def given(arguments: argparse.Namespace) -> bool:
    """Whether any of these options was given."""
    return bool(words_of(arguments))
