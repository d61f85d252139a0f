"""`--db FILE` and the options for reading it; some verbs accept several files, each for a channel."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from canwire import Frame, LinFrame

if TYPE_CHECKING:
    from canwire import Database, DecodedMessage

KINDS = "DBC, KCD, SYM, ARXML or LDF file"
_OF_CHANNEL = re.compile(r"([A-Za-z0-9_.:-]{2,})=(.+)")  # two letters: C:\car.dbc is no channel


class _Once(argparse.Action):
    """Refuses a second --db instead of replacing the first."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option: Any = None) -> None:
        if getattr(namespace, self.dest) is not None:
            parser.error(
                f"{option}: one file only for this verb, not {getattr(namespace, self.dest)} and {values}"
            )
        setattr(namespace, self.dest, values)


def add_database_argument(
    parser: argparse._ActionsContainer, what: str, *, several: bool = False, required: bool = False
) -> None:
    """Add --db, --no-strict and --encoding; with `several`, --db may be repeated and given as CHANNEL=FILE."""
    if several:
        parser.add_argument(
            "--db",
            metavar="[CHANNEL=]FILE",
            action="append",
            default=[],
            required=required,
            help=f"a {KINDS}: {what}; may be given several times, also for one channel: can0=car.dbc",
        )
    else:
        parser.add_argument(
            "--db", metavar="FILE", action=_Once, required=required, help=f"a {KINDS}: {what}"
        )
    add_reading_arguments(parser)


def add_reading_arguments(parser: argparse._ActionsContainer) -> None:
    """Add --no-strict and --encoding."""
    parser.add_argument(
        "--no-strict", action="store_true", help="also accept a file with signals that overlap or do not fit"
    )
    parser.add_argument("--encoding", metavar="NAME", help="encoding of the file: cp1252, utf-8, gbk")


def database_of(arguments: argparse.Namespace) -> Database | None:
    """The database of --db, None without --db; raises BadDescription, ExtraMissing."""
    return None if arguments.db is None else loaded(arguments.db, arguments)


def databases_of(arguments: argparse.Namespace) -> Databases | None:
    """The databases of all --db options, None without any; raises BadDescription, ExtraMissing, BadValue."""
    if not arguments.db:
        return None
    found = []
    for text in arguments.db:
        told = _OF_CHANNEL.fullmatch(text)
        channel, path = (told[1], told[2]) if told else ("", text)
        found.append((channel, loaded(path, arguments)))
    return Databases(found)


class Databases:
    """Several databases, each for the channel of that name, or for all channels where the name is ""."""

    def __init__(self, found: Sequence[tuple[str, Database]]) -> None:
        self._found = list(found)

    def of(self, channel: str) -> list[Database]:
        """The databases for this channel: first those for it alone, then those for all channels."""
        own = [database for name, database in self._found if name == channel and name]
        return own + [database for name, database in self._found if not name]

    @property
    def pairs(self) -> list[tuple[str, Database]]:
        """Each database with its channel ("" for all), in the order of the command line."""
        return list(self._found)

    @property
    def all(self) -> list[Database]:
        """All databases, in the order of the command line."""
        return [database for _, database in self._found]

    def decode(self, frame: Frame | LinFrame, channel: str = "") -> DecodedMessage | None:
        """Decode with the first of the channel's files that knows the frame; None if none does."""
        for database in self.of(channel):
            message = database.decode(frame)
            if message is not None:
                return message
        return None

    def knowing(self, frame: Frame, channel: str) -> Database:
        """The first of the channel's files that knows this frame; one of them must."""
        return next(one for one in self.of(channel) if one.message_of(frame) is not None)

    def ids_of(self, names: Sequence[str], channel: str) -> list[tuple[int, int, bool]]:
        """Identifier, mask and whether it has 29 bits, for each message, as in the channel's first file that has it.

        Raises BadValue, with similar names, for a message that no file of any channel contains.
        """
        found: list[tuple[int, int, bool]] = []
        for name in names:
            if not any(name in database.messages for database in self.all):
                self.all[0].message(name)
            those = [database for database in self.of(channel) if name in database.messages]
            found += [one for database in those[:1] for one in database.id_masks(name)]
        return found


def loaded(path: str, arguments: argparse.Namespace) -> Database:
    """Load this file with the options of the command line; raises BadDescription, ExtraMissing."""
    from canwire import load_database

    return load_database(path, encoding=arguments.encoding, strict=not arguments.no_strict)
