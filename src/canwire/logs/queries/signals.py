"""Signals as tables: a query decodes, while it runs, only the signals that it uses.

`signals` joins frames with a small table of the database's messages. DuckDB converts a filter by message or signal
into a filter of the files by identifier, and only few row groups of a trace's file match. If several databases
define a frame, the first database of its channel is used, or else the first of those for all channels.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from canwire.databases.database import Database
from canwire.databases.description import MessageDescription
from canwire.databases.matching import Matching, key_of
from canwire.errors import BadValue
from canwire.logs.queries.decoding import SignalFunctions
from canwire.logs.queries.views import named, quoted
from canwire.logs.tables.arrow import load_pyarrow

_SIGNALS = """
select time_ns, time, channel, message, signal, value, signal_text(number, data) as text, unit, row from (
    select f.time_ns, f.time, f.channel, s.message, s.signal, signal_value(s.number, f.data) as value, s.unit,
        s.number, f.data, f.row
    from main.frames f join main.database_signals s on f.id = s.id and f.extended = s.extended{and_channel}
    where not f.remote
) where value is not null
"""
_SCHEMA = "database_messages"  # where the views by message stand, behind all tables of ours
_COLUMNS = ("channel", "id", "extended", "message", "signal", "unit", "number")
_Place = tuple[str | None, int, bool]
"""A channel, None for all, an identifier and whether it has 29 bits."""


class SignalTables:
    """The tables `signals` and `messages` of a connection, and one of each message when a query names it.

    Raises BadValue for a database of LIN frames.
    """

    def __init__(self, connection: Any, databases: Sequence[tuple[str, Database]]) -> None:
        self.path = ", ".join(database.path for _, database in databases)
        listed = [one for _, database in databases for one in database.messages.values()]
        if any(one.lin for one in listed):
            raise BadValue(
                f"{self.path}: signals of LIN frames are no table of a query yet; those of CAN are"
            )
        self._connection = connection
        self._by_channel = len(databases) > 1 or bool(databases[0][0])
        self._messages: dict[str, list[MessageDescription]] = {}  # SQL's names have no case
        for message in listed:
            if message.decodable:
                same = self._messages.setdefault(message.name.lower(), [])
                same += [message] if self._by_channel or not same else []
        self._functions = SignalFunctions([one for one in listed if one.decodable])
        self._made: set[str] = set()
        self.names = list(dict.fromkeys(one.name for one in listed))
        self.signal_names = list(dict.fromkeys(name for one in listed for name in one.signals))
        self._places = self._placed(databases) if self._by_channel else self._identified(listed)
        self._functions.register(connection)
        self._create()

    def mention(self, query: str) -> None:
        """Create the views of the messages whose names this query contains."""
        for word in {word.lower() for word in re.findall(r"\w+", query)}:
            messages = self._messages.get(word)
            if messages and word not in self._made:
                self._made.add(word)
                view = f"{_SCHEMA}.{named(messages[0].name)}"
                parts = " union all by name ".join(self._wide(one) for one in messages)
                self._connection.execute(f"create view {view} as {parts}")

    def _identified(self, messages: list[MessageDescription]) -> dict[int, list[_Place]]:
        """Return by message (its id()) its identifiers in this trace: a J1939 message can have many, which the frames
        show."""
        if not any(message.j1939 for message in messages):
            return {id(message): [(None, message.id, message.extended)] for message in messages}
        matching = Matching(messages)
        found: dict[int, list[_Place]] = {id(message): [] for message in messages}
        there = self._connection.execute("select distinct id, extended from main.frames").fetchall()
        for number, extended in sorted(there):
            place = matching.find(key_of(number, extended))
            if place >= 0:
                found[id(messages[place])].append((None, number, extended))
        return found

    def _placed(self, databases: Sequence[tuple[str, Database]]) -> dict[int, list[_Place]]:
        """Return by message its identifiers in this trace for several databases, by the channels of the frames."""
        known = [(channel, list(one.messages.values())) for channel, one in databases]
        matchings = [(channel, messages, Matching(messages)) for channel, messages in known]
        matchings.sort(key=lambda one: not one[0])  # those of one channel first
        found: dict[int, list[_Place]] = {id(message): [] for _, messages in known for message in messages}
        there = self._connection.execute("select distinct channel, id, extended from main.frames").fetchall()
        for channel, number, extended in there:
            for own, messages, matching in matchings:
                place = matching.find(key_of(number, extended)) if own in ("", channel) else -1
                if place >= 0:
                    found[id(messages[place])].append((channel, number, extended))
                    break
        return found

    def _create(self) -> None:
        arrow, run = load_pyarrow(), self._connection.execute
        rows = [
            (*place, message.name, signal.name, signal.unit, number)
            for number, (message, signal) in enumerate(self._functions.signals)
            for place in self._places[id(message)]
        ]
        kinds = (arrow.string(), arrow.uint32(), arrow.bool_(), *(arrow.string(),) * 3, arrow.int32())
        columns = [arrow.array([row[place] for row in rows], kind) for place, kind in enumerate(kinds)]
        self._connection.register("database_rows", arrow.table(columns, list(_COLUMNS)))
        run("create table database_signals as select * from database_rows")
        self._connection.unregister("database_rows")
        run("create view messages as select distinct message, id, extended from database_signals")
        and_channel = " and f.channel = s.channel" if self._by_channel else ""
        run(f"create view signals as {_SIGNALS.format(and_channel=and_channel)}")
        run(f"create schema {_SCHEMA}; set search_path = 'main,{_SCHEMA}'")

    def _wide(self, message: MessageDescription) -> str:
        """Return a column for each signal, null where the signal is not in the frame."""
        columns = "".join(
            f", signal_value({number}, data) as {named(signal.name)}"
            for number, (one, signal) in enumerate(self._functions.signals)
            if one is message
        )
        places = self._places[id(message)]
        ids = ", ".join(dict.fromkeys(str(number) for _, number, _ in places)) or "null"
        pairs = ", ".join(f"({quoted(channel or '')}, {number})" for channel, number, _ in places) or "null"
        return (
            f"select time_ns, time, channel{columns}, row from main.frames "
            f"where id in ({ids}) and extended = {message.extended} and not remote"
            + (f" and (channel, id) in ({pairs})" if self._by_channel and places else "")
        )
