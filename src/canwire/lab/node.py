"""What CAN and LIN nodes of a lab have in common: a name, and received frames, with or without asyncio."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from typing import Generic, TypeVar

from canwire.errors import Closed, NotReceived
from canwire.lab.listening import Listening
from canwire.lab.time import LabTime
from canwire.ring import Ring
from canwire.timeline import NEVER
from canwire.values.checks import nanoseconds
from canwire.values.mistakes.names import answers_wrong_names

FrameT = TypeVar("FrameT")
BusT = TypeVar("BusT")
_SHOWN = 5  # of the frames that came instead


@answers_wrong_names
class BenchNode(Generic[FrameT, BusT]):
    """Receives frames through `ring`; `take` returns its oldest frame, or None. Errors name it by `full_name`.

    The type of its bus is a parameter: bus classes depend on node classes, not the reverse.
    """

    def __init__(
        self,
        time: LabTime,
        bus: BusT,
        name: str,
        full_name: str,
        ring: Ring,
        take: Callable[[], FrameT | None],
    ) -> None:
        self.time = time
        self.bus = bus
        self.name = name
        self._full_name = full_name
        self._ring = ring
        self._take = take
        self._closed = False

    # receiving

    def receive(self, timeout: float | None = None) -> FrameT | None:
        """The oldest frame received, or None.

        With a `timeout` in seconds, time passes until a frame arrives or the timeout is over.
        """
        frame = self._take()
        if frame is None and self._closed:
            self._check_open()
        if frame is None and timeout is not None:
            self._wait(self.time.now_ns + nanoseconds("timeout", timeout))
            frame = self._take()
        return frame

    def receive_many(self, limit: int) -> list[FrameT]:
        """Up to `limit` frames, oldest first, without waiting."""
        frames: list[FrameT] = []
        while len(frames) < limit and (frame := self._take()) is not None:
            frames.append(frame)
        return frames

    def each_frame(self, use: Callable[[FrameT], object]) -> None:
        """Call `use` with each received frame, oldest first, also with frames that arrive during these calls."""
        take = self._take
        while (frame := take()) is not None:
            use(frame)

    async def receive_async(self, timeout: float | None = None) -> FrameT | None:
        """Wait for the oldest frame; None after `timeout` seconds. A cancelled call removes no frame from the queue."""
        deadline_ns = NEVER if timeout is None else self.time.now_ns + nanoseconds("timeout", timeout)
        with Listening(self._ring, self.time.active):
            while True:
                self._check_open()
                frame = self._take()
                if frame is not None or self.time.now_ns >= deadline_ns:
                    return frame
                await self.time.turn(deadline_ns, lambda: self._closed or self._ring.fill() > 0)

    async def __aiter__(self) -> AsyncIterator[FrameT]:
        while not self._closed:
            frame = await self.receive_async()
            if frame is not None:
                yield frame

    def expect_nothing(self, *, within: float) -> None:
        """Let `within` seconds pass; raises NotReceived if any frame arrives."""
        frame = self.receive(within)
        if frame is not None:
            raise NotReceived(f"{self._full_name}: {frame!r} arrived where silence was expected")

    @property
    def waiting(self) -> int:
        """Number of frames received but not read yet."""
        return self._ring.fill()

    def on_frames(self, callback: Callable[[], None] | None) -> None:
        """Call `callback`, while the bus runs, when the empty receive queue gets a frame; None removes it."""
        self._ring.listener = callback

    # taking part

    def close(self) -> None:
        """Leave the bus permanently; a second call does nothing."""
        if not self._closed:
            self._closed = True
            self._leave()
            self.time.active()

    def _leave(self) -> None:
        """Leave the bus; the caller has stopped the timeline (`LabTime.touch`)."""
        raise NotImplementedError

    def _expect(self, wanted: Callable[[FrameT], bool], what: str, within: float) -> FrameT:
        """The first frame that is `wanted`, discarding others; raises NotReceived with `what` in its message."""
        deadline_ns = self.time.now_ns + nanoseconds("within", within)
        others: list[FrameT] = []
        while True:
            frame = self.receive(max(0.0, (deadline_ns - self.time.now_ns) / 1e9))
            if frame is None:
                break
            if wanted(frame):
                return frame
            others.append(frame)
        came = ", ".join(map(repr, others[-_SHOWN:])) or "nothing"
        raise NotReceived(
            f"{self._full_name}: no frame {what} within {within:g} s; {len(others)} others, last: {came}"
        )

    def _wait(self, deadline_ns: int) -> None:
        with Listening(self._ring, self.time.timeline.halt):
            self.time.advance(deadline_ns, lambda: self._ring.fill() > 0)

    def leave_to_parent(self) -> None:
        """In a process forked from a lab in real time: each later use raises an error that names the owner."""
        self._closed = True

    def _check_open(self) -> None:
        if self._closed:
            self.time.check_here()
            raise Closed(f"node {self.name}")
