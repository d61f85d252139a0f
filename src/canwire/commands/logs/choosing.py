"""--filter and --map of the verbs that read logs: which entries, and the names of channels."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from canwire import EXTENDED, BadValue, LogBatch, LogKind
from canwire.commands.dump.filters import Masked, Span, parse_capture

if TYPE_CHECKING:
    import numpy


def add_filter_argument(parser: argparse._ActionsContainer) -> None:
    """Add --filter."""
    parser.add_argument(
        "--filter",
        action="append",
        default=[],
        metavar="ID:MASK",
        help="only these frames: ID, FIRST-LAST, ID:MASK, ~ID for all others; of several, one must match",
    )


def add_map_argument(parser: argparse._ActionsContainer, what: str) -> None:
    """Add --map."""
    parser.add_argument("--map", action="append", default=[], metavar="CHANNEL=NAME", help=what)


def parsed_map(texts: Sequence[str]) -> dict[str, str]:
    """The pairs of every --map, which may hold several with commas between them; raises BadValue."""
    return parsed_maps(texts, 1)[0]


def parsed_maps(texts: Sequence[str], logs: int) -> list[dict[str, str]]:
    """The pairs for each of `logs` logs: `can0=can1` is for all, `2:can0=can1` for the second. Raises BadValue."""
    found: list[dict[str, str]] = [{} for _ in range(logs)]
    for part in (part for text in texts for part in text.split(",")):
        number, colon, pair = part.partition(":") if logs > 1 else ("", "", part)
        if not (colon and number.isdecimal()):
            number, pair = "", part
        channel, equals, name = pair.partition("=")
        if not (channel and equals and name):
            raise BadValue(f"--map {part!r}: a channel of the log and a name, can0=can1")
        if number and not 1 <= int(number) <= logs:
            raise BadValue(f"--map {part}: there are the logs 1 to {logs}")
        for names in found[int(number) - 1 : int(number)] if number else found:
            if names.setdefault(channel, name) != name:
                raise BadValue(f"--map {part}: {channel} is {names[channel]} already")
    return found


def chosen_by(texts: Sequence[str]) -> Callable[[LogBatch], LogBatch] | None:
    """A function that keeps the frames of --filter in a batch, and all other entries; None without filters."""
    capture = parse_capture(texts, (), False)
    if not capture.filters:
        return None

    def choose(batch: LogBatch) -> LogBatch:
        records = batch.records
        met = [_accepted(each, records) for each in capture.filters]
        passes = met[0]
        for each in met[1:]:
            passes = passes & each if capture.joined else passes | each
        keep = passes | (records["kind"] != LogKind.CAN_FRAME)
        return LogBatch(records[keep], batch.channels)

    return choose


def _accepted(each: Masked | Span, records: numpy.ndarray) -> Any:
    ids = records["id"]
    if isinstance(each, Span):
        met = (ids >= each.first) & (ids <= each.last)
    else:
        met = (ids ^ each.code) & each.mask == 0
    return (met & ((records["info"] & EXTENDED != 0) == each.extended)) != each.inverted
