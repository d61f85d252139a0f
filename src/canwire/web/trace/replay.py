"""Replays an opened log on lines of the hub: its frames at their times, faster or slower, all or a range of them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import CanwireError, InUse
from canwire.web.lines import look
from canwire.web.trace.answers import frame_of
from canwire.web.trace.sinks import CanSink, LinSink, Sink
from canwire.web.trace.store.kinds import is_lin, is_mark
from canwire.web.words import Trouble

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy

    from canwire.web.link import HubLink
    from canwire.web.send.lin_outlets import LinOutlets
    from canwire.web.trace.store.selection import Selection

_LOOK_S = 0.05  # between two looks whether it is to end, while it waits
_RETRY_S = 0.001  # before a line that was busy is asked again
_PART = 4096  # rows


class Wanted(NamedTuple):
    """The frames to replay: those of the selection with stamps (ns) from `begin` up to `end`, by channel on a line.

    `lines` are addresses by the channels' numbers in rows. `speed` 2 is twice as fast, 0 as fast as each bus accepts
    frames.
    """

    name: str
    selection: Selection
    lines: Mapping[int, str]
    speed: float
    begin_ns: int
    end_ns: int | None


class Played(NamedTuple):
    """The state of replay `number`, from 1: `sent` frames were queued, `delivered` ones acknowledged or received back.

    `skipped` rows are no frames of the line's kind.
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
    """A replay of a log; the server has one at a time. `outlets()` are its LIN lines."""

    def __init__(self, link: HubLink, outlets: Callable[[], LinOutlets]) -> None:
        self._link = link
        self._outlets = outlets
        self._lock = threading.Lock()
        self._ends = threading.Event()
        self._players: list[_Player] = []
        self._number = 0
        self._about = ("", "")

    @property
    def played(self) -> Played:
        """The progress of the present or last replay."""
        players = list(self._players)
        return Played(
            self._number,
            any(one.running for one in players),
            *self._about,
            sum(one.sent for one in players),
            sum(one.delivered for one in players),
            sum(one.skipped for one in players),
            max((one.at_s for one in players), default=0.0),
            next((one.trouble for one in players if one.trouble), ""),
        )

    def start(self, wanted: Wanted) -> None:
        """Start a replay. Raises InUse if one runs, WrongState for a line that does not run, NoSuchBoard, HubLost."""
        with self._lock:
            if any(one.running for one in self._players):
                raise InUse(f"{self._about[0]} is being replayed; stop it first")
            with ExitStack() as undoing:
                sinks: list[Sink] = []
                for line in wanted.lines.values():
                    sinks.append(self._sink(line))
                    undoing.callback(sinks[-1].close)
                undoing.pop_all()
            self._ends.clear()
            self._number += 1
            self._about = (wanted.name, ", ".join(wanted.lines.values()))
            begun = _Begin(time.monotonic(), _first_ns(wanted))
            self._players = [
                _Player(wanted, channel, sink, begun, self._ends)
                for channel, sink in zip(wanted.lines, sinks, strict=True)
            ]
            for player in self._players:
                player.start()

    def stop(self) -> None:
        """Stop the replay, and discard the frames in the lines' queues; a second call does nothing."""
        self._ends.set()
        for player in self._players:
            player.join()

    def _sink(self, address: str) -> Sink:
        hub = self._link.hub
        if any(one.lin is not None for one in look(hub) if one.place.address == address):
            return LinSink(self._outlets(), address)
        return CanSink(hub, address)


class _Begin(NamedTuple):
    """Calculates the moment at which a row with a given time stamp is due."""

    at_s: float
    stamp_ns: int


class _Player(threading.Thread):
    """Replays one channel of the log on one line; it does not wait for other lines."""

    def __init__(
        self, wanted: Wanted, channel: int, sink: Sink, begun: _Begin, ends: threading.Event
    ) -> None:
        super().__init__(name=f"replay on {wanted.lines[channel]}")
        self._wanted = wanted
        self._channel = channel
        self._sink = sink
        self._begun = begun
        self._ends = ends
        self.running = True
        self.sent = self.delivered = self.skipped = 0
        self.at_s = 0.0
        self.trouble = ""

    def run(self) -> None:
        sink = self._sink
        try:
            self._play()
            while not self._ends.is_set() and sink.counts()[1]:
                self._ends.wait(_LOOK_S)
            if self._ends.is_set():
                sink.cancel()
        except CanwireError as error:
            self.trouble = Trouble.of(error)
        finally:
            with suppress(CanwireError):  # gone with its hub or board
                self.delivered = sink.counts()[0]
            sink.close()
            self.running = False

    def _play(self) -> None:
        lin = isinstance(self._sink, LinSink)
        for rows in _parts(self._wanted):
            rows = rows[rows["line"] == self._channel]
            for row, fits in zip(rows, is_lin(rows) == lin, strict=True):
                stamp_ns = int(row["record"]["time_ns"])
                if self._wanted.speed:
                    self._wait_until(stamp_ns)
                if self._ends.is_set():
                    return
                self._send(row["record"].tobytes(), stamp_ns, fits)
            self.delivered = self._sink.counts()[0]

    def _send(self, record: bytes, stamp_ns: int, fits: bool) -> None:
        frame = frame_of(record) if fits else None
        if frame is None:
            self.skipped += 1
            return
        while not self._ends.is_set():
            if self._sink.send(frame):
                self.sent += 1
                self.at_s = stamp_ns / 1e9
                return
            self._ends.wait(_RETRY_S)

    def _wait_until(self, stamp_ns: int) -> None:
        due_s = self._begun.at_s + max(0, stamp_ns - self._begun.stamp_ns) / 1e9 / self._wanted.speed
        while (left_s := due_s - time.monotonic()) > 0:
            if self._ends.wait(min(left_s, _LOOK_S)):
                return


def _parts(wanted: Wanted) -> Iterator[numpy.ndarray]:
    """Yield the rows to replay, some at a time."""
    for place in range(wanted.selection.gone, wanted.selection.count, _PART):
        rows = wanted.selection.rows(place, _PART)
        stamps = rows["record"]["time_ns"]
        inside = (stamps >= wanted.begin_ns) & ~is_mark(rows)
        if wanted.end_ns is not None:
            inside &= stamps < wanted.end_ns
        if inside.any():
            yield rows[inside]


def _first_ns(wanted: Wanted) -> int:
    return next((int(rows["record"]["time_ns"][0]) for rows in _parts(wanted)), 0)
