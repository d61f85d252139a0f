"""A shared LIN line as a source: a thread of the recorder empties a monitor on it."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from canwire.boards.lin.modes import LinLineStatus, LinMode, LinMonitorMode
from canwire.errors import BadValue, InUse
from canwire.hub.wanted_mode import WantedMode
from canwire.logs.batch import records_of_line
from canwire.logs.entry import LogEntry, LogMark, MarkKind
from canwire.logs.recording.hub_source import HubSource
from canwire.values.lin.event import LinEventKind

if TYPE_CHECKING:
    import numpy

    from canwire.hub.finding import LinePlace
    from canwire.hub.handles.hub import Hub
    from canwire.hub.handles.lin import Monitor

USUAL_BIT_RATE = 19_200
_QUEUE = 4096  # messages: many seconds of any LIN bus
_EVENTS = (LinEventKind.ERROR, LinEventKind.STATE, LinEventKind.WAKEUP, LinEventKind.SLEEP)


class SharedLinSource(HubSource):
    """The frames and events that a monitor receives; `epoch_ns` converts times to the wall clock."""

    def __init__(
        self, monitor: Monitor, name: str, epoch_ns: int, status: LinLineStatus | None, closing: ExitStack
    ) -> None:
        super().__init__(monitor, name, epoch_ns, closing)
        self._monitor = monitor
        self._status = status

    def take(self, timeout_s: float) -> numpy.ndarray:
        """Return frames and events in the order of reception."""
        end = self._monitor.reading
        if not end.ring.fill():
            self._monitor.check()
            if timeout_s:
                end.wait(timeout_s)
        found = records_of_line(end.ring.take_array(end.ring.capacity), 0, lin=True)
        end.touched()
        found["time_ns"] += self.epoch_ns
        return found

    def marks(self) -> list[LogEntry]:
        if self._status is None:
            return []
        now_ns = self.epoch_ns + self._status.time_ns
        marks = [LogMark(MarkKind.CLOCK, now_ns, text="hub")]
        if self._status.bit_rate:
            marks.append(LogMark(MarkKind.BIT_RATE, now_ns, bit_rate=self._status.bit_rate))
        return self._entries(marks)


def shared_lin_source(
    hub: Hub, place: LinePlace, wanted: WantedMode, name: str, epoch: int
) -> SharedLinSource:
    """Return a source with a monitor on this line, which is started as a slave if it does not run.

    `epoch` is what to add to the hub's time, in nanoseconds.
    Raises BadValue, HubError.
    """
    if wanted.data is not None:
        raise BadValue(f"data_bit_rate {wanted.data}: {place.address} is a LIN line")
    begin_ns = _status(hub, place).time_ns  # marks stand before all that is heard
    with ExitStack() as closing:
        monitor = closing.enter_context(hub.open_monitor(place.board.id, place.line))
        monitor.set_up(LinMonitorMode(receive=_QUEUE, events=tuple(map(int, _EVENTS))))
        monitor.activate()
        _start(hub, place, wanted.nominal)
        status = _status(hub, place)
        if status.running and wanted.nominal not in (None, status.bit_rate):
            raise BadValue(f"{place.address} runs at {status.bit_rate} bit/s; leave bit_rate out")
        began = replace(status, time_ns=begin_ns)
        source = SharedLinSource(monitor, name, epoch, began, closing.pop_all())
        source.address = place.address
        return source


def _start(hub: Hub, place: LinePlace, bit_rate: int | None) -> None:
    """Start the line if it does not run, unless another program has its control and may be about to start it."""
    if _status(hub, place).running:
        return
    try:
        with hub.open_lin_control(place.board.id, place.line) as control:
            mode = _status(hub, place).mode
            if mode is None or bit_rate not in (None, mode.bit_rate):
                control.initialise(LinMode(False, bit_rate or USUAL_BIT_RATE, errors=True))
            control.start()
    except InUse:
        return  # the monitor hears it from then on


def _status(hub: Hub, place: LinePlace) -> LinLineStatus:
    return hub.lin_status(place.board.id, place.line).status
