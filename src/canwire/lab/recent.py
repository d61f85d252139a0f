"""The last frames of a bus, with their senders."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

FrameT = TypeVar("FrameT")
Witness = Callable[[str, bytes, int], None]
MOST_KEPT = 1 << 24  # frames


class Recent(Generic[FrameT]):
    """Keeps frames as bytes; `frames` converts them by the method `frame` of the subclass."""

    def __init__(self, limit: int) -> None:
        self._kept: deque[tuple[str, bytes, int]] = deque(maxlen=limit)
        self.witness: Witness | None = None

    def keep(self, sender: str, data: bytes, at_ns: int) -> None:
        self._kept.append((sender, data, at_ns))
        if self.witness is not None:
            self.witness(sender, data, at_ns)

    def frames(self) -> list[tuple[str, FrameT]]:
        """Sender and frame, oldest first."""
        return [(sender, self.frame(data, at_ns)) for sender, data, at_ns in self._kept]

    def frame(self, data: bytes, at_ns: int) -> FrameT:
        raise NotImplementedError
