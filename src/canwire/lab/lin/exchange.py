"""A master's request through the transport layer, and what comes back."""

from __future__ import annotations

from collections.abc import Callable

from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.errors import NotReceived
from canwire.lab.time import LabTime
from canwire.values.checks import nanoseconds
from canwire.values.lin.configuration import CONDITIONAL_CHANGE_NAD
from canwire.values.lin.frame import MASTER_REQUEST, SLAVE_RESPONSE, LinFrame
from canwire.values.lin.transport import BROADCAST_NAD, FUNCTIONAL_NAD, LinReassembly, segments

_QUEUE = 1024
_AGAIN_NS = 10_000_000  # a slave that was silent is asked anew so much later
_LOOK_NS = 1_000_000


class Exchange:
    """One request of this master's line and its response; other traffic goes on meanwhile."""

    def __init__(self, time: LabTime, line: LinLine, nad: int) -> None:
        self._time = time
        self._line = line
        self._nad = nad
        self._response = LinReassembly()
        self._asked_ns = 0
        self._monitor = line.open(LinMonitor(LinMonitorMode(_QUEUE, own=True, events=())))
        line.activate(self._monitor)

    def run(self, payload: bytes, within: float) -> bytes:
        """Send it, frame after frame, and fetch the response; b"" for a functional request, which has none."""
        deadline_ns = self._time.now_ns + nanoseconds("within", within)
        try:
            for data in segments(self._nad, payload):
                self._send(LinFrame(MASTER_REQUEST, data), deadline_ns)
            if payload[0] == CONDITIONAL_CHANGE_NAD and len(payload) == 6:
                self._nad = payload[5]  # that service alone is answered by the new NAD
            return b"" if self._nad == FUNCTIONAL_NAD else self._fetch(deadline_ns)
        finally:
            self._line.dismiss(self._monitor)

    def _send(self, frame: LinFrame, deadline_ns: int) -> None:
        self._await(lambda: not self._line.busy, deadline_ns, "the line is busy")
        with self._time.touch():
            self._line.send(frame)
        self._await(lambda: not self._line.busy, deadline_ns, "the request did not go out")

    def _fetch(self, deadline_ns: int) -> bytes:
        self._asked_ns = -_AGAIN_NS
        while True:
            while (message := self._monitor.take()) is not None:
                if (
                    not isinstance(message, LinFrame)
                    or message.id != SLAVE_RESPONSE
                    or len(message.data) != 8
                ):
                    continue
                self._asked_ns = -_AGAIN_NS
                found = self._response.frame(message.data, message.timestamp_ns)
                if found is not None and self._nad in (found.nad, BROADCAST_NAD):
                    return found.payload
            if self._time.now_ns >= deadline_ns:
                raise NotReceived(f"{self._line.name}: no response of NAD {self._nad:#04x} to its request")
            self._ask()
            self._time.run_until(min(deadline_ns, self._time.now_ns + _LOOK_NS))

    def _ask(self) -> None:
        if not self._line.busy and self._time.now_ns - self._asked_ns >= _AGAIN_NS:
            self._asked_ns = self._time.now_ns
            with self._time.touch():
                self._line.ask(SLAVE_RESPONSE, 8, None, silence_is_fine=True)

    def _await(self, ready: Callable[[], bool], deadline_ns: int, why: str) -> None:
        while not ready():
            if self._time.now_ns >= deadline_ns:
                raise NotReceived(f"{self._line.name}: {why} in time")
            self._time.run_until(min(deadline_ns, self._time.now_ns + _LOOK_NS))
