"""Turns an error of DuckDB into one line, with its place in the query and similar names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from canwire.databases.near import near

EXPLAIN = "explain"
"""A line before the query: DuckDB then plans it only."""
_PLACE = re.compile(r"\n\s*\nLINE (\d+): (.*)\n( *)(\^+)")
_NO_TABLE = re.compile(r"Table with name (\S+) does not exist")
_LITERAL = re.compile(r"\b(message|signal)\s*=\s*'((?:[^']|'')*)'", re.IGNORECASE)
_BY_DATABASE = ("signals", "messages")
_ABOUT_SQL = ("Parser", "Binder", "Catalog", "Conversion", "Not implemented", "Out of Range")
_MEMORY = "Out of Memory Error"
_DAMAGE = re.compile(r"corrupt|[Dd]ecompress|TProtocol|[Tt]hrift|bitpacked|Failed to read file")
_HEX = re.compile(r"\b0[xX][0-9a-fA-F]+")


def one_line(error: Exception, query: str, tables: Iterable[str]) -> str:
    """Shorten an error: `SQL, line 1, column 15: Table with name frams does not exist; did you mean frames?`."""
    text = str(error)
    if text.startswith(_MEMORY):
        return f"{text.splitlines()[0]}; give it more (--memory; memory_bytes), or query less"
    if not text.startswith(_ABOUT_SQL) and _DAMAGE.search(text):
        told = text.splitlines()[0]
        return f"a file of the log is damaged ({told}); `canwire convert` tells which, and keeps the others"
    place = _PLACE.search(text)
    said = text[: place.start()] if place else text
    kind, colon, rest = said.partition(": ")
    said = rest if colon and kind.endswith("Error") else said
    said = " ".join(said.replace('"', "").split())
    missing = _NO_TABLE.search(said)
    if missing and missing[1].lower() in _BY_DATABASE:
        said = f"no table {missing[1]} without a database (--db FILE; open_trace(..., database=FILE))"
    elif missing:
        said = f"no table {missing[1]}; {near(missing[1], tables)}"
    elif "syntax error" in said and (number := _HEX.search(query)):
        said += f"; SQL has no {number[0]}: write {int(number[0], 16)} or '{number[0]}'"
    return f"SQL{_where(place, query)}: {said}"


def unknown_names(query: str, messages: Sequence[str], signals: Sequence[str]) -> str:
    """Return a message or signal of the query that the database does not define, with similar names; "" if there is
    none."""
    known = {"message": messages, "signal": signals}
    for column, text in _LITERAL.findall(query):
        names = known[column.lower()]
        if text not in names:
            return f"no {column.lower()} {text!r}; {near(text, names)}"
    return ""


def _where(place: re.Match[str] | None, query: str) -> str:
    """Return line and column of an error; DuckDB may show only a part of a long line."""
    if place is None or place[1] == "1":
        return ""
    number, shown = int(place[1]), place[2]
    at = len(place[3]) - len(f"LINE {number}: ")
    lines = [EXPLAIN, *query.splitlines()]
    if 0 < number <= len(lines):
        part = shown.removeprefix("...").removesuffix("...")
        cut = len(shown) - len(shown.removeprefix("..."))
        at += max(lines[number - 1].find(part), 0) - cut
    return f", line {number - 1}, column {at + 1}"
