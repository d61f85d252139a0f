"""Which lines are listened to: those that some viewer watches, each once, and again when hub or board are back."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, NamedTuple

from canwire import CanwireError, every_line
from canwire.web.trace.history import GAP, History
from canwire.web.trace.tap import Tap

if TYPE_CHECKING:
    from collections.abc import Collection

    from canwire import Hub
    from canwire.web.link import HubLink

_LOOK_S = 0.5  # between two looks at what is lost, and at boards that were away


class Watched(NamedTuple):
    """A line in the trace, `number` in its rows. `trouble`: why nothing comes from it now, "" if nothing is wrong."""

    number: int
    address: str
    bus: str
    lost: int
    trouble: str


class Taps:
    """Opens and closes taps in a thread of its own; viewers say what they watch by `want`."""

    def __init__(self, link: HubLink, history: History) -> None:
        self._link = link
        self._history = history
        self._changed = threading.Condition()
        self._wanted: dict[object, frozenset[str]] = {}
        self._indices: dict[str, int] = {}
        self._taps: dict[str, Tap] = {}
        self._buses: dict[str, str] = {}
        self._lost: dict[str, int] = {}
        self._troubles: dict[str, str] = {}
        self._away_since_s: float | None = None
        self._ends = False
        link.subscribe(self._began, self._ended)
        self._thread = threading.Thread(target=self._run, name="taps")
        self._thread.start()

    def want(self, viewer: object, addresses: Collection[str]) -> None:
        """This viewer watches these lines from now on; none: it has gone."""
        with self._changed:
            if addresses:
                self._wanted[viewer] = frozenset(addresses)
                for address in sorted(addresses):
                    self._indices.setdefault(address, len(self._indices))
            else:
                self._wanted.pop(viewer, None)
            self._changed.notify()

    def indices(self, addresses: Collection[str]) -> list[int]:
        """What the rows of these lines are marked with."""
        with self._changed:
            return [self._indices[address] for address in addresses if address in self._indices]

    def watched(self) -> list[Watched]:
        """Every line that was watched since the server runs."""
        with self._changed:
            return [
                Watched(
                    index,
                    address,
                    self._buses.get(address, ""),
                    self._lost.get(address, 0) + (tap.lost if (tap := self._taps.get(address)) else 0),
                    self._troubles.get(address, ""),
                )
                for address, index in self._indices.items()
            ]

    def close(self) -> None:
        """Listen to nothing any more; a second time does nothing."""
        with self._changed:
            self._ends = True
            self._changed.notify()
        self._thread.join()

    def _began(self, _: Hub) -> None:
        with self._changed:
            if self._away_since_s is not None:
                self._history.mark(GAP, 0xFFFF, round((time.monotonic() - self._away_since_s) * 1000))
                self._away_since_s = None
            self._changed.notify()

    def _ended(self) -> None:
        with self._changed:
            self._away_since_s = time.monotonic()
            self._changed.notify()

    def _run(self) -> None:
        while not self._ends:
            with self._changed:
                wanted = frozenset().union(*self._wanted.values())
            self._close_all_but(wanted)
            if wanted:
                self._open(wanted)
            with self._changed:
                if not self._ends and frozenset().union(*self._wanted.values()) == wanted:
                    self._changed.wait(_LOOK_S)
        self._close_all_but(frozenset())

    def _close_all_but(self, wanted: frozenset[str]) -> None:
        for address, tap in list(self._taps.items()):
            if address not in wanted or tap.over:
                tap.close()
                with self._changed:
                    del self._taps[address]
                    self._lost[address] = self._lost.get(address, 0) + tap.lost

    def _open(self, wanted: frozenset[str]) -> None:
        try:
            hub = self._link.hub
            places = {place.address: place for place in every_line(hub)}
        except CanwireError as error:
            self._tell(dict.fromkeys(wanted, str(error)))
            return
        troubles: dict[str, str] = {}
        for address in sorted(wanted):
            try:
                if address not in places:
                    troubles[address] = f"{address} is not plugged in"
                elif address in self._taps:
                    self._taps[address].count_lost()
                else:
                    tap = Tap(hub, places[address], self._history, self._indices[address])
                    with self._changed:
                        self._taps[address] = tap
                        self._buses[address] = places[address].info.bus
            except CanwireError as error:
                troubles[address] = str(error)
        self._tell(troubles)

    def _tell(self, troubles: dict[str, str]) -> None:
        with self._changed:
            self._troubles = troubles
