"""Names and signals of frames by a database, for people and for JSON."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from canwire import Frame


class Value(NamedTuple):
    """One signal: `text` is its value with its unit."""

    name: str
    text: str


class Message(NamedTuple):
    """A frame that the database knows."""

    name: str
    values: tuple[Value, ...]

    def __str__(self) -> str:
        return f"{self.name}({', '.join(f'{value.name}: {value.text}' for value in self.values)})"


Decode = Callable[[Frame], Message | None]


def decoder(path: str) -> Decode:
    """Of a DBC, KCD, SYM or ARXML file; gives None for frames that it does not know.

    Raises BadDescription, ExtraMissing without canwire[databases].
    """
    from canwire.web.database import Database

    database = Database(path)
    names = database.names

    def decode(frame: Frame) -> Message | None:
        name = names.get(f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}")
        if name is None:
            return None
        values = database.signals(frame)
        return Message(name, tuple(Value(one.name, f"{one.value} {one.unit}".rstrip()) for one in values))

    return decode
