"""What the maps of names share: names of a manual, what they are in canwire, and the page that lists both.

A map's script brings along how its manual is read and by which rules a name's counterpart is found: acan_map.py,
candrv_map.py and, with two manuals on one page, vci_map.py.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

ROOT = Path(__file__).resolve().parent.parent
SEEDS = ROOT.parent / "shared" / "seeds"  # the manuals' texts
NO_NAME = "no name"
ROW = re.compile(r"^\| `([^`]+)` \| ([a-z ]+) \| (.*) \|$")
TABLE = "| name | kind | in canwire |\n|---|---|---|\n"

T = TypeVar("T")  # a Name, or one that says of which manual


class Name(NamedTuple):
    """A name of a manual, as it was before scanning."""

    kind: str
    text: str


class Missing(LookupError):
    """Names without counterparts."""


def ordered(names: Iterable[Name], kinds: Sequence[str]) -> list[Name]:
    """In the order of the page: by kind and spelling."""
    return sorted(names, key=lambda name: (kinds.index(name.kind), name.text.lower(), name.text))


def names_of_page(text: str) -> list[Name]:
    """The names as the page lists them."""
    return [Name(row[2], row[1]) for line in text.splitlines() if (row := ROW.match(line))]


def counterparts(names: Iterable[T], counterpart: Callable[[T], str]) -> list[tuple[T, str]]:
    """Each name with what it is here; raises Missing with all that have no counterpart."""
    found, missing = [], []
    for name in names:
        try:
            found.append((name, counterpart(name)))
        except Missing as error:
            missing.append(str(error))
    if missing:
        raise Missing("\n".join(missing))
    return found


def page(head: str, names: Iterable[Name], counterpart: Callable[[Name], str]) -> str:
    """The page for these names: its head, with their number for {total}, and one table; raises Missing."""
    found = counterparts(names, counterpart)
    rows = "".join(f"| `{name.text}` | {name.kind} | {here} |\n" for name, here in found)
    return head.format(total=len(found)) + TABLE + rows


def write(
    path: Path,
    names_of_manual: Callable[[Path], list[T]],
    names_of_page: Callable[[str], list[T]],
    page: Callable[[list[T]], str],
) -> int:
    """Writes the page at `path` anew, from the directory of the manuals (sys.argv[1], or SEEDS) or else from itself.

    The exit status: 1, and the names on stderr, where some have no counterpart.
    """
    seeds = Path(sys.argv[1]) if len(sys.argv) > 1 else SEEDS
    names = names_of_manual(seeds) if seeds.is_dir() else names_of_page(path.read_text(encoding="utf-8"))
    try:
        path.write_text(page(names), encoding="utf-8")
    except Missing as missing:
        print(missing, file=sys.stderr)
        return 1
    return 0
