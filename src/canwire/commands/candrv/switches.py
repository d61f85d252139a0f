"""The switches of CanTestSuite, read as CanWrite reads them.

Only the letter after the dash counts, and its argument is a separate word. Two things differ: --hub exists, and text
that is not a number is refused where a number is needed.

Source: CANDRV manual, 10.2.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import NamedTuple

MOST = {"n": 10_000_000, "c": 100, "t": 100}
_HUB = "--hub"


class Program(NamedTuple):
    """One of the programs: its name, its switches with their arguments and texts, and what it does."""

    name: str
    help: str
    switches: tuple[tuple[str, str, str], ...]
    body: Callable[[Switches, ExitStack], int]

    @property
    def usage(self) -> str:
        rows = (*self.switches, ("h", "", "Show this help"))
        lines = [f"  {f'-{letter} {argument}'.rstrip():<9}: {text}" for letter, argument, text in rows]
        return "\n".join((self.name, *lines, f"  {_HUB} <address>: Hub to use (CANWIRE_HUB)"))


@dataclass(slots=True)
class Switches:
    """What was asked for. `rate` None: as it is."""

    program: str
    device: str = "CID1:"
    rate: int | None = None
    log: str | None = None
    hub: str | None = None
    numbers: dict[str, int] = field(default_factory=dict)


class Usage(Exception):
    """Switches that make no sense, or a question for help: the line before the usage, "" for none."""


def parse(program: Program, words: list[str]) -> Switches:
    """The switches as the manual's programs read them; raises Usage."""
    found = Switches(program.name)
    letters = {letter for letter, _, _ in program.switches}
    rest = iter(words)
    for word in rest:
        if not word.startswith("-"):
            raise Usage(f"Unknown argument '{word}'")
        letter = word[1:2]
        if letter in ("?", "h") or word == "--help":
            raise Usage
        if word.startswith(f"{_HUB}="):
            found.hub = word.partition("=")[2]
            continue
        value = next(rest, None)
        if value is None:
            raise Usage(f"Missing argument to option {_HUB if word == _HUB else f'-{letter}'}")
        if word == _HUB:
            found.hub = value
        elif letter not in letters:
            raise Usage(f"Unknown option -{letter}")
        else:
            _take(found, letter, value)
    return found


def _take(found: Switches, letter: str, value: str) -> None:
    if letter == "d":
        found.device = value
    elif letter == "f":
        found.log = value
    elif letter == "b":
        found.rate = _number("baudrate", value)
    else:
        number = _number(f"number -{letter}", value)
        if not 1 <= number <= MOST[letter]:
            raise Usage(f"Wrong number -{letter} '{value}': 1 to {MOST[letter]}")
        found.numbers[letter] = number


def _number(what: str, text: str) -> int:
    """As C's strtoul with base 0 reads it, but for what is no number: that is 0 to C, and a mistake here."""
    for pattern, base in (
        (r"0[xX]([0-9A-Fa-f]{1,16})", 16),
        (r"0([0-7]{0,22})", 8),
        (r"([1-9][0-9]{0,19})", 10),
    ):
        if found := re.fullmatch(pattern, text):
            return int(found[1] or "0", base)
    raise Usage(f"Wrong {what} '{text}'")
