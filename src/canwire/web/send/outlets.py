"""A channel to send from on each line that something is sent on; made when it is first needed."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from canwire import CanwireError, ChannelMode, Frame, HubChannel, WrongState
from canwire.web.lines import find_can_line

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.web.link import HubLink

_QUEUE = 256  # frames


class Outlets:
    """Any thread may send. Channels go with the hub and with their boards, and are made anew."""

    def __init__(self, link: HubLink) -> None:
        self._link = link
        self._lock = threading.Lock()
        self._channels: dict[str, HubChannel] = {}
        link.subscribe(lambda _: None, self.close)

    def send(self, address: str, frame: Frame) -> None:
        """Queue it on that line; raises QueueFull, WrongState for a line that does not run, NoSuchBoard, HubLost."""
        with self._lock:
            channel = self._channels.get(address)
            if channel is not None and channel.over:
                self._channels.pop(address).close()
                channel = None
            if channel is None:
                channel = self._channels[address] = _opened(self._link.hub, address)
            if not channel.hub.line_status(channel.board, channel.line).running:
                self._channels.pop(address).close()  # it keeps nobody's line from being reset
                raise WrongState(f"{address} does not run: nothing can be sent there until it is started")
            channel.send(frame)

    def close(self) -> None:
        """Give all channels back; what is still queued goes with them."""
        with self._lock:
            channels, self._channels = self._channels, {}
        for channel in channels.values():
            channel.close()


def _opened(hub: Hub, address: str) -> HubChannel:
    place = find_can_line(hub, address)
    channel = hub.open_channel(place.board.id, place.line)
    try:
        channel.set_up(ChannelMode(receive=1, transmit=_QUEUE, frames=False))
        channel.activate()
    except CanwireError:
        channel.close()
        raise
    return channel
