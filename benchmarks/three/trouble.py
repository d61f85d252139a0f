"""What happens to three machines, in an order that a seed chooses: cuts, loss, a rate limit, restarts, kills."""

from __future__ import annotations

import random
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tests.machines.namespaces import Machines
from three.kept import Kept


class Trouble:
    """One after the other. `wait` lets seconds pass, in which programs are looked after."""

    def __init__(
        self, machines: Machines, programs: dict[str, Kept], wait: Callable[[float], None], seed: int
    ) -> None:
        self.machines, self.programs, self.wait = machines, programs, wait
        self.dice = random.Random(seed)
        self.done: dict[str, int] = {}

    def one(self) -> str:
        """Do one, and let things settle for some seconds; what it was."""
        kinds, weights = zip(*_KINDS, strict=True)
        (kind,) = self.dice.choices(kinds, weights)
        what = str(kind(self))
        name = kind.__name__.replace("_", " ").strip()
        self.done[name] = self.done.get(name, 0) + 1
        self.wait(self.dice.uniform(2, 8))
        return what

    def _pairs(self) -> list[tuple[int, int]]:
        """The ways between the bench, machine 0, and another one, or all of them."""
        return self.dice.choice([[(0, 1), (1, 0)], [(0, 2), (2, 0)], list(self.machines.spoiler.ways)])

    @contextmanager
    def _changed(self, pairs: list[tuple[int, int]], **values: object) -> Iterator[None]:
        ways = [self.machines.spoiler.ways[pair] for pair in pairs]
        before = [{name: getattr(way, name) for name in values} for way in ways]
        for way in ways:
            vars(way).update(values)
        yield
        for way, old in zip(ways, before, strict=True):
            vars(way).update(old)

    def short_cut(self) -> str:
        return self._cut(self._pairs(), self.dice.uniform(0.3, 9))

    def long_cut(self) -> str:
        return self._cut(self._pairs(), self.dice.uniform(9, 25))

    def cut_one_way(self) -> str:
        return self._cut([self.dice.choice(list(self.machines.spoiler.ways))], self.dice.uniform(1, 12))

    def _cut(self, pairs: list[tuple[int, int]], length_s: float) -> str:
        with self._changed(pairs, cut=True):
            self.wait(length_s)
        return f"cut {pairs} for {length_s:.1f} s"

    def loss(self) -> str:
        share, length_s = self.dice.uniform(0.01, 0.05), self.dice.uniform(3, 10)
        with self._changed(list(self.machines.spoiler.ways), loss=share, delay_s=0.02):
            self.wait(length_s)
        return f"{share:.1%} lost for {length_s:.1f} s"

    def narrow(self) -> str:
        rate, length_s = self.dice.uniform(30_000, 80_000), self.dice.uniform(5, 15)
        with self._changed(self._pairs(), rate=rate):
            self.wait(length_s)
        return f"{rate:.0f} bytes/s for {length_s:.1f} s"

    def offer_restarted(self) -> str:
        return self._end("offer")

    def hub_restarted(self) -> str:
        return self._end(self.dice.choice(["hub", "hub", "hub-2"]))

    def program_killed(self) -> str:
        others = [name for name in self.programs if "hub" not in name and name != "offer"]
        return self._end(self.dice.choice(others), signal.SIGKILL)

    def _end(self, name: str, by: signal.Signals | None = None) -> str:
        number = by or self.dice.choice([signal.SIGTERM, signal.SIGKILL])
        self.programs[name].process.send_signal(number)
        self.wait(3)
        return f"{name} ended by {number.name}"


_KINDS = [
    (Trouble.short_cut, 4), (Trouble.long_cut, 1), (Trouble.cut_one_way, 2), (Trouble.loss, 2), (Trouble.narrow, 2),
    (Trouble.offer_restarted, 2), (Trouble.hub_restarted, 1), (Trouble.program_killed, 1),
]  # fmt: skip
