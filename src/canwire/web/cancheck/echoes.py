"""Frames that a line has sent, received on a separate channel that uses none of the driver's virtual channels.

With it a send-only window knows which frames were sent, and when, though its handle gets no TRANSMITTED events.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import CanwireError, ChannelMode, Siblings
from canwire.web.cancheck.recipe import Outgoing

if TYPE_CHECKING:
    from canwire import Frame
    from canwire.candrv.device.device import Device

QUEUE = 8192  # frames
_AT_ONCE = 512


class Echoes:
    """The frames that a device's line sends, from now until `close`. `take` never waits; `wait` may."""

    def __init__(self, device: Device) -> None:
        self._channel = device.hub.open_channel(device.board.id, device.number)
        try:
            self._channel.set_up(ChannelMode(QUEUE, 0, siblings=Siblings.EVERY, filter_size=0, fd=False))
            self._channel.activate()
        except CanwireError:
            self._channel.close()
            raise

    def take(self) -> list[tuple[Outgoing, int]]:
        """Return messages and the end of each on the bus in ns, oldest first."""
        frames: list[Frame] = []
        while more := self._channel.receive_many(_AT_ONCE, 0):
            frames += more
        return [(_message(frame), frame.timestamp_ns) for frame in frames if frame.self_received]

    def wait(self) -> None:
        """Wait until a frame was sent; raises CanwireError when the channel has ended."""
        self._channel.reading.wait(None)

    @property
    def lost(self) -> int:
        """Number of frames lost because the queue was full."""
        return self._channel.status().lost

    def close(self) -> None:
        """End all waits and close the channel; a second call does nothing."""
        self._channel.close()


def _message(frame: Frame) -> Outgoing:
    return Outgoing(frame.id, frame.extended, frame.remote, frame.dlc, bytes(frame.data))
