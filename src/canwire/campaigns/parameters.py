"""The parameters that a campaign varies: lists of which all values are played, and values drawn for each run."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from canwire.errors import BadValue
from canwire.values.checks import finite, shown, whole

Value = bool | int | float | str
_LARGEST = 1 << 62


@dataclass(frozen=True)
class Draw:
    """A value that each run draws from its own seed. Made by `uniform`, `log_uniform`, `integer`, `choice`."""

    kind: str
    low: float = 0.0
    high: float = 0.0
    values: tuple[Value, ...] = ()

    @classmethod
    def uniform(cls, low: float, high: float) -> Draw:
        """Any number from `low` to `high`, all equally likely."""
        return cls("uniform", *_ordered(finite("low", low, -1e18, 1e18), finite("high", high, -1e18, 1e18)))

    @classmethod
    def log_uniform(cls, low: float, high: float) -> Draw:
        """Any number from `low` to `high`, both above 0, each order of magnitude equally likely: for error rates."""
        if finite("low", low, 0, 1e18) == 0:
            raise BadValue("low 0: a logarithmic draw begins above 0")
        return cls("log_uniform", *_ordered(low, finite("high", high, 0, 1e18)))

    @classmethod
    def integer(cls, low: int, high: int) -> Draw:
        """A whole number from `low` to `high`, both included."""
        return cls(
            "integer",
            *_ordered(whole("low", low, -_LARGEST, _LARGEST), whole("high", high, -_LARGEST, _LARGEST)),
        )

    @classmethod
    def choice(cls, values: Sequence[Value]) -> Draw:
        """One of `values`, all equally likely."""
        return cls("choice", values=_values("choice", values))

    def drawn(self, source: random.Random) -> Value:
        """A value drawn with `source`."""
        if self.kind == "choice":
            return source.choice(self.values)
        if self.kind == "integer":
            return source.randint(int(self.low), int(self.high))
        if self.kind == "log_uniform":
            return min(
                self.high, max(self.low, math.exp(source.uniform(math.log(self.low), math.log(self.high))))
            )
        return source.uniform(self.low, self.high)


class Space:
    """The parameters of a campaign by name; `at` returns those of a run.

    Sequences form a grid that runs play in order; the last parameter changes first. After its end the grid starts
    again, with other seeds. Raises BadValue for a parameter without values, TypeError if it is neither a sequence nor
    a Draw.
    """

    def __init__(self, parameters: Mapping[str, Sequence[Value] | Draw]) -> None:
        self.draws = {name: one for name, one in parameters.items() if isinstance(one, Draw)}
        self.grid = {
            name: _values(name, one) for name, one in parameters.items() if not isinstance(one, Draw)
        }
        self.names = tuple(parameters)
        self.size = math.prod(len(values) for values in self.grid.values())

    def at(self, run: int, seed: int) -> dict[str, Value]:
        """The parameters of run number `run`, whose seed is `seed`, in the order in which they were given."""
        rest = run % self.size
        found: dict[str, Value] = {}
        for name, values in reversed(self.grid.items()):
            rest, place = divmod(rest, len(values))
            found[name] = values[place]
        source = random.Random(f"parameters of {seed}")
        for name, draw in self.draws.items():
            found[name] = draw.drawn(source)
        return {name: found[name] for name in self.names}


def _ordered(low: float, high: float) -> tuple[float, float]:
    if low > high:
        raise BadValue(f"from {low:g} to {high:g}: nothing lies between them")
    return low, high


def _values(name: str, values: Any) -> tuple[Value, ...]:
    if isinstance(values, str | bytes) or not isinstance(values, Sequence):
        raise TypeError(f"{name}: {shown(values)} must be a list, a range or a Draw")
    if not values:
        raise BadValue(f"{name}: no values")
    for one in values if not isinstance(values, range) else ():
        if not isinstance(one, bool | int | float | str):
            raise TypeError(f"{name}: {shown(one)} must be a number, a string, True or False")
    return tuple(values)
