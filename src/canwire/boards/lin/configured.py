"""A slave that answers node configuration and transport layer requests, as bought slaves do."""

from __future__ import annotations

from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.timeline import Timer
from canwire.values.lin.configuration import LinNodeAttributes, LinSlaveConfiguration
from canwire.values.lin.frame import MASTER_REQUEST, SLAVE_RESPONSE, LinFrame

_QUEUE = 64


class ConfiguredSlave:
    """Runs values/lin/configuration.py on a line: it reads received frames, and its answers become responses.

    It has a separate queue, so other monitors of the line receive everything as before. It ends when the settings
    and responses of the line are cleared, or with `close`.
    """

    def __init__(self, line: LinLine, attributes: LinNodeAttributes) -> None:
        self.configuration = LinSlaveConfiguration(attributes)
        self._line = line
        self._timeline = line.timeline
        self._placed: dict[int, int | None] = dict(attributes.frames)
        self._kept: dict[int, object] = {}  # frames without an identifier
        self._timer: Timer | None = None
        self._monitor = line.open(LinMonitor(LinMonitorMode(_QUEUE, own=True, events=())))
        line.activate(self._monitor)
        self._monitor.ring.listener = self._listen
        line.when_cleared()  # another one ends
        line.when_cleared = self.close

    def power_up(self) -> None:
        """Act as after a power cycle: settings that were not saved are lost."""
        self.configuration.power_up()
        self._apply()

    @property
    def answers(self) -> bool:
        """Whether it still answers: `close` or a cleared line ends it."""
        return self._monitor.ring.listener is not None

    def close(self) -> None:
        """Stop answering; a second call does nothing."""
        if not self.answers:
            return
        self._monitor.ring.listener = None
        self._line.dismiss(self._monitor)
        self._line.when_cleared = lambda: None
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _listen(self) -> None:
        """Schedule `_take` for a frame that came while the bus was working; it runs when that work is done."""
        self._timeline.at(self._timeline.now_ns, self._take)

    def _take(self) -> None:
        while (message := self._monitor.take()) is not None:
            if not isinstance(message, LinFrame):
                continue
            if message.id == MASTER_REQUEST and len(message.data) == 8:
                self.configuration.request(message.data, message.timestamp_ns)
            elif message.id == SLAVE_RESPONSE and message.sent:
                self.configuration.fetched(message.timestamp_ns)
        self._apply()

    def _apply(self) -> None:
        """Apply the present configuration to the line."""
        self._move_frames()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        now_ns = self._timeline.now_ns
        answer, driver = self.configuration.response(now_ns), self._line.driver
        if answer is None:
            driver.withdraw(SLAVE_RESPONSE)
        else:
            driver.respond(LinFrame(SLAVE_RESPONSE, answer), once=True)
        times = (self.configuration.ready_ns, self.configuration.due_ns)
        later = [time_ns for time_ns in times if time_ns is not None and time_ns > now_ns]
        if later:
            self._timer = self._timeline.at(min(later), self._apply, background=True)

    def _move_frames(self) -> None:
        wanted, driver = self.configuration.identifiers, self._line.driver
        moved = [key for key, id in wanted.items() if id != self._placed.get(key)]
        for key in moved:
            before = self._placed[key]
            if before is not None:
                self._kept[key] = driver.take(before)
        for key in moved:
            id = self._placed[key] = wanted[key]
            if id is not None:
                driver.place(id, self._kept.pop(key))
