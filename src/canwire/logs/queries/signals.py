"""Signals of a database's messages as tables, decoded while a query runs, and only those that it asks for.

`signals` joins frames with a small table of what the database says. DuckDB hands a filter by message or signal through
the join to the files as a filter by identifier, of which a trace's file has few row groups.
"""

from __future__ import annotations

import re
from typing import Any

from canwire.databases.database import Database
from canwire.databases.description import MessageDescription
from canwire.databases.matching import Matching, key_of
from canwire.errors import BadValue
from canwire.logs.queries.decoding import SignalFunctions
from canwire.logs.queries.views import named
from canwire.logs.tables.arrow import load_pyarrow

_SIGNALS = """
select time_ns, time, channel, message, signal, value, signal_text(number, data) as text, unit, row from (
    select f.time_ns, f.time, f.channel, s.message, s.signal, signal_value(s.number, f.data) as value, s.unit,
        s.number, f.data, f.row
    from main.frames f join main.database_signals s on f.id = s.id and f.extended = s.extended where not f.remote
) where value is not null
"""
_SCHEMA = "database_messages"  # where the views by message stand, behind all tables of ours
_COLUMNS = ("id", "extended", "message", "signal", "unit", "number")


class SignalTables:
    """The tables `signals` and `messages` of a connection, and one of each message when a query names it.

    Raises BadValue for a database of LIN frames.
    """

    def __init__(self, connection: Any, database: Database) -> None:
        listed = database.messages
        if any(one.lin for one in listed.values()):
            raise BadValue(
                f"{database.path}: signals of LIN frames are no table of a query yet; those of CAN are"
            )
        self._connection = connection
        decodable = [one for one in listed.values() if one.decodable]
        self._messages = {one.name.lower(): one for one in reversed(decodable)}  # SQL's names have no case
        self._functions = SignalFunctions(decodable)
        self._made: set[str] = set()
        self.path = database.path
        self.names = list(listed)
        self.signal_names = list(dict.fromkeys(name for one in listed.values() for name in one.signals))
        self._ids = self._identifiers(list(listed.values()))
        self._functions.register(connection)
        self._create()

    def mention(self, query: str) -> None:
        """Make the views of the messages that this query has the name of."""
        for word in {word.lower() for word in re.findall(r"\w+", query)}:
            message = self._messages.get(word)
            if message is not None and word not in self._made:
                self._made.add(word)
                view = f"{_SCHEMA}.{named(message.name)}"
                self._connection.execute(f"create view {view} as {self._wide(message)}")

    def _identifiers(self, messages: list[MessageDescription]) -> dict[str, list[tuple[int, bool]]]:
        """By message its identifiers in this trace: a J1939 message has many, and the frames tell which."""
        if not any(message.j1939 for message in messages):
            return {message.name: [(message.id, message.extended)] for message in messages}
        matching = Matching(messages)
        found: dict[str, list[tuple[int, bool]]] = {message.name: [] for message in messages}
        there = self._connection.execute("select distinct id, extended from main.frames").fetchall()
        for id, extended in sorted(there):
            number = matching.find(key_of(id, extended))
            if number >= 0:
                found[messages[number].name].append((id, extended))
        return found

    def _create(self) -> None:
        arrow, run = load_pyarrow(), self._connection.execute
        rows = [
            (id, extended, message.name, signal.name, signal.unit, number)
            for number, (message, signal) in enumerate(self._functions.signals)
            for id, extended in self._ids[message.name]
        ]
        kinds = (arrow.uint32(), arrow.bool_(), *(arrow.string(),) * 3, arrow.int32())
        columns = [arrow.array([row[place] for row in rows], kind) for place, kind in enumerate(kinds)]
        self._connection.register("database_rows", arrow.table(columns, list(_COLUMNS)))
        run("create table database_signals as select * from database_rows")
        self._connection.unregister("database_rows")
        run("create view messages as select distinct message, id, extended from database_signals")
        run(f"create view signals as {_SIGNALS}")
        run(f"create schema {_SCHEMA}; set search_path = 'main,{_SCHEMA}'")

    def _wide(self, message: MessageDescription) -> str:
        """A column for each signal, null where it is not in the frame."""
        columns = "".join(
            f", signal_value({number}, data) as {named(signal.name)}"
            for number, (one, signal) in enumerate(self._functions.signals)
            if one is message
        )
        ids = ", ".join(str(id) for id, _ in self._ids[message.name]) or "null"
        return (
            f"select time_ns, time, channel{columns}, row from main.frames "
            f"where id in ({ids}) and extended = {message.extended} and not remote"
        )
