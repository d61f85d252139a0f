"""One fault on a bus of the hub: who set it, what it did so far, and who waits for its end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from canwire.bus.scripted import Scripted
from canwire.hub.owner.held.held import Held, Holder, Turn
from canwire.hub.protocol.fault_messages import FaultInfo
from canwire.timeline import Timer

USED_UP = "used up"


@dataclass(eq=False)
class LiveFault:
    """`effect` is what does it. `over` says why it has ended, "" until then."""

    number: int
    bus: str
    kind: str
    text: str
    setter: Holder
    persistent: bool
    set_ns: int
    effect: Scripted = field(default_factory=Scripted)
    lines: frozenset[str] = frozenset()
    timer: Timer | None = None
    over: str = ""
    waiting: list[Callable[[], object]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.limit = self.effect.times

    def end(self, why: str) -> None:
        """It is over, and undone; the first reason stays."""
        self.effect.cancel()
        if self.timer is not None:
            self.timer.cancel()
        if not self.over:
            self._tell(why)

    def used_up(self) -> None:
        """It has struck as often as it should (a held level continues to its end), or was cleared on a bench."""
        if not self.over and self.effect.times == 0:
            done = self.limit is not None and self.effect.struck >= self.limit
            self._tell(USED_UP if done else "cleared on its bench")

    def _tell(self, why: str) -> None:
        self.over = why
        waiting, self.waiting = self.waiting, []
        for tell in waiting:
            tell()

    def info(self) -> FaultInfo:
        left = 0 if self.over else self.effect.times_left
        return FaultInfo(
            self.number, self.bus, self.kind, self.text, self.setter.name, self.persistent, self.set_ns,
            self.effect.struck, left, self.over,
        )  # fmt: skip


@dataclass(eq=False)
class HeldFault(Held):
    """A program's hand on a fault; `release` is called when it ends."""

    turn = Turn.REFERENCE
    live: LiveFault
    release: Callable[[LiveFault], object]

    def let_go(self) -> None:
        self.release(self.live)
