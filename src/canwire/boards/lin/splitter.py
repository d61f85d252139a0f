"""Copies each message of a LIN line to every active monitor, and counts the time for its stamps.

Source: VCI V4 manual 5.3.2 and 7.4.5 (TMOVR).
"""

from __future__ import annotations

from canwire.boards.lin.monitor import LAST, LinMonitor, Put
from canwire.bus.lin.node import LinResponse
from canwire.chips.lin.host import LinEar
from canwire.timeline import Timeline, Timer
from canwire.values.lin.event import LinEvent, LinEventKind

_COUNTER = 1 << 32


class LinSplitter(LinEar):
    """The monitors of one line. Times count from `origin_ns` on; it is None until the line is started."""

    def __init__(self, timeline: Timeline, tick_ns: int) -> None:
        self.origin_ns: int | None = None
        self.monitors: list[LinMonitor] = []
        self._active: list[LinMonitor] = []
        self._hearing: list[Put] = []
        self._hearing_own: list[Put] = []
        self.hears = self.hears_own = False
        self._timeline = timeline
        self._tick_ns = tick_ns
        self._timer: Timer | None = None
        self._overruns = 0

    @property
    def lost(self) -> int:
        """Messages that came when a queue was full."""
        return sum(monitor.lost for monitor in self.monitors)

    def open(self, monitor: LinMonitor) -> None:
        monitor.stamp(self.origin_ns or 0, self._tick_ns)
        self.monitors = [*self.monitors, monitor]
        self.sort()

    def dismiss(self, monitor: LinMonitor) -> None:
        self.monitors = [other for other in self.monitors if other is not monitor]
        self.sort()

    def sort(self) -> None:
        """Update the lists after a monitor was added, removed, activated or deactivated."""
        self._active = [monitor for monitor in self.monitors if monitor.active]
        hearing = [monitor for monitor in self._active if monitor.mode.frames]
        self._hearing = [monitor.put for monitor in hearing]
        self._hearing_own = [monitor.put for monitor in hearing if monitor.mode.own]
        self.hears, self.hears_own = bool(self._hearing), bool(self._hearing_own)

    def deliver(self, response: LinResponse, at_ns: int) -> None:
        for put in self._hearing:
            put(response.record, at_ns, LAST)

    def deliver_sent(self, response: LinResponse, at_ns: int) -> None:
        for put in self._hearing_own:
            put(response.sent_record, at_ns, LAST)

    def tell(self, event: LinEvent, *, stamped: bool = True) -> None:
        """Deliver an event to every active monitor; without `stamped` its time does not change."""
        if self._active:
            record = event.to_record()
            for monitor in self._active:
                monitor.deliver_event(event.kind, record, stamped)

    def begin_stamps(self) -> None:
        """Start the time-stamp counter at 0, at the first start after a reset; overruns are reported as events."""
        if self.origin_ns is None:
            self.origin_ns = self._timeline.now_ns
            for monitor in self.monitors:
                monitor.stamp(self.origin_ns, self._tick_ns)
            self._overruns = 0
            self._await_overrun()

    def end_stamps(self) -> None:
        self.origin_ns = None
        if self._timer is not None:
            self._timer.cancel()

    def _await_overrun(self) -> None:
        if self._tick_ns and self.origin_ns is not None:
            at_ns = self.origin_ns + (self._overruns + 1) * _COUNTER * self._tick_ns
            self._timer = self._timeline.at(at_ns, self._tell_overrun, background=True)

    def _tell_overrun(self) -> None:
        self._overruns += 1
        self.tell(LinEvent(LinEventKind.TIME_OVERRUN, self._timeline.now_ns, code=1))
        self._await_overrun()
