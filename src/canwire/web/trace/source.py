"""Where rows come from: the hub's lines, or a log that was opened. A viewer looks at one of them."""

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
        """A sentence, "" if nothing is wrong."""

    def want(self, viewer: object, addresses: Collection[str]) -> None:
        """This viewer watches these lines from now on; none: it has gone."""

    def indices(self, addresses: Collection[str]) -> list[int]:
        """The numbers of these lines in rows."""

    def lines(self, addresses: Collection[str]) -> list[Watched]:
        """These lines as they are now."""

    def bus_of(self, number: int) -> str:
        """The bus of the line with this number in rows; "" where it is not known."""

    def now_ns(self) -> int:
        """The time that rows have which come now."""


class LiveSource:
    """What the hub's lines receive and send."""

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
    """The last row's stamp; 0 without one."""
    rows: numpy.ndarray = history.read(history.total - 1, history.total)
    return int(rows["record"]["time_ns"][0]) if len(rows) else 0
