"""Types for the answers of every interface: replies, answers, and the objects that a program has open."""

from __future__ import annotations

import itertools
import threading
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeVar

from canwire import BadValue

if TYPE_CHECKING:
    from canwire import Event, RingEnd

Kind = TypeVar("Kind")


class Reply(NamedTuple):
    """The answer to a call. `value` is a number, for instance of a new object.

    The reply owns its descriptors: its receiver closes them after sending them. If descriptors cannot be sent, `names`
    replace them.
    """

    result: int = 0
    value: int = 0
    data: bytes = b""
    descriptors: tuple[int, ...] = ()
    names: tuple[str, ...] = ()


class Answers(Protocol):
    """One interface: it answers calls from any thread, and turns errors into its result codes."""

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        """Answer a call; `number` is that of an object, 0 for none."""


class Passing(Protocol):
    """Gives queues and signals of the hub to the program."""

    def lend(self, end: RingEnd, value: int = 0, data: bytes = b"") -> Reply:
        """A reply that gives the program this end of a ring to use, which cw_ring_open takes; `data` follows."""

    def watch(self, event: Event) -> Reply:
        """A reply with a signal, for cw_event_watch, of what this event is assigned to."""


class Objects:
    """The open objects of a program, of one interface, by number."""

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
        """The object with this number; raises BadValue if it does not exist or is of another kind."""
        found = self._objects.get(number)
        if not isinstance(found, kind):
            raise BadValue(f"object {number} is no open {kind.__name__}")
        return found

    def remove(self, number: int) -> object | None:
        """Remove an object and return it; the caller closes it."""
        with self._lock:
            return self._objects.pop(number, None)
