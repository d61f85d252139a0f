"""A database's messages, each in its cycle time, with values that their signals may have."""

from __future__ import annotations

import heapq
import random
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from typing import Any

from canwire import BadDescription, BadValue, ExtraMissing, Frame


class CyclicMessages:
    """Of a DBC, KCD, SYM or ARXML file: those with a cycle time, or these `names`.

    Those without take `usual_s`, if that is given. Raises BadDescription, ExtraMissing, BadValue for names that are not
    there and where no message has a cycle time.
    """

    def __init__(self, path: str, names: Sequence[str], usual_s: float | None, chance: random.Random) -> None:
        messages = _named(path, _loaded(path), names)
        self._chance = chance
        cycles = [
            (message, message.cycle_time / 1000 if message.cycle_time else usual_s) for message in messages
        ]
        self.without = [message.name for message, cycle_s in cycles if cycle_s is None]
        self._cycles: list[tuple[Any, float]] = [
            (message, cycle_s) for message, cycle_s in cycles if cycle_s is not None
        ]
        if not self._cycles:
            raise BadValue(f"--db {path}: no message has a cycle time there; --gap gives all the same")

    def __len__(self) -> int:
        return len(self._cycles)

    def plan(self) -> Iterator[tuple[float, Frame]]:
        """Without end: how long after the one before, in seconds, and the frame."""
        waiting = [(0.0, number, message, cycle_s) for number, (message, cycle_s) in enumerate(self._cycles)]
        heapq.heapify(waiting)
        now_s = 0.0
        while True:
            due_s, number, message, cycle_s = waiting[0]
            heapq.heapreplace(waiting, (due_s + cycle_s, number, message, cycle_s))
            yield due_s - now_s, _frame(message, self._chance)
            now_s = due_s


def _frame(message: Any, chance: random.Random) -> Frame:
    values = dict(_values(message, message.signal_tree, chance))
    data = message.encode(values, scaling=False, strict=False, padding=False)
    return Frame(message.frame_id, data, extended=message.is_extended_frame, fd=message.is_fd)


def _values(message: Any, tree: Sequence[Any], chance: random.Random) -> Iterator[tuple[str, float]]:
    """Raw values; of a multiplexer one of those it has, and then the signals that belong to it."""
    for one in tree:
        if isinstance(one, str):
            yield one, _raw(message.get_signal_by_name(one), chance)
            continue
        for multiplexer, branches in one.items():
            chosen = chance.choice(sorted(branches))
            yield multiplexer, chosen
            yield from _values(message, branches[chosen], chance)


def _raw(signal: Any, chance: random.Random) -> float:
    if signal.is_float:
        return chance.uniform(signal.minimum or 0.0, signal.maximum or 1.0)
    bits = signal.length
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signal.is_signed else (0, (1 << bits) - 1)
    told = [signal.scaled_to_raw(end) for end in (signal.minimum, signal.maximum) if end is not None]
    if len(told) == 2:
        least, most = max(low, int(min(told))), min(high, int(max(told)))
        low, high = (least, most) if least <= most else (low, high)
    return chance.randint(low, high)


def _named(path: str, database: Any, names: Sequence[str]) -> list[Any]:
    messages = list(database.messages)
    if not names:
        return messages
    there = {message.name: message for message in messages}
    for name in names:
        if name not in there:
            near = get_close_matches(name, there, 1)
            raise BadValue(f"--message {name}: not in {path}{f'; did you mean {near[0]}?' if near else ''}")
    return [there[name] for name in names]


def _loaded(path: str) -> Any:
    try:
        import cantools
    except ModuleNotFoundError:
        raise ExtraMissing("cantools", "databases") from None
    try:
        return cantools.database.load_file(path)
    except (OSError, ValueError, cantools.Error) as error:
        raise BadDescription(f"--db {path}: {error}") from None
