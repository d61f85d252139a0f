"""Messages on a command line: `EngineData EngineSpeed=1500 Ready=yes`."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from canwire import BadText, BadValue, Frame, parse_frame
from canwire.commands.databases.chosen import add_database_argument

if TYPE_CHECKING:
    from canwire import Database
    from canwire.commands.databases.plugins import Plugin

Value = int | float | str


def add_database_arguments(parser: argparse._ActionsContainer, what: str) -> None:
    """Add --db and --fill."""
    add_database_argument(parser, what)
    parser.add_argument(
        "--fill",
        type=float,
        metavar="VALUE",
        help="value of signals that are neither given nor have a start value in the file (limited to their range)",
    )


def add_plugin_argument(parser: argparse._ActionsContainer, what: str) -> None:
    """Add --plugin."""
    parser.add_argument("--plugin", action="append", default=[], metavar="MODULE:FUNCTION", help=what)


def frames_of(words: Sequence[str], database: Database | None, fill: float | None) -> list[Frame]:
    """Frames as text and, with a description, also messages with their signals; raises BadText, BadValue."""
    if database is None:
        return [_parsed(word) for word in words]
    frames: list[Frame] = []
    for group in _groups(words):
        frames.append(parse_frame(group[0]) if "#" in group[0] else _encoded(database, group, fill))
    return frames


def numbered_frames_of(
    words: Sequence[str], database: Database | None, fill: float | None, plugins: Sequence[Plugin]
) -> list[Callable[[int], Frame]]:
    """The same for each round of a repeated list: counters and checksums, by plug-ins and the file, continue.

    Raises BadText, BadValue.
    """
    frames = frames_of(words, database, fill)
    if database is None:
        return [partial(_same, frame) for frame in frames]
    named = [group[0] if "#" not in group[0] else "" for group in _groups(words)]
    times = Counter(named)
    return [
        partial(_finished, database, frame, plugins, times[name], named[:at].count(name))
        if name
        else partial(_same, frame)
        for at, (frame, name) in enumerate(zip(frames, named, strict=True))
    ]


def _same(frame: Frame, number: int) -> Frame:
    del number
    return frame


def _finished(
    database: Database, frame: Frame, plugins: Sequence[Plugin], times: int, place: int, number: int
) -> Frame:
    """The message's frame in round `number`, which has it `times` times."""
    from canwire import OutgoingMessage  # which loads what reads databases

    count = number * times + place
    message = database.decode(frame)
    if plugins and message is not None:
        outgoing = OutgoingMessage(database, message.name, count, dict(message.signals), 0)
        for plugin in plugins:
            plugin(outgoing)
        made = outgoing.frame()
        assert isinstance(made, Frame)  # `frames_of` has refused LIN frames
        frame = made
    return database.protect(frame, count)


def split(word: str) -> tuple[str, str]:
    """Both sides of Signal=value; raises BadText."""
    name, equals, text = word.partition("=")
    if not equals or not name or not text:
        raise BadText(f"{word!r}: Signal=value is needed")
    return name, text


def _parsed(word: str) -> Frame:
    try:
        return parse_frame(word)
    except BadText as error:
        if "#" in word:
            raise
        raise BadText(f"{error}; for a message by its name give --db FILE") from None


def _groups(words: Sequence[str]) -> list[list[str]]:
    """Each frame or message with what follows it."""
    groups: list[list[str]] = []
    for word in words:
        if "=" not in word or "#" in word:
            groups.append([word])
        elif groups and "#" not in groups[-1][0]:
            groups[-1].append(word)
        else:
            raise BadText(f"{word!r}: there is no message in front of it")
    return groups


def _encoded(database: Database, group: Sequence[str], fill: float | None) -> Frame:
    message = database.message(group[0])
    values: dict[str, Value] = {}
    for word in group[1:]:
        name, text = split(word)
        if name in values:
            raise BadText(f"{message.name}: {name} is given twice")
        values[name] = message.signals[name].parse(text) if name in message.signals else text
    frame = database.encode(message.name, values, fill=fill)
    if not isinstance(frame, Frame):
        raise BadValue(f"{message.name} is a LIN frame; use `canwire lin send`")
    return frame
