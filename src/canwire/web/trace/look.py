"""The view of one viewer: lines, filter, colours, range of rows. Data of the web socket are checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

MOST_LINES = 1024
MOST_ROWS = 4096  # in an answer
_MOST_RULES = 32
_LONGEST = 400


@dataclass(frozen=True)
class Look:
    """A view. `number` is the viewer's, and is part of every answer. `rules`: filters with their colours.
    `direction`: "R" for received frames only, "T" for sent frames only, "" for both.

    It contains rows from number `since` on, up to `until` (None: no limit; otherwise the viewer has paused).
    """

    number: int
    source: str
    lines: tuple[str, ...]
    filter: str = ""
    direction: str = ""
    rules: tuple[tuple[str, int], ...] = ()
    since: int = 0
    until: int | None = None

    @classmethod
    def parse(cls, told: dict[str, Any]) -> Look:
        """Check and convert a received view; raises ValueError, KeyError or TypeError for an invalid one."""
        if not isinstance(told, dict):
            raise ValueError("an object")
        until = told.get("until")
        return cls(
            _whole(told["number"]),
            _text(told.get("source", ""), 40),
            tuple(_text(one, 80) for one in _listed(told["lines"], MOST_LINES)),
            _text(told.get("filter", ""), _LONGEST),
            _text(told.get("direction", ""), 1),
            tuple(
                (_text(one["text"], _LONGEST), _whole(one["colour"], 255))
                for one in _listed(told.get("rules", []), _MOST_RULES)
            ),
            _whole(told.get("since", 0)),
            None if until is None else _whole(until),
        )


@dataclass(frozen=True)
class Ask:
    """A request for `rows` rows from place `at` on; -1: the newest ones. `by_frame`: one row for each identifier.

    With a text to `find`, rows around the nearest row with this text after place `begin` (`step` -1: before it); with
    `near`, around the row with that number; with `time_ns`, around the first row that is not earlier.
    """

    at: int
    rows: int
    by_frame: bool = False
    find: str = ""
    begin: int = -1
    step: int = 1
    near: int | None = None
    time_ns: int | None = None

    @classmethod
    def parse(cls, told: dict[str, Any]) -> Ask:
        """Check and convert a received request; raises ValueError, KeyError or TypeError for an invalid one."""
        if not isinstance(told, dict):
            raise ValueError("an object")
        at, begin = told["at"], told.get("begin", -1)
        return cls(
            -1 if at == -1 else _whole(at),
            _whole(told["rows"], MOST_ROWS),
            bool(told.get("byFrame")),
            _text(told.get("find", ""), _LONGEST),
            -1 if begin == -1 else _whole(begin),
            1 if told.get("step", 1) == 1 else -1,
            None if told.get("near") is None else _whole(told["near"]),
            None if told.get("time") is None else _whole(told["time"]),
        )


def _listed(value: Any, most: int) -> list[Any]:
    if not isinstance(value, list) or len(value) > most:
        raise ValueError(f"a list of up to {most}")
    return value


def _text(value: Any, longest: int) -> str:
    if not isinstance(value, str) or len(value) > longest:
        raise ValueError(f"a text of up to {longest} characters")
    return value


def _whole(value: Any, most: int = 1 << 53) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value <= most:
        raise ValueError(f"a number from 0 to {most}")
    return value
