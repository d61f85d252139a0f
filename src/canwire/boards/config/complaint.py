"""Error messages for a configuration file of the wrong form, in the terms of TOML instead of msgspec's."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from canwire.boards.config.limits import LIMITS

_PLACE = re.compile(r" - at `\$(.*)`\Z", re.DOTALL)
_STEP = re.compile(r"\.?([^.\[]+)|\[(\d+)\]")
_UNKNOWN = re.compile(r"Object contains unknown field `(.*)`", re.DOTALL)
_MISSING = re.compile(r"Object missing required field `(\w+)`")
_WORDS = {
    "`array`": "a list",
    "`object`": "a table",
    "`str`": "text",
    "`int`": "a whole number",
    "`int | null`": "a whole number",
    "`float`": "a number",
    "`bool`": "true or false",
}
_LONGEST_VALUE = 60


def complaint(message: str, data: dict[str, Any], tables: Mapping[str, Sequence[str]]) -> str:
    """The message of msgspec with its place first, and the value at that place; `tables` lists the keys of tables."""
    found = _PLACE.search(message)
    place, what = (found[1].removeprefix("."), message[: found.start()]) if found else ("", message)
    if unknown := _UNKNOWN.fullmatch(what):
        keys = ", ".join(tables[place.partition("[")[0]] if place else tables)
        return f"{f'{place}.' if place else ''}{unknown[1]}: no such key; there are {keys}"
    if missing := _MISSING.fullmatch(what):
        return f"{place}.{missing[1]}: missing"
    for word, plain in _WORDS.items():
        what = what.replace(word, plain)
    hint = f"; write [[{place}]], with two brackets" if place in tables and place != LIMITS else ""
    return f"{place}{_value_at(place, data)}: {what[0].lower()}{what[1:]}{hint}"


def _value_at(place: str, data: Any) -> str:
    """` = value` if the value fits into one line, else ""."""
    for key, index in _STEP.findall(place):
        data = data[int(index)] if index else data[key]
    if isinstance(data, dict | list):
        return ""
    shown = repr(data)
    return f" = {shown if len(shown) <= _LONGEST_VALUE else shown[:_LONGEST_VALUE] + '...'}"
