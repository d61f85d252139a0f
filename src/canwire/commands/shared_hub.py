"""The hub that the verbs share with other programs, and its lines by the name on a command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import canwire
from canwire import BadValue, HubError, LinePlace, find_lines

if TYPE_CHECKING:
    from canwire import Hub

_VERBS = {"CAN": "`canwire dump` or `canwire send`", "LIN": "`canwire lin dump` or `canwire lin send`"}


def add_hub_argument(parser: argparse._ActionsContainer, *, again: bool = False) -> None:
    """Add --hub, for each command that uses shared boards; `again` for a sub-verb whose verb has it, too."""
    parser.add_argument(
        "--hub",
        metavar="ADDRESS",
        default=argparse.SUPPRESS if again else None,
        help="the hub's socket, or zenoh://REALM/HOST (default: CANWIRE_HUB, or this user's socket)",
    )


def add_line_argument(parser: argparse.ArgumentParser, examples: str) -> None:
    """Add the argument LINE."""
    parser.add_argument("line", metavar="LINE", help=examples)


def add_rate_argument(parser: argparse.ArgumentParser, option: str, help: str, usual: int) -> None:
    """Add an option for a bit rate in bit/s, such as --bit-rate."""
    parser.add_argument(option, type=int, metavar="BIT/S", help=f"{help} (default: {usual})")


def connected(
    arguments: argparse.Namespace, verb: str, closing: ExitStack, *, timed: bool | None = False
) -> Hub:
    """Return the shared hub; raises HubError if none runs: no other program could use boards of this process.

    In a lockstep hub a verb only observes; a `timed` one takes part (None: if CANWIRE_TIMED says so).
    """
    hub: Hub = closing.enter_context(canwire.connect(arguments.hub, name=f"canwire {verb}", timed=timed))
    if not hub.address:
        raise HubError(f"no hub is running that `{verb}` could share; `canwire serve` starts one")
    watch = getattr(arguments, "watch", None)
    if watch is not None:  # reconnecting.py
        watch.found()
    return hub


def find_line(
    hub: Hub,
    name: str,
    *,
    to_send: bool = False,
    bus_type: str = "CAN",
    among: Sequence[LinePlace] | None = None,
) -> LinePlace:
    """Return the line of that name; for a bus's name the first line on it, or for sending the first unused one.

    `among` are the lines that `every_line` has found already.
    Raises NoSuchBoard, which names the existing lines, and BadValue for a line of another type.
    """
    places = find_lines(hub, name, among=among)
    place, there = places[0], places[0].info.bus_type
    if there != bus_type:
        raise BadValue(
            f"{name}: {place.address} is a {there} line; use {_VERBS.get(there, 'something else')}"
        )
    if not to_send or len(places) == 1:
        return place
    return next((place for place in places if not _used(hub, place)), place)


def _used(hub: Hub, place: LinePlace) -> bool:
    """Whether a program has the line's control or a channel on it."""
    if place.info.lin is not None:
        return bool(hub.lin_status(place.board.id, place.line).control_holder)
    status = place.status(hub)
    return bool(status.control_holder or status.channels)
