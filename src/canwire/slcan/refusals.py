"""Frames of the host that are refused since the transmit queue is full: counted at the hub, logged once per opening."""

from __future__ import annotations

from collections.abc import Callable

from canwire.slcan.can_side import TRANSMIT_QUEUE, CanSide


class Refusals:
    """`one` counts a frame; `tell` reports the new count, at most once for each piece of data from the host."""

    def __init__(self, can: CanSide, say: Callable[[str], object]) -> None:
        self._can = can
        self._say = say
        self._count = 0
        self._said = False

    def one(self) -> None:
        self._count += 1

    def restart(self) -> None:
        """The channel was opened."""
        self._said = False

    def tell(self) -> None:
        count, self._count = self._count, 0
        if not count:
            return
        self._can.count_refused(count)
        if not self._said:
            self._said = True
            self._say(f"frames are refused (BELL): {TRANSMIT_QUEUE} wait already, and the host sends more")
