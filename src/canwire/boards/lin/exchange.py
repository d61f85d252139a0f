"""A master's request through the transport layer and its response, one step after the other in bus time."""

from __future__ import annotations

from collections.abc import Callable

from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.errors import CanwireError, NotReceived
from canwire.values.lin.configuration import CONDITIONAL_CHANGE_NAD
from canwire.values.lin.frame import MASTER_REQUEST, SLAVE_RESPONSE, LinFrame
from canwire.values.lin.transport import BROADCAST_NAD, FUNCTIONAL_NAD, LinReassembly, segments

_QUEUE = 1024
_AGAIN_NS = 10_000_000  # the wait before a silent slave is polled again
_LOOK_NS = 1_000_000

Answered = Callable[[bytes | CanwireError], None]


class LinExchange:
    """One request of a master's line; other traffic of that line continues meanwhile.

    `done` is called once: with the payload of the response; with b"" for a functional request, which no slave answers;
    with NotReceived `within_ns` after `begin`; or with an error that keeps the line from sending.
    """

    def __init__(self, line: LinLine, nad: int, payload: bytes, within_ns: int, done: Answered) -> None:
        self._line = line
        self._timeline = line.timeline
        self._requests = [LinFrame(MASTER_REQUEST, data) for data in segments(nad, payload)]
        self._nad = nad
        if payload[0] == CONDITIONAL_CHANGE_NAD and len(payload) == 6:
            self._answers = payload[5]  # that service alone is answered by the new NAD
        else:
            self._answers = nad
        self._deadline_ns = line.timeline.now_ns + within_ns
        self._asked_ns = -_AGAIN_NS
        self._response = LinReassembly()
        self._done: Answered | None = done
        self._monitor = LinMonitor(LinMonitorMode(_QUEUE, own=True, events=()))

    def begin(self) -> None:
        """Send the first frame when the line is free. Raises the errors of line.send except Busy."""
        self._line.open(self._monitor)
        self._line.activate(self._monitor)
        try:
            self._go_on()
        except CanwireError:
            self._line.dismiss(self._monitor)
            raise

    def _step(self) -> None:
        try:
            self._go_on()
        except CanwireError as error:  # the line was stopped or set up again meanwhile
            self._finish(error)

    def _go_on(self) -> None:
        found = self._heard()
        if found is not None:
            self._finish(found)
            return
        now_ns = self._timeline.now_ns
        if now_ns >= self._deadline_ns:
            self._finish(NotReceived(f"{self._line.name}: {self._why()}"))
            return
        if not self._line.busy:
            if self._requests:
                self._line.send(self._requests.pop(0))
            elif self._answers == FUNCTIONAL_NAD:
                self._finish(b"")
                return
            elif now_ns - self._asked_ns >= _AGAIN_NS:
                self._asked_ns = now_ns
                self._line.ask(SLAVE_RESPONSE, 8, None, silence_is_fine=True)
        self._timeline.at(min(self._deadline_ns, now_ns + _LOOK_NS), self._step)

    def _heard(self) -> bytes | None:
        """The payload of the response, once its last frame has come; else None."""
        while (message := self._monitor.take()) is not None:
            if not isinstance(message, LinFrame) or message.id != SLAVE_RESPONSE or len(message.data) != 8:
                continue
            self._asked_ns = -_AGAIN_NS
            found = self._response.frame(message.data, message.timestamp_ns)
            if found is not None and self._answers in (found.nad, BROADCAST_NAD):
                return found.payload
        return None

    def _why(self) -> str:
        if self._requests or (self._line.busy and self._asked_ns < 0):
            return "the request did not go out in time"
        return f"no response of NAD {self._answers:#04x} to its request"

    def _finish(self, result: bytes | CanwireError) -> None:
        done, self._done = self._done, None
        self._line.dismiss(self._monitor)
        if done is not None:
            done(result)
