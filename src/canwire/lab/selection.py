"""Which of the frames and faults of a script take place: all, unless a campaign looks for the cause of a failure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol, TypeVar

from canwire.bus.scripted import Scripted

FRAMES, FAULTS, NOISE = KINDS = ("frames", "faults", "noise")
ScriptedT = TypeVar("ScriptedT", bound=Scripted)


class Selection(Protocol):
    """Is asked about each frame that a node is given to send, each fault that a script makes, and each bit that noise
    is about to invert, in the order in which they come.
    """

    def takes(self, kind: str, words: Callable[[], str]) -> bool:
        """Does the next one of this kind take place? `words` says what it is."""


def selected(selection: Selection | None, fault: ScriptedT, words: Callable[[], str]) -> ScriptedT:
    """A fault that has just been made; it is cancelled if it does not take place."""
    if selection is not None and fault.times != 0 and not selection.takes(FAULTS, words):
        fault.cancel()
    return fault


def call(name: str, arguments: Mapping[str, object]) -> str:
    """A call in words, with those of its arguments that are not None; nodes by their names."""
    given = ", ".join(
        f"{key}={getattr(value, 'name', None) or value!r}"
        for key, value in arguments.items()
        if value is not None
    )
    return f"{name}({given})"
