"""What every interface's answers are made of: requests, replies, and the objects that a program has open."""

from __future__ import annotations

import itertools
import threading
from typing import NamedTuple, Protocol, TypeVar

from canwire import BadValue

Kind = TypeVar("Kind")


class Reply(NamedTuple):
    """The answer to a call. `value` is a number, for instance of a new object.

    Descriptors are the reply's own: whoever has one closes them once they are sent.
    """

    result: int = 0
    value: int = 0
    data: bytes = b""
    descriptors: tuple[int, ...] = ()


class Answers(Protocol):
    """One interface: it answers calls from any thread, and turns what goes wrong into its own codes."""

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        """`number` is that of an object, 0 for none."""


class Objects:
    """What a program has open of one interface, by number."""

    def __init__(self) -> None:
        self._objects: dict[int, object] = {}
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()

    def add(self, thing: object) -> int:
        with self._lock:
            number = next(self._numbers)
            self._objects[number] = thing
            return number

    def get(self, number: int, kind: type[Kind]) -> Kind:
        """Raises BadValue for a number that is none of these things'."""
        found = self._objects.get(number)
        if not isinstance(found, kind):
            raise BadValue(f"object {number}: no open {kind.__name__}")
        return found

    def remove(self, number: int) -> object | None:
        """It is closed by whoever asks for that."""
        with self._lock:
            return self._objects.pop(number, None)
