"""Ends of rings that another process uses: a program without an interpreter, for which this process calls the hub."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, NamedTuple

from canwire.platform import Descriptor, EventDescriptor, close_descriptors, duplicate


class LentMemory:
    """A separate descriptor for the memory of rings, open while this object is referenced."""

    def __init__(self, memory: Descriptor) -> None:
        (self.descriptor,) = duplicate((memory,))

    def fileno(self) -> int:
        """The number of its open file in this process."""
        memory: Any = self.descriptor
        return int(getattr(memory, "descriptor", memory))

    def __del__(
        self,
        close: Callable[..., None] = close_descriptors,
        ending: Callable[[], bool] = sys.is_finalizing,
    ) -> None:
        if hasattr(self, "descriptor") and not ending():
            close(self.descriptor)


class LentRing(NamedTuple):
    """The data that a process needs to use the end of a ring; the lender still owns the descriptors."""

    memory: LentMemory
    begin: int
    """The byte of the memory at which the ring begins."""
    own: EventDescriptor
    """The event by which the other side signals this end."""
    peer: EventDescriptor | None
    """Signals the other side, as writing eight bytes to its descriptor does; None: it wants no signals."""
