"""An opened log played onto a line of the hub: its frames at their times, faster or slower, all or a range of them."""

from __future__ import annotations

import threading
import time
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import (
    BadFrame,
    CanwireError,
    ChannelMode,
    HubChannel,
    InUse,
    QueueFull,
    WrongState,
    frame_of_record,
)
from canwire.web.lines import find_can_line
from canwire.web.trace.store.kinds import is_lin, is_mark, kind_of

if TYPE_CHECKING:
    import numpy

    from canwire import Hub
    from canwire.web.link import HubLink
    from canwire.web.trace.store.selection import Selection

_QUEUE = 256
_LOOK_S = 0.05  # between two looks whether it is to end, while it waits
_PART = 4096  # rows


class Wanted(NamedTuple):
    """What is played: the selection's CAN frames with stamps (ns) from `begin` up to `end`, onto `line`.

    `speed` 2 is twice as fast, 0 as fast as the bus takes them.
    """

    name: str
    selection: Selection
    line: str
    speed: float
    begin_ns: int
    end_ns: int | None


class Played(NamedTuple):
    """The replay of this `number`, from 1: `sent` were given to the line, `delivered` acknowledged.

    `skipped` are no CAN frames.
    """

    number: int = 0
    running: bool = False
    name: str = ""
    line: str = ""
    sent: int = 0
    delivered: int = 0
    skipped: int = 0
    at_s: float = 0.0
    trouble: str = ""


class Replay:
    """One at a time for the whole server."""

    def __init__(self, link: HubLink) -> None:
        self._link = link
        self._lock = threading.Lock()
        self._ends = threading.Event()
        self._thread: threading.Thread | None = None
        self.played = Played()

    def start(self, wanted: Wanted) -> None:
        """Raises InUse while one runs, WrongState for a line that does not run, NoSuchBoard, HubLost."""
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                raise InUse(f"{self.played.name} is being replayed; stop it first")
            channel = _opened(self._link.hub, wanted.line)
            self._ends.clear()
            self.played = Played(self.played.number + 1, True, wanted.name, wanted.line)
            self._thread = threading.Thread(target=self._run, args=(wanted, channel), name="replay")
            self._thread.start()

    def stop(self) -> None:
        """What waits in the line's queue is taken back; a second time does nothing."""
        self._ends.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self, wanted: Wanted, channel: HubChannel) -> None:
        trouble = ""
        try:
            self._play(wanted, channel)
            while not self._ends.is_set() and channel.status().pending:
                self._ends.wait(_LOOK_S)
            if self._ends.is_set():
                channel.cancel()
        except CanwireError as error:
            trouble = str(error)
        finally:
            with suppress(CanwireError):  # gone with its hub or board
                self.played = self.played._replace(delivered=channel.status().delivered)
            channel.close()
            self.played = self.played._replace(running=False, trouble=trouble)

    def _play(self, wanted: Wanted, channel: HubChannel) -> None:
        begun_s, first_ns = 0.0, None
        for place in range(wanted.selection.gone, wanted.selection.count, _PART):
            rows = wanted.selection.rows(place, _PART)
            stamps = rows["record"]["time_ns"]
            inside = stamps >= wanted.begin_ns
            if wanted.end_ns is not None:
                inside &= stamps < wanted.end_ns
            rows = rows[inside & ~is_mark(rows)]
            playable = (kind_of(rows) == 0) & ~is_lin(rows)
            for row, plays in zip(rows, playable, strict=True):
                stamp_ns = int(row["record"]["time_ns"])
                if first_ns is None:
                    begun_s, first_ns = time.monotonic(), stamp_ns
                if wanted.speed:
                    self._wait_until(begun_s + max(0, stamp_ns - first_ns) / 1e9 / wanted.speed)
                if self._ends.is_set():
                    return
                self._send(channel, row, plays)
            self.played = self.played._replace(delivered=channel.status().delivered)

    def _send(self, channel: HubChannel, row: numpy.void, plays: bool) -> None:
        now = self.played
        try:
            frame = frame_of_record(row["record"].tobytes()) if plays else None
        except BadFrame:
            frame = None
        if frame is None:
            self.played = now._replace(skipped=now.skipped + 1)
            return
        while not self._ends.is_set():
            with suppress(QueueFull):
                channel.send(frame, timeout=_LOOK_S)
                self.played = now._replace(sent=now.sent + 1, at_s=int(row["record"]["time_ns"]) / 1e9)
                return

    def _wait_until(self, due_s: float) -> None:
        while (left_s := due_s - time.monotonic()) > 0:
            if self._ends.wait(min(left_s, _LOOK_S)):
                return


def _opened(hub: Hub, address: str) -> HubChannel:
    place = find_can_line(hub, address)
    if not hub.line_status(place.board.id, place.line).running:
        raise WrongState(f"{address} does not run: nothing can be sent there until it is started")
    channel = hub.open_channel(place.board.id, place.line)
    try:
        channel.set_up(ChannelMode(receive=1, transmit=_QUEUE, frames=False))
        channel.activate()
    except CanwireError:
        channel.close()
        raise
    return channel
