"""Messages of a database at their cycle times, with random values in the ranges of their signals."""

from __future__ import annotations

import heapq
import math
import random
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from canwire import BadValue, Frame, load_database

if TYPE_CHECKING:
    from canwire import Database, MessageDescription, SignalDescription

_MOST = {False: 8, True: 64}  # bytes of a classic frame, of an FD frame


class CyclicMessages:
    """The messages of a DBC, KCD, SYM or ARXML file: all with a cycle time, or those with these `names`.

    Messages without a cycle time use `usual_s`, if it is given; messages that need several frames are left out. Raises
    BadDescription, ExtraMissing, BadValue for unknown names and if no message has a cycle time.
    """

    def __init__(
        self, source: Database | str, names: Sequence[str], usual_s: float | None, chance: random.Random
    ) -> None:
        self._database = load_database(source) if isinstance(source, str) else source
        messages = [_named(self._database, name) for name in names] or list(self._database.messages.values())
        self._chance = chance
        single = [message for message in messages if _fits(message)]
        cycles = [(message, message.cycle_s or usual_s) for message in single]
        self.without = [message.name for message, cycle_s in cycles if cycle_s is None]
        self.too_long = [message.name for message in messages if not _fits(message)]
        self._cycles = [(message, cycle_s) for message, cycle_s in cycles if cycle_s is not None]
        if not self._cycles:
            raise BadValue(
                f"--db {self._database.path}: no message has a cycle time there; --gap gives all the same"
            )

    def __len__(self) -> int:
        return len(self._cycles)

    def plan(self) -> Iterator[tuple[float, Frame]]:
        """Yields, without end, the seconds since the previous frame, and the frame."""
        waiting = [(0.0, number, message, cycle_s) for number, (message, cycle_s) in enumerate(self._cycles)]
        heapq.heapify(waiting)
        now_s = 0.0
        while True:
            due_s, number, message, cycle_s = waiting[0]
            heapq.heapreplace(waiting, (due_s + cycle_s, number, message, cycle_s))
            yield due_s - now_s, self._frame(message)
            now_s = due_s

    def _frame(self, message: MessageDescription) -> Frame:
        frame = self._database.encode(message.name, values_of(message, self._chance))
        assert isinstance(frame, Frame)
        return frame


def values_of(message: MessageDescription, chance: random.Random) -> dict[str, float]:
    """Physical values; a multiplexer gets one of its known values, and only the signals on that page are included."""
    ids: dict[str, set[int]] = {}
    for signal in message.signals.values():
        if signal.multiplexer:
            ids.setdefault(signal.multiplexer, set()).update(signal.multiplexer_ids)
    raw = {name: chance.choice(sorted(known)) for name, known in ids.items()}

    def present(signal: SignalDescription) -> bool:
        if not signal.multiplexer:
            return True
        return raw[signal.multiplexer] in signal.multiplexer_ids and present(
            message.signals[signal.multiplexer]
        )

    return {
        signal.name: raw[signal.name] * signal.scale + signal.offset
        if signal.name in raw
        else _value(signal, chance)
        for signal in message.signals.values()
        if present(signal)
    }


def _value(signal: SignalDescription, chance: random.Random) -> float:
    if signal.is_float:
        low = signal.minimum if math.isfinite(signal.minimum) else 0.0
        return chance.uniform(low, signal.maximum if math.isfinite(signal.maximum) else low + 1.0)
    bits = signal.length
    least, most = (-(1 << bits - 1), (1 << bits - 1) - 1) if signal.signed else (0, (1 << bits) - 1)
    low, high = sorted(int(signal.raw(end)) for end in (signal.minimum, signal.maximum))
    value = chance.randint(max(low, least), min(high, most)) * signal.scale + signal.offset
    return min(max(value, signal.minimum), signal.maximum)


def _fits(message: MessageDescription) -> bool:
    return message.decodable and not message.lin and message.length <= _MOST[message.fd]


def _named(database: Database, name: str) -> MessageDescription:
    try:
        return database.message(name)
    except BadValue as error:
        raise BadValue(f"--message: {error}") from None
