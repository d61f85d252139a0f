"""The source of rows: the hub's lines, or an opened log. A viewer views one source."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import TYPE_CHECKING, Protocol

from canwire.web.trace.store.history import History
from canwire.web.trace.taps import Taps, Watched

if TYPE_CHECKING:
    import numpy


class Source(Protocol):
    """A history and its lines. `live`: rows are still added."""

    history: History
    live: bool

    @property
    def trouble(self) -> str:
        """A sentence about a problem, "" if there is none."""

    def want(self, viewer: object, addresses: Collection[str]) -> None:
        """Note that this viewer watches these lines from now on; without lines, the viewer has left."""

    def indices(self, addresses: Collection[str]) -> list[int]:
        """Return the numbers of these lines in rows."""

    def lines(self, addresses: Collection[str]) -> list[Watched]:
        """Return the present state of these lines."""

    def bus_of(self, number: int) -> str:
        """Return the bus of the line with this number in rows; "" if unknown."""

    def now_ns(self) -> int:
        """Return the present time of rows."""


class LiveSource:
    """The frames that the hub's lines receive and send."""

    live = True

    def __init__(self, history: History, taps: Taps) -> None:
        self.history = history
        self._taps = taps

    @property
    def trouble(self) -> str:
        return self.history.trouble

    def want(self, viewer: object, addresses: Collection[str]) -> None:
        self._taps.want(viewer, addresses)

    def indices(self, addresses: Collection[str]) -> list[int]:
        return self._taps.indices(addresses)

    def lines(self, addresses: Collection[str]) -> list[Watched]:
        return self._taps.watched(addresses)

    def bus_of(self, number: int) -> str:
        return next((line.bus for line in self._taps.watched() if line.number == number), "")

    def now_ns(self) -> int:
        epoch_ns = self.history.eras[-1].epoch_ns
        return time.time_ns() - epoch_ns if epoch_ns else newest_ns(self.history)


def newest_ns(history: History) -> int:
    """Return the time stamp of the last row; 0 if there is none."""
    rows: numpy.ndarray = history.read(history.total - 1, history.total)
    return int(rows["record"]["time_ns"][0]) if len(rows) else 0
