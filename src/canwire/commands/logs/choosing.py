"""What of a log is meant: --filter and --map, as every verb has them that reads logs."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from canwire import EXTENDED, BadValue, LogBatch, LogKind
from canwire.commands.dump.filters import Filter, parse_filters

if TYPE_CHECKING:
    import numpy


def add_filter_argument(parser: argparse._ActionsContainer) -> None:
    """--filter."""
    parser.add_argument(
        "--filter",
        action="append",
        default=[],
        metavar="ID:MASK",
        help="these frames only, ID~MASK all others; again, or with commas: any of them; 8 digits: extended",
    )


def add_map_argument(parser: argparse._ActionsContainer, what: str) -> None:
    """--map."""
    parser.add_argument("--map", action="append", default=[], metavar="CHANNEL=NAME", help=what)


def parsed_map(texts: Sequence[str]) -> dict[str, str]:
    """The pairs of every --map, which may hold several with commas between them; raises BadValue."""
    found: dict[str, str] = {}
    for part in (part for text in texts for part in text.split(",")):
        channel, equals, name = part.partition("=")
        if not (channel and equals and name):
            raise BadValue(f"--map {part!r}: a channel of the log and a name, can0=can1")
        if found.setdefault(channel, name) != name:
            raise BadValue(f"--map {part}: {channel} is {found[channel]} already")
    return found


def chosen_by(texts: Sequence[str]) -> Callable[[LogBatch], LogBatch] | None:
    """What leaves only the frames of --filter in a batch, and all that is no frame; None without filters."""
    filters = parse_filters(texts)
    if not filters:
        return None

    def choose(batch: LogBatch) -> LogBatch:
        keep = batch.records["kind"] != LogKind.CAN_FRAME
        for each in filters:
            keep |= _accepted(each, batch.records)
        return LogBatch(batch.records[keep], batch.channels)

    return choose


def _accepted(each: Filter, records: numpy.ndarray) -> Any:
    extended = records["info"] & EXTENDED != 0
    met = (extended == each.extended) & ((records["id"] ^ each.code) & each.mask == 0)
    return (met != each.inverted) & (records["kind"] == LogKind.CAN_FRAME)
