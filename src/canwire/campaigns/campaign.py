"""A campaign: the function, what it varies, and how run number N is made from the campaign's seed."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from canwire.campaigns.parameters import Draw, Space, Value
from canwire.errors import BadValue
from canwire.lab.bench import Lab
from canwire.values.checks import whole
from canwire.values.mistakes.calls import answers_wrong_calls

Figures = Mapping[str, Value]
MOST_RUNS = 1 << 40


class Campaign:
    """A function of a Lab, and the parameters it is played with. Made by the decorator `campaign`.

    Each run calls the function with a new Lab in virtual time, whose `seed` is the seed of that run, and with the
    parameters by name. The function returns the figures of the run: a dict of numbers, strings and truth values, or
    None. A run fails if the function raises an exception.
    """

    def __init__(self, function: Callable[..., Figures | None], space: Space) -> None:
        self.function = function
        self.name = function.__name__
        self.space = space

    def seed_of(self, run: int, seed: int) -> int:
        """The seed of run number `run`, 0..2**63-1, in a campaign that was started with `seed`."""
        digest = hashlib.sha256(f"{seed}/{whole('run', run, 0, MOST_RUNS)}".encode()).digest()
        return int.from_bytes(digest[:8], "big") >> 1

    def parameters_of(self, run: int, seed: int) -> dict[str, Value]:
        """The parameters of run number `run`, by name."""
        return self.space.at(run, self.seed_of(run, seed))

    @property
    def source(self) -> Path:
        """The file that contains the function."""
        return Path(inspect.getfile(self.function))

    @property
    def path(self) -> str:
        """The path of that file as it appears in tracebacks."""
        return inspect.unwrap(self.function).__code__.co_filename

    def default(self, name: str) -> Value | None:
        """The default of a parameter of the function; None if it has no default."""
        found = inspect.signature(self.function).parameters.get(name)
        return (
            found.default
            if found is not None and isinstance(found.default, bool | int | float | str)
            else None
        )

    def __call__(self, lab: Lab, **parameters: Any) -> Figures | None:
        return self.function(lab, **parameters)

    def __repr__(self) -> str:
        names = ", ".join(self.space.names) or "no parameters"
        return f"<campaign {self.name}: {names}; {self.space.size} in its grid>"


@answers_wrong_calls
def campaign(**parameters: Sequence[Value] | Draw) -> Callable[[Callable[..., Figures | None]], Campaign]:
    """Make a campaign of a function that takes a Lab and these parameters.

    All values of a list or a range are played; each run draws a value from a Draw.

    >>> @campaign(bit_rate=[250_000, 500_000], bit=range(19, 60))
    ... def flips(lab, bit_rate, bit):
    ...     bus = lab.can_bus(bit_rate=bit_rate)
    ...     return {"load": bus.load}
    >>> flips
    <campaign flips: bit_rate, bit; 82 in its grid>

    Raises BadValue, TypeError.
    """
    space = Space(parameters)

    def made(function: Callable[..., Figures | None]) -> Campaign:
        names = list(inspect.signature(function).parameters.values())[1:]
        given = [one.name for one in names if one.kind is not inspect.Parameter.VAR_KEYWORD]
        needed = {one.name for one in names if one.default is one.empty and one.name in given}
        unknown = set(parameters) - set(given)
        if unknown and len(given) == len(names):
            raise BadValue(f"{function.__name__}() does not take {', '.join(sorted(unknown))}")
        if needed - set(parameters):
            raise BadValue(f"{function.__name__}() needs {', '.join(sorted(needed - set(parameters)))} too")
        return Campaign(function, space)

    return made
