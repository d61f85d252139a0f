"""LIN lines that send rows and schedules: their control is held as long as something is sent."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import (
    CanwireError,
    LinControl,
    LinEventKind,
    LinFrame,
    LinMode,
    LinMonitorMode,
    Monitor,
    NoSuchBoard,
    WrongState,
    every_line,
)

if TYPE_CHECKING:
    from canwire import Hub, LinePlace, LinSchedule
    from canwire.web.link import HubLink

_QUEUE = 1024
_NO_ID = -1  # of an error in a header
Sender = int | str
"""Who sends: a row of the transmit list by its number, or something else by its name."""


class _Held:
    """The control of one line, and the monitor that receives its frames."""

    def __init__(self, hub: Hub, place: LinePlace) -> None:
        self.place = place
        self.control: LinControl = hub.open_lin_control(place.board.id, place.line)
        self.monitor: Monitor = hub.open_monitor(place.board.id, place.line)
        self.rows: set[Sender] = set()
        self.scheduled = False
        self.waiting: list[tuple[Sender, int]] = []  # whose frames were not heard yet, and their identifiers
        try:
            self.monitor.set_up(LinMonitorMode(receive=_QUEUE, events=(int(LinEventKind.ERROR),)))
            self.monitor.activate()
        except CanwireError:
            self.close()
            raise

    def close(self) -> None:
        self.control.close()
        self.monitor.close()


class LinOutlets:
    """The LIN lines, for use by any thread. Control of a line is released when idle, because only its holder can be
    master."""

    def __init__(self, link: HubLink) -> None:
        self._link = link
        self._lock = threading.RLock()
        self._held: dict[str, _Held] = {}
        self._kept_up: dict[
            str, Monitor
        ] = {}  # of lines started here: the hub resets a LIN line that nobody holds
        self._delivered: dict[Sender, int] = {}
        link.subscribe(lambda _: None, self.close)

    def bring_up(self, address: str, bit_rate: int, *, master: bool) -> None:
        """Start this line; it runs until `shut_down` or the server's end. Raises InUse, NoSuchBoard, BadValue."""
        with self._lock:
            place = find_lin_line(self._link.hub, address)
            held = self._held.get(address)
            mode = LinMode(master, bit_rate, errors=True)
            if held is not None:
                self._drop_line(address)
            self._give_up(address)
            with self._link.hub.open_lin_control(place.board.id, place.line) as control:
                control.initialise(mode)
                control.start()
                self._kept_up[address] = self._link.hub.open_monitor(place.board.id, place.line)

    def shut_down(self, address: str) -> None:
        """Stop the line; raises InUse, NoSuchBoard."""
        with self._lock:
            place = find_lin_line(self._link.hub, address)
            self._drop_line(address)
            with self._link.hub.open_lin_control(place.board.id, place.line) as control:
                control.stop()
            self._give_up(address)

    def send(self, row: Sender, address: str, frame: LinFrame) -> None:
        """Send the frame as soon as the bus is free.

        Raises WrongState for a line that is no running master, Busy while the previous frame is not finished,
        NoSuchBoard.
        """
        with self._lock:
            held = self._line(address)
            try:
                self._listen(held)
                held.control.send(frame)
            except CanwireError:
                self._let_go(address)
                raise
            held.rows.add(row)
            held.waiting.append((row, frame.id))

    def hold(self, row: Sender, address: str) -> None:
        """Keep the line's control until `drop`; raises WrongState for a line that is no running master, InUse."""
        with self._lock:
            self._line(address).rows.add(row)

    def under_way(self, row: Sender) -> bool:
        """Whether a frame of this row is in progress: neither it nor an error in its place was received yet."""
        with self._lock:
            for held in self._held.values():
                if row in held.rows:
                    self._listen(held)
                    waits = any(sender == row for sender, _ in held.waiting)
                    return waits and held.control.status().status.running
        return False

    def delivered(self, row: Sender) -> int:
        """Number of frames of this row that were received from the bus; a header counts with its response."""
        with self._lock:
            for held in self._held.values():
                with suppress(CanwireError):  # gone with its hub or board
                    self._listen(held)
            return self._delivered.get(row, 0)

    def drop(self, row: Sender) -> None:
        """Stop sending this row."""
        with self._lock:
            for address, held in list(self._held.items()):
                if row in held.rows:
                    with suppress(CanwireError):  # as above
                        self._listen(held)
                    held.rows.discard(row)
                    self._let_go(address)

    def schedule(self, address: str, table: LinSchedule, frames: list[LinFrame], rounds: int) -> None:
        """Run this table in the hub, `rounds` times (0: without end), instead of a running one; raises the errors of
        `send`."""
        with self._lock:
            held = self._line(address)
            try:
                for frame in frames:
                    held.control.respond(frame)
                held.control.run_schedule(table, rounds)
                held.scheduled = True
            finally:
                self._let_go(address)

    def stop_schedules(self, address: str = "") -> None:
        """End the schedule of this line, or of every line."""
        with self._lock:
            for one, held in list(self._held.items()):
                if held.scheduled and one == (address or one):
                    with suppress(CanwireError):  # as above
                        held.control.stop_schedule()
                    held.scheduled = False
                    self._let_go(one)

    @property
    def scheduled(self) -> list[str]:
        """The lines with a schedule that runs, or has completed its rounds."""
        with self._lock:
            return [one for one, held in self._held.items() if held.scheduled and not held.control.over]

    def close(self) -> None:
        """Release all lines; schedules end."""
        with self._lock:
            self.stop_schedules()
            for address in list(self._held):
                self._drop_line(address)
            for address in list(self._kept_up):
                self._give_up(address)

    def _give_up(self, address: str) -> None:
        kept = self._kept_up.pop(address, None)
        if kept is not None:
            kept.close()

    def _line(self, address: str) -> _Held:
        held = self._held.get(address)
        if held is not None and held.control.over:
            self._drop_line(address)
            held = None
        hub = self._link.hub
        if held is None:
            place = find_lin_line(hub, address)
            status = hub.lin_status(place.board.id, place.line).status
            if not status.running or status.mode is None or not status.mode.master:
                raise WrongState(f"{address} is no running master: start it as one under LIN")
            held = self._held[address] = _Held(hub, place)
        return held

    def _listen(self, held: _Held) -> None:
        """Count the received frames; a frame that was sent before a received one is finished, too."""
        while (message := held.monitor.receive()) is not None:
            fits = [place for place, (_, id) in enumerate(held.waiting) if message.id in (id, _NO_ID)]
            if not fits:
                continue
            row = held.waiting[fits[0]][0]
            if isinstance(message, LinFrame):
                self._delivered[row] = self._delivered.get(row, 0) + 1
            del held.waiting[: fits[0] + 1]

    def _let_go(self, address: str) -> None:
        held = self._held.get(address)
        if held is not None and not held.rows and not held.scheduled:
            self._drop_line(address)

    def _drop_line(self, address: str) -> None:
        held = self._held.pop(address, None)
        if held is not None:
            held.close()


def find_lin_line(hub: Hub, address: str) -> LinePlace:
    """The LIN line of exactly this address; raises NoSuchBoard."""
    for place in every_line(hub, "LIN"):
        if place.address == address:
            return place
    raise NoSuchBoard(f"{address or 'no address'}: there is no such LIN line any more")
