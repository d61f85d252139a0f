"""Rows that the hub's cyclic lists send: their cycles are exact, even if this server is busy."""

from __future__ import annotations

import threading
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire import (
    SELF_RECEPTION,
    BadValue,
    CanwireError,
    ChannelMode,
    Frame,
    HubChannel,
    LinePlace,
    Scheduler,
    Siblings,
    WrongState,
    frames_to_array,
)
from canwire.web.lines import find_can_line
from canwire.web.words import Trouble

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.web.link import HubLink
    from canwire.web.send.row import Row

_QUEUE = 8192  # frames of one row that are counted together
_COUNT_S = 1.0
_BYTE = 2  # CAN_CTXMSG_INC_BYTE
_DONE = 2  # CAN_CTXMSG_STAT_DONE


@dataclass
class _Cycling:
    """A row on its line's list, and the channel that receives its frames."""

    place: LinePlace
    row: Row
    index: int
    channel: HubChannel
    cycle: int


class ExactCycles:
    """Rows with exact cycles, for use by any thread. A line's list is held as long as it contains a row."""

    def __init__(self, link: HubLink) -> None:
        self._link = link
        self._lock = threading.RLock()
        self._leases: dict[str, Scheduler] = {}
        self._cycling: dict[int, _Cycling] = {}
        self._delivered: dict[int, int] = {}
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._count, name="exact cycles")
        self._thread.start()
        link.subscribe(lambda _: None, self._drop_all)

    def start(self, row: Row) -> None:
        """Put the row on the list, or change the frame that is sent there in the same cycle.

        Raises BadValue for a cycle that is no whole number of the list's ticks, InUse, Unsupported, LineError,
        WrongState.
        """
        with self._lock:
            held = self._cycling.get(row.number)
            if held is not None and held.channel.over:
                self.stop(row.number)
            elif held is not None and _replaces(row, held.row):
                self._leases[row.line].replace(held.index, _record(row.frame))
                held.row = row
                return
            self.stop(row.number)
            self._cycling[row.number] = self._begun(row)

    def stop(self, number: int) -> None:
        """Send no more frames of this row."""
        with self._lock:
            held = self._cycling.pop(number, None)
            if held is None:
                return
            lease = self._leases[held.row.line]
            with suppress(CanwireError):  # gone with its hub or board
                if not lease.over:
                    lease.remove(held.index)
                self._tally(number, held)
            held.channel.close()
            if lease.over or not any(one.row.line == held.row.line for one in self._cycling.values()):
                self._leases.pop(held.row.line).close()

    def over(self, number: int) -> str | None:
        """Return None while the row is sent; afterwards the error that ended it, "" if it was sent as often as
        requested."""
        with self._lock:
            held = self._cycling.get(number)
            if held is None or held.channel.over:
                return "the line has gone"
            try:
                done = self._leases[held.row.line].status().states[held.index] == _DONE
            except CanwireError as error:
                return Trouble.of(error)
            return "" if done else None

    def delivered(self, number: int) -> int:
        """Number of frames of this row that were acknowledged on the bus."""
        with self._lock:
            if (held := self._cycling.get(number)) is not None:
                with suppress(CanwireError):  # as above
                    self._tally(number, held)
            return self._delivered.get(number, 0)

    def close(self) -> None:
        """Release all lists and channels; a second call does nothing."""
        self._ends.set()
        self._thread.join()
        self._drop_all()

    def _begun(self, row: Row) -> _Cycling:
        hub: Hub = self._link.hub
        place = find_can_line(hub, row.line)
        if not hub.line_status(place.board.id, place.line).running:
            raise WrongState(f"{row.line} does not run: nothing can be sent there until it is started")
        cycle = _ticks(place, row.cycle_ms)
        channel = hub.open_channel(place.board.id, place.line)
        try:
            channel.set_up(ChannelMode(receive=_QUEUE, transmit=1, siblings=Siblings.OTHERS_AND_OWN))
            channel.activate()
            lease = self._leases.get(row.line)
            if lease is None or lease.over:
                lease = self._leases[row.line] = hub.open_scheduler(place.board.id, place.line)
                lease.resume()
            grows = row.content.changes
            index = lease.add(
                _record(row.frame),
                cycle,
                increment=_BYTE if grows else 0,
                byte_index=grows[0].byte if grows else 0,
                owner=channel,
            )
            lease.start(index, row.most)
        except CanwireError:
            channel.close()
            if row.line in self._leases and not any(
                one.row.line == row.line for one in self._cycling.values()
            ):
                self._leases.pop(row.line).close()
            raise
        return _Cycling(place, row, index, channel, cycle)

    def _tally(self, number: int, held: _Cycling) -> None:
        records = held.channel.receive_array()
        own = int((records["info"] & SELF_RECEPTION != 0).sum())
        self._delivered[number] = self._delivered.get(number, 0) + own

    def _count(self) -> None:
        """Empty the queues regularly, even if no page is open."""
        while not self._ends.wait(_COUNT_S):
            for number in list(self._cycling):
                self.delivered(number)

    def _drop_all(self) -> None:
        with self._lock:
            for number in list(self._cycling):
                self.stop(number)


def _replaces(row: Row, before: Row) -> bool:
    """Whether only the frame of the row has changed, and its data are not longer."""
    same = row.line == before.line and row.cycle_ms == before.cycle_ms and row.most == before.most
    return same and not row.content.changes and not before.content.changes


def _ticks(place: LinePlace, cycle_ms: float) -> int:
    ticks = place.info.capabilities.cyclic
    if not ticks.tick_ns:
        raise BadValue(f"{place.address}: this board has no cyclic list; send this row without exact cycles")
    cycle, rest = divmod(round(cycle_ms * 1e6), ticks.tick_ns)
    if rest or not 1 <= cycle <= ticks.maximum:
        least_ms = ticks.tick_ns / 1e6
        raise BadValue(
            f"{place.address}: a cycle of {cycle_ms:g} ms; its list has steps of {least_ms:g} ms,"
            f" up to {ticks.maximum * least_ms:g} ms"
        )
    return int(cycle)


def _record(frame: object) -> bytes:
    assert isinstance(frame, Frame)
    return frames_to_array([frame]).tobytes()
