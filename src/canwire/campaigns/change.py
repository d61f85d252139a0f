"""Changes to a run that is played again: other parameters, and only some of its frames and faults."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

from canwire.campaigns.parameters import Value
from canwire.errors import BadValue
from canwire.lab.selection import KINDS
from canwire.values.checks import shown, whole

_MOST = 1 << 40
_NONE = "none"
_FLIP = re.compile(r"(.+):([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8}):(\d{1,4})")
_BIT = re.compile(r"(.+): bit (\d+) of ([0-9A-F]{3}|[0-9A-F]{8})#")


@dataclass(frozen=True)
class Change:
    """Changes to a run. `given` replaces parameters of the run.

    `only` lists for some of `KINDS` the numbers that take place, counted from 0 in the order in which the script
    requests them, including those that are left out. `flips` are additional inverted bits, each once, such as
    "can0:103:45": bit 45 of the next frame 0x103 on bus can0.
    """

    given: Mapping[str, Value] = field(default_factory=dict)
    only: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    flips: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        given: Mapping[str, Value] | None,
        only: Mapping[str, Iterable[int] | str] | None,
        flips: Iterable[str] = (),
    ) -> Change:
        """The change that a user specifies. Raises BadValue, TypeError."""
        for kind in only or ():
            if kind not in KINDS:
                raise BadValue(f"only {shown(kind)}: one of {', '.join(KINDS)}")
        chosen = {
            kind: numbers_of_words(numbers)
            if isinstance(numbers, str)
            else tuple(sorted({whole(kind, number, 0, _MOST) for number in numbers}))
            for kind, numbers in (only or {}).items()
        }
        for flip in flips:
            flip_of(flip)
        return cls(dict(given or {}), chosen, tuple(flips))

    def with_value(self, name: str, value: Value) -> Change:
        """This change, with another value of one parameter."""
        return replace(self, given={**self.given, name: value})

    def with_only(self, kind: str, numbers: Iterable[int]) -> Change:
        """This change, with only these numbers of a kind."""
        return replace(self, only={**self.only, kind: tuple(numbers)})

    def parameters(self, own: Mapping[str, Value]) -> dict[str, Value]:
        """The parameters of the changed run; text becomes a number where the original value is a number.

        Raises BadValue for a parameter that the run does not have, and for text that is not a valid value.
        """
        unknown = set(self.given) - set(own)
        if unknown:
            raise BadValue(
                f"{', '.join(sorted(unknown))}: the run's parameters are {', '.join(own) or 'none'}"
            )
        return {**own, **{name: _like(name, value, own[name]) for name, value in self.given.items()}}

    def options(self) -> str:
        """The options of `canwire campaign --repeat` that make the same change."""
        words = [f"--set {shlex.quote(f'{name}={value}')}" for name, value in self.given.items()]
        words += [f"--only {kind}={numbers_in_words(numbers)}" for kind, numbers in self.only.items()]
        words += [f"--flip {shlex.quote(flip)}" for flip in self.flips]
        return " ".join(words)


def _like(name: str, value: Value, own: Value) -> Value:
    """Convert `value`, if it is text, to the type of `own`."""
    if not isinstance(value, str) or isinstance(own, str):
        return value
    if isinstance(own, bool):
        if value not in ("True", "False"):
            raise BadValue(f"{name} {value!r}: True or False")
        return value == "True"
    try:
        return float(value) if isinstance(own, float) or not value.lstrip("-").isdecimal() else int(value)
    except ValueError:
        raise BadValue(f"{name} {value!r}: a number, as the run's own value {own!r} is") from None


class Flip(NamedTuple):
    """A bit of the next frame with this identifier on a bus, counted from SOF, stuff bits included."""

    bus: str
    frame_id: int
    extended: bool
    bit: int


def flip_of(text: str) -> Flip:
    """Parse a flip such as "can0:103:45"; 29-bit identifiers have eight digits. Raises BadValue."""
    found = _FLIP.fullmatch(text)
    if found is None:
        raise BadValue(f"flip {text!r}: BUS:IDENTIFIER:BIT, such as can0:103:45")
    bus, id, bit = found.groups()
    return Flip(bus, int(id, 16), len(id) == 8, int(bit))


def flip_in_words(words: str) -> str | None:
    """The flip with the effect of this noise, given in words (bus/can/faults/faults.py); None if it hit no frame.

    >>> flip_in_words("can0: bit 45 of 103#1122 from a at 3120000 ns")
    'can0:103:45'
    """
    found = _BIT.match(words)
    return None if found is None else "{0}:{2}:{1}".format(*found.groups())


class Chosen:
    """The `Selection` (lab/selection.py) of a lab: only the numbers in `only` take place.

    `took` contains by kind the numbers that took place. Their words are kept if `words` is set.
    """

    def __init__(self, only: Mapping[str, tuple[int, ...]], words: bool) -> None:
        self._only = {kind: frozenset(numbers) for kind, numbers in only.items()}
        self._words = words
        self._asked = dict.fromkeys(KINDS, 0)
        self.took: dict[str, dict[int, str]] = {kind: {} for kind in KINDS}

    def takes(self, kind: str, words: Callable[[], str]) -> bool:
        number = self._asked[kind]
        self._asked[kind] = number + 1
        if kind in self._only and number not in self._only[kind]:
            return False
        self.took[kind][number] = words() if self._words else ""
        return True


def numbers_in_words(numbers: Iterable[int]) -> str:
    """Numbers as text: "3,7-9", or "none".

    >>> numbers_in_words([3, 7, 8, 9])
    '3,7-9'
    """
    ordered = sorted(numbers)
    if not ordered:
        return _NONE
    starts = [ordered[0], *(next_ for last, next_ in pairwise(ordered) if next_ != last + 1)]
    ends = [*(last for last, next_ in pairwise(ordered) if next_ != last + 1), ordered[-1]]
    return ",".join(f"{a}" if a == b else f"{a}-{b}" for a, b in zip(starts, ends, strict=True))


def numbers_of_words(text: str) -> tuple[int, ...]:
    """The numbers in such a text; the inverse of `numbers_in_words`. Raises BadValue.

    >>> numbers_of_words("3,7-9")
    (3, 7, 8, 9)
    """
    found: list[int] = []
    for part in [] if text == _NONE else text.split(","):
        first, dash, last = part.partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise BadValue(f"numbers {text!r}: such as 3,7-9, or none")
        found += range(int(first), int(last or first) + 1)
    return tuple(found)
