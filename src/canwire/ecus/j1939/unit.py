"""can-j1939's ElectronicControlUnit on a node of the lab: timers and the transport protocol in the lab's time.

Source: can-j1939 2.0 (ElectronicControlUnit, J1939_21).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib.util import find_spec, module_from_spec
from typing import Any

from j1939 import ElectronicControlUnit

from canwire import Frame, LabNode, Timer
from canwire.ecus.bench import LabFrames

_IDLE_S = 5.0  # the transport layer is checked again after this time when no message is on its way
_AGAIN_NS = 1_000_000  # after which it is checked again when it says "immediately"
Callback = Callable[[Any], Any]


class _LabClock:
    """Replaces the module `time` for the transport layer."""

    def __init__(self, node: LabNode) -> None:
        self._time = node.time

    def time(self) -> float:
        return self._time.now_ns / 1e9


class LabJ1939(ElectronicControlUnit):  # type: ignore[misc]
    """A unit that is connected from its creation and receives all frames of `node`.

    Controller applications are added as in can-j1939. A lab with waiting timers counts as idle, one with queued
    messages does not. `errors` are the exceptions that invalid frames have caused. `max_cmdt_packets` (1 to 255) is the
    number of packets that a CTS allows. Only classic frames are used (J1939-21).
    """

    def __init__(self, node: LabNode, max_cmdt_packets: int = 1) -> None:
        self.node = node
        self._clock = _LabClock(node)
        self._timers: list[tuple[Callback, Timer]] = []
        self._turn_timer: Timer | None = None
        super().__init__(max_cmdt_packets=max_cmdt_packets)
        self._job_thread.join()  # has nothing to do here
        self.j1939_dll = _transport_by(self._clock)(
            self.send_message,
            self._job_thread_wakeup,
            self._notify_subscribers,
            max_cmdt_packets,
            None,
            None,
            self._is_message_acceptable,
        )
        self._frames = LabFrames(node, self._take)

    @property
    def errors(self) -> list[Exception]:
        return self._frames.errors

    def add_timer(self, delta_time: float, callback: Callback, cookie: Any = None) -> None:
        """Call `callback` after `delta_time` seconds of the lab's time, and repeatedly while it returns True."""
        time, period_ns = self.node.time, max(1, round(delta_time * 1e9))

        def start(due_ns: int) -> None:
            def turn() -> None:
                self._timers.remove(entry)
                if callback(cookie):
                    start(due_ns + period_ns)

            with time.touch():  # in real time it could be due before it is listed
                entry = callback, time.at(due_ns, turn, background=True)
                self._timers.append(entry)

        start(time.timeline.now_ns + period_ns)

    def remove_timer(self, callback: Callback) -> None:
        """Remove all timers of this callback."""
        for entry in [entry for entry in self._timers if entry[0] == callback]:
            entry[1].cancel()
            self._timers.remove(entry)

    def stop(self) -> None:
        """Stop sending and receiving; the node stays on its bus."""
        for _, timer in self._timers:
            timer.cancel()
        self._timers.clear()
        if self._turn_timer is not None:
            self._turn_timer.cancel()
        self._frames.close()

    disconnect = stop

    def send_message(self, can_id: int, extended_id: bool, data: Any, fd_format: bool = False) -> None:
        """Queue a frame. Raises QueueFull, Closed."""
        self.node.send(Frame(can_id, bytes(data), extended=extended_id))

    def __repr__(self) -> str:
        return f"<J1939 on {self.node.line.name}: {len(self.j1939_dll._cas)} applications; {len(self.errors)} errors>"

    def _take(self, frame: Frame) -> None:
        if frame.extended and not frame.fd:
            self.notify(frame.id, bytearray(frame.data), (frame.timestamp_ns or 0) / 1e9)

    def _async_job_thread(self) -> None:
        """Do nothing: timers and turns run in the lab's time, without a thread."""

    def _job_thread_wakeup(self) -> None:
        self._turn_at(self.node.time.timeline.now_ns)

    def _turn_at(self, due_ns: int) -> None:
        with self.node.time.touch():
            if self._turn_timer is not None:
                self._turn_timer.cancel()
            self._turn_timer = self.node.time.at(due_ns, self._turn)

    def _turn(self) -> None:
        self._turn_timer = None
        now_ns, now_s = self.node.time.timeline.now_ns, self._clock.time()
        next_s = self.j1939_dll.async_job_thread(now_s)
        if self._turn_timer is None and next_s < now_s + _IDLE_S:
            soonest_ns = now_ns + (1 if next_s > now_s else _AGAIN_NS)  # a deadline may be a rounding away
            self._turn_at(max(soonest_ns, math.ceil(next_s * 1e9)))


def _transport_by(clock: _LabClock) -> Any:
    """Load a copy of can-j1939's J1939_21 whose `time` is this clock; other users keep the original module."""
    found = find_spec("j1939.j1939_21")
    assert found is not None
    assert found.loader is not None
    module = module_from_spec(found)
    found.loader.exec_module(module)
    module.time = clock  # type: ignore[attr-defined]
    return module.J1939_21
