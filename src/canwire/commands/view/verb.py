"""`canwire view`: a line as a table, one row per identifier.

canwire view can0                     count, period, data with changed bytes marked; until q or Ctrl-C
canwire view can0 --db car.dbc        with names and signals, by a database
canwire view any                      every bus of the hub
canwire view can0 --seconds 5 > file  plain lines, where output is no terminal (or with --plain), each second

Keys: space holds the table, / goes to the filter (123, 100-1FF, ~123, or part of a name), s saves what is shown as CSV
in the present folder, c counts from nothing, arrows move, q quits. A byte is marked for a second after it changed;
periods are in ms: the last, the shortest, the longest. The window needs canwire[tools] (Textual).
"""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadValue, EventKind, ExtraMissing
from canwire.commands.can_line import wanted_by
from canwire.commands.console import complain
from canwire.commands.databases.chosen import add_database_argument, databases_of
from canwire.commands.live.decoding import Decode
from canwire.commands.live.listening import (
    Listening,
    add_listening_arguments,
    complain_each,
    places_of,
)
from canwire.commands.reconnecting import add_reconnect_argument, going_on, not_if
from canwire.commands.shared_hub import connected
from canwire.commands.view.columns import format_row, texts_of
from canwire.commands.view.table import Table

if TYPE_CHECKING:
    from canwire import Hub

_AT_ONCE = 4096


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_listening_arguments(parser)
    add_database_argument(parser, "names and signals", several=True)
    parser.add_argument("--plain", action="store_true", help="lines in place of the window")
    parser.add_argument(
        "--interval", type=float, default=1.0, metavar="SECONDS", help="plain: between two looks (1)"
    )
    parser.add_argument("--seconds", type=float, metavar="SECONDS", help="plain: end after this long")
    add_reconnect_argument(parser, usual=True)


def run(arguments: argparse.Namespace) -> int:
    """Show the table until the user or the time ends it; raises BadValue, NoSuchBoard, HubError, ExtraMissing."""
    if not arguments.interval >= 0.05:
        raise BadValue(f"--interval {arguments.interval}: 0.05 seconds or more")
    if arguments.seconds is not None and not arguments.seconds >= 0:
        raise BadValue(f"--seconds {arguments.seconds}: 0 or more")
    not_if(arguments, arguments.seconds is not None, "--seconds")
    databases = databases_of(arguments)
    decode = None if databases is None else databases.decode
    table = Table()
    return going_on(arguments, lambda given: _view(given, table, decode))


def _view(arguments: argparse.Namespace, table: Table, decode: Decode | None) -> int:
    plain = (
        arguments.plain or arguments.seconds is not None or not (sys.stdout.isatty() and sys.stdin.isatty())
    )
    with ExitStack() as closing:
        hub = connected(arguments, "view", closing)
        places = places_of(hub, arguments.lines, getattr(arguments, "watch", None))
        events = (int(EventKind.ERROR),)
        listening = closing.enter_context(Listening(hub, places, wanted_by(arguments), events=events))
        complain_each(listening.told)
        try:
            if plain:
                Plain(hub, listening, table, decode).run(arguments.interval, arguments.seconds)
                return 0
            return _window(listening, table, decode)
        finally:
            complain(
                f"{table.frames} frames of {len(table)} identifiers, {table.errors} errors, {_lost(listening)} lost"
            )


def _window(listening: Listening, table: Table, decode: Decode | None) -> int:
    try:
        from canwire.commands.view.screen import ViewScreen
    except ModuleNotFoundError:
        raise ExtraMissing("textual", "tools") from None
    screen = ViewScreen(listening, table, decode)
    screen.run()
    if screen.failure is not None:
        raise screen.failure
    return screen.return_code or 0


def _lost(listening: Listening) -> str:
    from canwire import HubError

    try:
        return str(sum(listening.counted(source).lost for source in listening.sources))
    except HubError:
        return "unknown"


class Plain:
    """Prints, at each interval, the rows that had frames since the previous one."""

    def __init__(self, hub: Hub, listening: Listening, table: Table, decode: Decode | None) -> None:
        self._hub = hub
        self._listening = listening
        self._table = table
        self._decode = decode
        self._counts: dict[object, int] = {}

    def run(self, interval_s: float, seconds: float | None) -> None:
        """Show the table until the time is over (None: without end)."""
        end_s = None if seconds is None else self._now_s() + seconds
        due_s = self._now_s() + interval_s
        while end_s is None or self._now_s() < end_s:
            until_s = due_s if end_s is None else min(due_s, end_s)
            while (left_s := until_s - self._now_s()) > 0:
                for source, records in self._listening.take(_AT_ONCE, left_s):
                    self._table.take(source.name, records)
            due_s += interval_s
            self._print()

    def _print(self) -> None:
        for row in self._table.rows:
            if self._counts.get(row.key) != row.count:
                self._counts[row.key] = row.count
                print(format_row(texts_of(row, self._decode)))
        sys.stdout.flush()

    def _now_s(self) -> float:
        return self._hub.now_ns() / 1e9 if self._hub.virtual else time.monotonic()
