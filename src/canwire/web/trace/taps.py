"""Selects the lines to record: those that a viewer watches or watched recently, also after the hub or board is back.

One thread sweeps over all their queues and is the history's only writer, through the merger.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import CanwireError, every_line
from canwire.web.trace.store.history import History
from canwire.web.trace.store.merging import Merger
from canwire.web.trace.store.rows import EVERY_LINE, GAP, LOST, UNHEARD
from canwire.web.trace.tap import Tap
from canwire.web.words import Trouble

if TYPE_CHECKING:
    from collections.abc import Collection

    from canwire import Hub
    from canwire.web.link import HubLink

SWEEP_S = 0.008  # between two looks into the queues
LOOK_S = 0.5  # between two looks at what is lost, and at boards that were away
LINGER_S = 600.0  # a line that no page shows is still recorded for this time, for a page that comes back
_NOT_PLUGGED_IN = "trace.not-plugged-in"


class Watched(NamedTuple):
    """A line in the trace; `number` is its number in rows, -1 if it was never recorded. `bus` is where it was when it
    was last recorded, and `open` is True while it is. `trouble` is the reason why nothing is received from it now: the
    key of a text or a message of the hub, "" if there is no problem."""

    number: int
    address: str
    bus: str
    lost: int
    trouble: str
    open: bool


class Taps:
    """The recorded lines. Viewers select them by `want`. Hub time plus `epoch_ns(hub)` is wall-clock time."""

    def __init__(
        self,
        link: HubLink,
        history: History,
        epoch_ns: Callable[[Hub], int] = lambda _: 0,
        linger_s: float = LINGER_S,
    ) -> None:
        self._link = link
        self._merger = Merger(history)
        self._epoch_ns = epoch_ns
        self._linger_s = linger_s
        self._changed = threading.Condition()
        self._wanted: dict[object, frozenset[str]] = {}
        self._left_s: dict[str, float] = {}  # when the last viewer of a line has gone
        self._indices: dict[str, int] = {}
        self._taps: dict[str, Tap] = {}
        self._unheard_s: dict[str, float] = {}  # since when a line is not listened to, by choice
        self._buses: dict[str, str] = {}
        self._lost: dict[str, int] = {}
        self._troubles: dict[str, str] = {}
        self._away_since_s: float | None = None
        self._new_hub: Hub | None = None
        self._dirty = False
        self._sweeps = 0
        self._ends = False
        link.subscribe(self._began, self._ended)
        self._thread = threading.Thread(target=self._run, name="taps")
        self._thread.start()

    def want(self, viewer: object, addresses: Collection[str]) -> None:
        """Note that this viewer watches these lines from now on; without lines, the viewer has left."""
        with self._changed:
            before = self._wanted.pop(viewer, frozenset())
            if addresses:
                self._wanted[viewer] = frozenset(addresses)
            still = self._viewed
            now_s = time.monotonic()
            self._left_s = {one: at for one, at in self._left_s.items() if one not in still}
            self._left_s |= {one: now_s for one in before - still if one in self._indices}
            self._dirty = True
            self._changed.notify_all()

    @property
    def _viewed(self) -> frozenset[str]:
        return frozenset().union(*self._wanted.values())

    def indices(self, addresses: Collection[str]) -> list[int]:
        """Return the numbers of these lines in rows; lines that were never recorded have none."""
        with self._changed:
            return [self._indices[address] for address in addresses if address in self._indices]

    def watched(self, addresses: Collection[str] | None = None) -> list[Watched]:
        """The present state of these lines; without `addresses`, of every line recorded since the server's start."""
        with self._changed:
            return [self._told(address) for address in (self._indices if addresses is None else addresses)]

    def _told(self, address: str) -> Watched:
        tap = self._taps.get(address)
        return Watched(
            self._indices.get(address, -1),
            address,
            self._buses.get(address, ""),
            self._lost.get(address, 0) + (tap.lost if tap else 0),
            self._troubles.get(address, ""),
            self._recorded(address),
        )

    def _recorded(self, address: str) -> bool:
        tap = self._taps.get(address)
        return tap is not None and not tap.over

    def listening(self, addresses: Collection[str]) -> bool:
        """Whether all of these lines are recorded now."""
        with self._changed:
            return all(map(self._recorded, addresses))

    def settle(self) -> None:
        """Wait until all records that are in the queues now have row numbers."""
        with self._changed:
            enough = self._sweeps + 4
            self._changed.wait_for(lambda: self._ends or not self._taps or self._sweeps >= enough)

    def close(self) -> None:
        """Stop recording all lines; a second call does nothing."""
        with self._changed:
            self._ends = True
            self._changed.notify_all()
        self._thread.join()

    def _began(self, hub: Hub) -> None:
        with self._changed:
            self._new_hub = hub
            self._dirty = True
            self._changed.notify_all()

    def _ended(self) -> None:
        with self._changed:
            self._away_since_s = time.monotonic()
            self._changed.notify_all()

    def _run(self) -> None:
        due_s, asked = 0.0, 0
        while not self._ends:
            now_s = time.monotonic()
            if self._dirty or now_s >= due_s:
                self._adopt()
                self._arrange(now_s)
                due_s, asked = now_s + LOOK_S, 0
            asked = self._sweep(asked)
            with self._changed:
                self._sweeps += 1
                self._changed.notify_all()
                if not self._ends and not self._dirty:
                    self._changed.wait(SWEEP_S if self._taps else LOOK_S)
        for tap in self._taps.values():
            tap.close()

    def _sweep(self, asked: int) -> int:
        """Empty all queues, and ask the hub for one line's losses; `asked` lines were asked since the last check."""
        taps = list(self._taps.values())
        for tap in taps:
            records = tap.take()
            if records is not None:
                self._merger.take(records, tap.number)
        if asked < len(taps):
            with suppress(CanwireError):  # the next look finds it over
                self._count_lost(taps[asked])
            asked += 1
        self._merger.release()
        return asked

    def _count_lost(self, tap: Tap) -> None:
        count = tap.newly_lost()
        if count:
            self._merger.mark(LOST, tap.number, count)

    def _adopt(self) -> None:
        """Adopt a newly connected hub: its time is a new era, and the interruption becomes a row."""
        with self._changed:
            self._dirty = False
            hub, self._new_hub = self._new_hub, None
            away_since_s, self._away_since_s = self._away_since_s, None if hub else self._away_since_s
        if hub is None:
            return
        epoch_ns = 0
        with suppress(CanwireError):  # gone again: the next connection reports it
            epoch_ns = self._epoch_ns(hub)
        self._merger.restart(epoch_ns)
        if away_since_s is not None:
            self._merger.mark(GAP, EVERY_LINE, round((time.monotonic() - away_since_s) * 1000))

    def _arrange(self, now_s: float) -> None:
        with self._changed:
            viewed = self._viewed
            left = {one for one, at in self._left_s.items() if now_s < at + self._linger_s}
        wanted = viewed | left
        self._close_all_but(wanted, now_s)
        if wanted:
            self._open(wanted, viewed, now_s)

    def _close_all_but(self, wanted: frozenset[str], now_s: float) -> None:
        for address, tap in list(self._taps.items()):
            if address in wanted and not tap.over:
                continue
            if not tap.over:
                self._unheard_s[address] = now_s
            tap.close()
            with self._changed:
                del self._taps[address]
                self._lost[address] = self._lost.get(address, 0) + tap.lost

    def _open(self, wanted: frozenset[str], viewed: frozenset[str], now_s: float) -> None:
        if wanted <= self._taps.keys():
            return
        troubles: dict[str, str] = {}
        try:
            hub = self._link.hub
            places = {place.address: place for place in every_line(hub)}
            for address in sorted(wanted - self._taps.keys()):
                if address not in places:
                    troubles[address] = _NOT_PLUGGED_IN
                    continue
                with self._changed:  # only lines that there are have a number: made-up names cost nothing
                    number = self._indices.setdefault(address, len(self._indices))
                    if address not in self._viewed:  # its viewer has left while it was looked for
                        self._left_s.setdefault(address, now_s)
                try:
                    tap = Tap(hub, places[address], number)
                except CanwireError as error:
                    troubles[address] = Trouble.of(error)
                    continue
                with self._changed:
                    self._taps[address] = tap
                    self._buses[address] = places[address].info.bus
                since_s = self._unheard_s.pop(address, None)
                if since_s is not None:
                    self._merger.mark(UNHEARD, number, round((now_s - since_s) * 1000))
        except CanwireError as error:
            troubles = dict.fromkeys(wanted - self._taps.keys(), Trouble.of(error))
        with self._changed:
            self._troubles = {one: said for one, said in troubles.items() if one in viewed}
