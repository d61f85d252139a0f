"""The services of a lab node that a protocol library needs: its frames, periodic messages, waits in the lab's time."""

from __future__ import annotations

import struct
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial

from canwire import BadValue, Closed, Frame, LabNode, Periodic, QueueFull

# what libraries raise for frames that are too short, or make no sense
_NONSENSE = (struct.error, LookupError, TypeError, ValueError, RuntimeError)


class LabFrames:
    """Calls `take` with the frames of `node` while the bus runs; remote frames are skipped.

    `errors` lists, in order, the exceptions that `take` raised for invalid frames; a library's own listener would log
    them.
    """

    def __init__(self, node: LabNode, take: Callable[[Frame], None]) -> None:
        self.node = node
        self.errors: list[Exception] = []
        self._take = take
        node.on_frames(partial(node.time.soon, partial(node.each_frame, self._hand_over)))

    def close(self) -> None:
        """Stop; the node stays on its bus."""
        self.node.on_frames(None)

    def _hand_over(self, frame: Frame) -> None:
        if frame.remote:
            return
        try:
            self._take(frame)
        except _NONSENSE as error:
            self.errors.append(error.with_traceback(None))  # nor the objects that it refers to


class LabTask:
    """Sends a frame immediately, and then every `period` seconds of the lab's time; replaces a bus's `send_periodic`.

    `missed` counts frames for which the queue had no room, for example without an acknowledging node.
    Raises BadValue for a period under 1 ns.
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
        """Stop sending; a second call does nothing."""
        self._periodic.cancel()

    def update(self, data: bytes) -> None:
        """Change the data, from the next frame on."""
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
    """Replaces a threading.Condition: the lab's time passes during a wait."""

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
        """Wait for a notification; False after `timeout` seconds. The lock is not held meanwhile."""
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
