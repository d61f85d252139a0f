"""What a protocol's library needs of a node of the lab: its frames, periodic messages, waits in its time."""

from __future__ import annotations

import struct
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial

from canwire import BadValue, Closed, Frame, LabNode, Periodic, QueueFull

# what libraries raise for frames that are too short, or make no sense
_NONSENSE = (struct.error, LookupError, TypeError, ValueError, RuntimeError)


class LabFrames:
    """Hands the frames of `node` to `take`, within the bus's run; remote frames are left out.

    `errors` has what `take` made of frames that make no sense, in order: a library's own listener would log it.
    """

    def __init__(self, node: LabNode, take: Callable[[Frame], None]) -> None:
        self.node = node
        self.errors: list[Exception] = []
        self._take = take
        node.on_frames(partial(node.time.soon, partial(node.each_frame, self._hand_over)))

    def close(self) -> None:
        """No more; the node stays on its bus."""
        self.node.on_frames(None)

    def _hand_over(self, frame: Frame) -> None:
        if frame.remote:
            return
        try:
            self._take(frame)
        except _NONSENSE as error:
            self.errors.append(error.with_traceback(None))  # nor what it holds on to


class LabTask:
    """Sends a frame at once, and again each `period` seconds of the lab's, in the place of a bus's `send_periodic`.

    `missed` counts those for which there was no room: nobody acknowledges, say. Raises BadValue for no time.
    """

    def __init__(self, node: LabNode, frame: Frame, period: float) -> None:
        period_ns = round(period * 1e9)
        if period_ns <= 0:
            raise BadValue(f"period {period} s: at least one nanosecond")
        self.missed = 0
        self._node = node
        self._frame = frame
        self._periodic = Periodic(node, period_ns, self._send)
        self._send()

    def stop(self) -> None:
        """A second time does nothing."""
        self._periodic.cancel()

    def update(self, data: bytes) -> None:
        """Other data from the next one on."""
        frame = self._frame
        self._frame = Frame(frame.id, bytes(data), extended=frame.extended, remote=frame.remote)

    def __repr__(self) -> str:
        return f"<{self._frame!r}, {self._periodic!r}, {self.missed} missed>"

    def _send(self) -> None:
        try:
            self._node.send(self._frame)
        except QueueFull:
            self.missed += 1
        except Closed:
            self.stop()


class LabCondition:
    """In the place of a threading.Condition: who waits lets the lab's time pass."""

    def __init__(self, node: LabNode) -> None:
        self._time = node.time
        self._notified = 0
        self._held: list[AbstractContextManager[None]] = []

    def __enter__(self) -> None:
        holding = self._time.touch()
        holding.__enter__()
        self._held.append(holding)

    def __exit__(self, *error: object) -> None:
        self._held.pop().__exit__(None, None, None)

    def wait(self, timeout: float) -> bool:
        """Until somebody notifies, or `timeout` seconds are over: False. Nothing is held meanwhile."""
        before = self._notified
        self.__exit__()
        try:
            return self._time.advance(
                self._time.now_ns + round(timeout * 1e9), lambda: self._notified != before
            )
        finally:
            self.__enter__()

    def notify_all(self) -> None:
        self._notified += 1
        self._time.timeline.halt()
