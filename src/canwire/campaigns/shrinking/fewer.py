"""Finds fewer items and simpler values with which a failure persists. No lab, no I/O: the function `fails` plays."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from canwire.campaigns.campaign import Campaign
from canwire.campaigns.parameters import Draw, Value

Fails = Callable[[Value], bool]
_DIGITS = (1, 2, 3)
_HALVINGS = 6


def fewest(items: Sequence[int], fails: Callable[[Sequence[int]], Sequence[int] | None]) -> list[int]:
    """A minimal part of `items`: without any one of them the failure disappears.

    `fails` plays a part and returns the items that took place, or None if the failure disappears. Larger pieces are
    left out first. Source: Zeller and Hildebrandt, Simplifying and Isolating Failure-Inducing Input, 2002 (its
    complements).
    """
    rest = list(items)
    if not rest:
        return rest
    if (found := fails([])) is not None:
        return list(found)
    size = max(1, len(rest) // 2)
    while True:
        at, before = 0, len(rest)
        while at < len(rest) > 1:
            found = fails(rest[:at] + rest[at + size :]) if size < len(rest) else None
            if found is None:
                at += size
            else:
                rest = list(found)
        if size == 1 and len(rest) in (before, 1):
            return rest
        size = max(1, min(size // 2, len(rest) // 2))


def simplest(campaign: Campaign, name: str, value: Value, fails: Fails) -> Value:
    """The value nearest to the parameter's aim with which the run fails, within the precision of repeated halving.

    The aim is the default of the function's argument if it is among the values; otherwise the first value of a list,
    or, for a drawn number, 0 or the value nearest to 0.
    """
    default = campaign.default(name)
    draw = campaign.space.draws.get(name)
    if draw is None or draw.kind == "choice":
        values = campaign.space.grid[name] if draw is None else draw.values
        if value not in values:  # it was set by hand
            return value
        aim = values.index(default) if default is not None and default in values else 0
        return values[_whole(values.index(value), aim, lambda place: fails(values[place]))]
    if not isinstance(value, int | float):
        return value
    inside = isinstance(default, int | float) and draw.low <= default <= draw.high
    aim_number = default if inside and isinstance(default, int | float) else min(max(0, draw.low), draw.high)
    if draw.kind == "integer":
        return _whole(int(value), int(aim_number), fails)
    return _number(draw, float(value), float(aim_number), fails)


def least_prefix(most: int, fails: Callable[[Sequence[int]], object]) -> int:
    """The length of the shortest prefix of `most` items that fails; `most` if the failure needs all of them."""
    if not fails(range(most)):
        return most
    return _whole(most, 0, lambda count: bool(fails(range(count))))


def _whole(value: int, aim: int, fails: Callable[[int], bool]) -> int:
    if value == aim or fails(aim):
        return aim
    while abs(value - aim) > 1:
        middle = (value + aim) // 2
        if fails(middle):
            value = middle
        else:
            aim = middle
    return value


def _number(draw: Draw, value: float, aim: float, fails: Fails) -> float:
    """Try fewer digits, then nearer values, by factors for a logarithmic draw."""
    if value == aim or fails(aim):
        return aim
    for digits in _DIGITS:
        rounded = float(f"{value:.{digits - 1}e}")
        if draw.low <= rounded <= draw.high and (rounded == value or fails(rounded)):
            value = rounded
            break
    for _ in range(_HALVINGS):
        middle = math.sqrt(value * aim) if draw.kind == "log_uniform" else (value + aim) / 2
        middle = float(f"{middle:.1e}")
        if not min(value, aim) < middle < max(value, aim):
            break
        if fails(middle):
            value = middle
        else:
            aim = middle
    return value
