"""Notes that programs leave at the hub for each other: each program has its own room, ended ones share some."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.boards.config.limits import LimitsConfig
from canwire.errors import BadValue
from canwire.hub.owner.limits import check_room

if TYPE_CHECKING:
    from canwire.hub.owner.session import Session

_LONGEST_NAME, _LONGEST_NOTE = 64, 1024
_LEFT = 4  # times the room of one client for notes whose clients have left; then the oldest goes


class Notes:
    """Notes by name. A note outlives its writer, until it is replaced or many newer ones exist."""

    def __init__(self, limits: LimitsConfig) -> None:
        self._limits = limits
        self._values: dict[
            str, tuple[bytes, Session | None]
        ] = {}  # with who wrote it, as long as it is there
        self._leaving: set[str] = set()  # names of those that go with their writer
        self._left: dict[str, None] = {}  # names of those whose writer has left, the oldest first

    def get(self, name: str) -> bytes:
        """The note of this name, b"" if it does not exist."""
        return self._values.get(name, (b"", None))[0]

    def beginning(self, prefix: str) -> tuple[tuple[str, bytes], ...]:
        """All notes whose names begin with `prefix`: names and values."""
        return tuple((name, value) for name, (value, _) in self._values.items() if name.startswith(prefix))

    def set(self, name: str, value: bytes, writer: Session, *, leaves: bool = False) -> None:
        """Keep a note, or remove it if the value is empty; raises BadValue if too large, LimitReached if too many.

        A note that `leaves` is removed with its writer.
        """
        if len(name) > _LONGEST_NAME or len(value) > _LONGEST_NOTE:
            raise BadValue(
                f"note {name[:20]!r}: names up to {_LONGEST_NAME} characters, {_LONGEST_NOTE} bytes each"
            )
        if value and self._values.get(name, (b"", None))[1] is not writer:
            own = sum(other is writer for _, other in self._values.values())
            check_room(self._limits, "notes", own, writer.name)
        self._values.pop(name, None)
        self._left.pop(name, None)
        self._leaving.discard(name)
        if value:
            self._values[name] = value, writer
            if leaves:
                self._leaving.add(name)

    def leave(self, writer: Session) -> None:
        """Remove the notes of a client whose connection has ended and that leave with it."""
        for name, (value, other) in list(self._values.items()):
            if other is writer and name in self._leaving:
                del self._values[name]
                self._leaving.discard(name)
            elif other is writer:
                self._values[name] = value, None
                self._left[name] = None
        while len(self._left) > _LEFT * self._limits.notes:
            oldest = next(iter(self._left))
            del self._left[oldest], self._values[oldest]
