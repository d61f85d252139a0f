"""Ends of rings that another process works on: a program without an interpreter, for which this one asks the hub."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple

from canwire.platform import Descriptor, close_descriptors, duplicate


class LentMemory:
    """A descriptor of its own for the memory of rings, kept for as long as somebody refers to this."""

    def __init__(self, memory: Descriptor) -> None:
        (self.descriptor,) = duplicate((memory,))

    def __del__(
        self,
        close: Callable[..., None] = close_descriptors,
        ending: Callable[[], bool] = sys.is_finalizing,
    ) -> None:
        if hasattr(self, "descriptor") and not ending():
            close(self.descriptor)


class LentRing(NamedTuple):
    """What a process needs to use a ring's end; the descriptors are still the lender's."""

    memory: LentMemory
    begin: int
    """The byte of the memory at which the ring begins."""
    own: int
    """Readable when the other side has signalled this end."""
    peer: int
    """Written to (eight bytes) to signal the other side; -1: it wants no signals."""
