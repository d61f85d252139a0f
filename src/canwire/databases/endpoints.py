"""The endpoint of a port: a node of a lab or a channel on a shared line, recognised by its methods."""

from __future__ import annotations

from typing import Any, Protocol

from canwire.errors import Closed
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

AnyFrame = Frame | LinFrame
_PATIENCE_S = 0.2  # of a thread that waits for frames, before it checks whether the program still waits


class Endpoint(Protocol):
    """Sends and receives frames in order; `now_ns` is the time by the clock of received frames."""

    @property
    def name(self) -> str:
        """The name of the node or channel, for errors."""

    def now_ns(self) -> int:
        """Nanoseconds of the bus's time."""

    def send(self, frame: AnyFrame) -> None:
        """Queue the frame; a LIN frame is the response to its header from now on."""

    def receive(self, timeout: float) -> AnyFrame | None:
        """The oldest frame; None when none came in `timeout` seconds of the bus's time."""

    async def receive_async(self) -> AnyFrame | None:
        """The oldest frame, waiting for one; None once the endpoint is closed."""


class BenchEndpoint:
    """A node of a lab."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self.name: str = node.line.name

    def now_ns(self) -> int:
        return int(self._node.time.now_ns)

    def send(self, frame: AnyFrame) -> None:
        if isinstance(frame, LinFrame):
            self._node.respond(frame.id, frame)
        else:
            self._node.send(frame)

    def receive(self, timeout: float) -> AnyFrame | None:
        frame: AnyFrame | None = self._node.receive(timeout)
        return frame

    async def receive_async(self) -> AnyFrame | None:
        try:
            frame: AnyFrame | None = await self._node.receive_async()
        except Closed:
            return None
        return frame


class ChannelEndpoint:
    """A channel on a shared line, set up to receive frames; the program activates it."""

    def __init__(self, channel: Any) -> None:
        self._channel = channel
        self.name: str = channel.name

    def now_ns(self) -> int:
        return int(self._channel.hub.now_ns())

    def send(self, frame: AnyFrame) -> None:
        self._channel.send(frame)

    def receive(self, timeout: float) -> AnyFrame | None:
        frame: AnyFrame | None = self._channel.receive(timeout)
        return frame

    async def receive_async(self) -> AnyFrame | None:
        """Wait in a thread, but read the frame in the event loop: a cancelled task removes no frame from the queue."""
        import asyncio

        while True:
            try:
                frame: AnyFrame | None = self._channel.receive()
                if frame is not None:
                    return frame
                await asyncio.to_thread(self._channel.reading.wait, _PATIENCE_S)
            except Closed:
                return None


def endpoint_of(node: Any) -> Endpoint:
    """The endpoint for `node`; raises TypeError if it is neither a node nor a channel."""
    if hasattr(node, "receive_async") and hasattr(node, "time"):
        return BenchEndpoint(node)
    if hasattr(node, "reading") and hasattr(node, "hub"):
        return ChannelEndpoint(node)
    raise TypeError(f"{node!r}: a node of the lab or a channel on a shared line is needed")
