"""Where two outcomes differ first, in words."""

from __future__ import annotations

from itertools import zip_longest
from typing import Any

from tests.bus.can.reference.players import Outcome, by_the_rules, on_the_bench
from tests.bus.can.reference.schedule import Schedule

WAYS = {"bit by bit": True, "whole frames": False, "changing": None}


def differences(schedule: Schedule, rules: Outcome | None = None) -> list[str]:
    """The first difference in each thing told, by each of canwire's ways and by the rules; none if all agree."""
    rules = rules or by_the_rules(schedule)
    found = []
    for way, bitwise in WAYS.items():
        found += [f"{way}: {words}" for words in differing(on_the_bench(schedule, bitwise=bitwise), rules)]
    return found


def differing(bench: Outcome, rules: Outcome) -> list[str]:
    found = []
    for k in range(len(rules.events)):
        found += first(f"n{k} event", bench.events[k], rules.events[k])
        found += first(f"n{k} frame", bench.received[k], rules.received[k])
    found += first("delivered", bench.delivered, rules.delivered)
    found += first("seen", bench.seen, rules.seen)
    if bench.levels is not None and rules.levels is not None:
        found += first("level", settled(bench.levels), settled(rules.levels))
    return found


def first(what: str, bench: list[Any], rules: list[Any]) -> list[str]:
    for k, (mine, theirs) in enumerate(zip_longest(bench, rules)):
        if mine != theirs and not alike(mine, theirs):
            return [f"{what} {k}: the bus {mine}, the rules {theirs}"]
    return []


def alike(mine: Any, theirs: Any) -> bool:
    """The rules give no number to the bit of an error outside frames."""
    if not (isinstance(mine, tuple) and isinstance(theirs, tuple) and mine[0] == theirs[0] == "error"):
        return False
    return theirs[3] is None and mine[:3] == theirs[:3] and mine[4:] == theirs[4:]


def settled(levels: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """What lasted for no time was never there."""
    last: dict[int, int] = dict(levels)
    kept: list[tuple[int, int]] = []
    for at, level in last.items():
        if not kept or kept[-1][1] != level:
            kept.append((at, level))
    return kept
