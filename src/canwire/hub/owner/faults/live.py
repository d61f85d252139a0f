"""One fault on a bus of the hub: the program that set it, its effects so far, and the calls that wait for its end."""

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
    """A fault that was set. `effect` is its implementation. `over` is the reason for its end, "" until then."""

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
        """End and undo the fault; the reason of the first call stays."""
        self.effect.cancel()
        if self.timer is not None:
            self.timer.cancel()
        if not self.over:
            self._tell(why)

    def used_up(self) -> None:
        """End the fault if it has occurred all its times (a held level continues), or was cleared on a bench."""
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
    """The lease of a program on a fault; `release` is called when it ends."""

    turn = Turn.REFERENCE
    live: LiveFault
    release: Callable[[LiveFault], object]

    def let_go(self) -> None:
        self.release(self.live)
