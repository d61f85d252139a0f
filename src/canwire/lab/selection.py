"""Which frames and faults of a script take place: all, unless a campaign searches for the cause of a failure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol, TypeVar

from canwire.bus.scripted import Scripted

FRAMES, FAULTS, NOISE = KINDS = ("frames", "faults", "noise")
ScriptedT = TypeVar("ScriptedT", bound=Scripted)


class Selection(Protocol):
    """Decides on each frame that a node is to send, each fault that a script sets, and each bit that noise is about to
    invert, in order.
    """

    def takes(self, kind: str, words: Callable[[], str]) -> bool:
        """Whether the next frame, fault or bit of this kind takes place; `words` returns its description."""


def selected(selection: Selection | None, fault: ScriptedT, words: Callable[[], str]) -> ScriptedT:
    """Return a new fault, cancelled if it is not selected."""
    if selection is not None and fault.times != 0 and not selection.takes(FAULTS, words):
        fault.cancel()
    return fault


def call(name: str, arguments: Mapping[str, object]) -> str:
    """The text of a call, with the arguments that are not None; nodes are given by their names."""
    given = ", ".join(
        f"{key}={getattr(value, 'name', None) or value!r}"
        for key, value in arguments.items()
        if value is not None
    )
    return f"{name}({given})"
