"""Records of LIN monitors as lines on stdout; with a description (LDF) each line ends with the signals."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from importlib import import_module
from typing import TYPE_CHECKING, Any

from canwire import (
    BadFrame,
    HubError,
    LinePlace,
    LinEvent,
    LinEventKind,
    LinFrame,
    LinLogLine,
    LinMonitorMode,
    epoch_ns,
    format_lin_log_line,
)

if TYPE_CHECKING:
    from canwire import Hub, Monitor

_QUEUE = 4096  # messages: many seconds of any LIN bus
_EVENTS = (LinEventKind.ERROR, LinEventKind.STATE, LinEventKind.WAKEUP, LinEventKind.SLEEP)


class Shown:
    """Messages of one monitor as lines on stdout."""

    def __init__(self, hub: Hub, monitor: Monitor, name: str, network: Any) -> None:
        self.lines = 0
        self._monitor = monitor
        self._name = name
        self._network = network
        self._epoch_ns = epoch_ns(hub)

    def show(self, message: LinFrame | LinEvent) -> None:
        """A log line, followed by the signals if a description knows the frame."""
        if isinstance(message, LinFrame):
            own, knows = message.sent, True
        else:
            own, knows = message.transmitting, message.kind is LinEventKind.ERROR
        direction = ("T" if own else "R") if knows else None
        line = LinLogLine(self._epoch_ns + message.timestamp_ns, self._name, message, direction)
        text = f"{format_lin_log_line(line)}{self._signals(message)}\n"
        self.lines += 1  # first: Python lets a signal raise behind a call, here that of `write`
        sys.stdout.write(text)
        sys.stdout.flush()

    def summary(self) -> str:
        """The numbers; without the lost ones where the hub cannot be asked any more."""
        try:
            return f"{self.lines} shown, {self._monitor.status().lost} lost"
        except HubError as error:
            return f"{self.lines} shown, lost unknown: {error}"

    def _signals(self, message: LinFrame | LinEvent) -> str:
        if self._network is None or not isinstance(message, LinFrame) or message.header_only:
            return ""
        try:
            values = self._network.decode(message)
        except BadFrame:
            return ""
        signals = ", ".join(f"{name} {value}" for name, value in values.items())
        return f"  {self._network.name_of(message.id)}: {signals}"


def opened_monitor(hub: Hub, place: LinePlace, closing: ExitStack, *, events: bool) -> Monitor:
    """Open a monitor on this line and activate it; `closing` closes it."""
    monitor = closing.enter_context(hub.open_monitor(place.board.id, place.line))
    monitor.set_up(LinMonitorMode(receive=_QUEUE, events=tuple(map(int, _EVENTS)) if events else ()))
    monitor.activate()
    return monitor


def loaded_network(path: str | None) -> Any:
    """The description in a file, None without one; BadDescription, ExtraMissing."""
    return None if path is None else import_module("canwire.ldf").load(path)
