"""A channel for each row that is sent; it is opened when first needed, and closed when the row is stopped.

With a separate channel, the frames of a row on the bus can be counted, and closing it discards the waiting ones.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import CanwireError, ChannelMode, Frame, HubChannel, WrongState
from canwire.web.lines import find_can_line

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.web.link import HubLink

_QUEUE = 2  # frames: a row waits until its last one was acknowledged


class _Outlet(NamedTuple):
    address: str
    channel: HubChannel


class Outlets:
    """The channels, for use by any thread. If the hub or a board is lost, its channels end and are
    later opened again."""

    def __init__(self, link: HubLink) -> None:
        self._link = link
        self._lock = threading.Lock()
        self._outlets: dict[int, _Outlet] = {}
        self._before: dict[int, int] = {}  # frames that channels have sent that are closed
        link.subscribe(lambda _: None, self.close)

    def send(self, row: int, address: str, frame: Frame) -> None:
        """Queue the frame on that line.

        Raises WrongState for a line that does not run, or while the row's last frame still waits to be acknowledged;
        NoSuchBoard, HubLost.
        """
        with self._lock:
            outlet = self._outlets.get(row)
            if outlet is not None and (outlet.channel.over or outlet.address != address):
                self._close(row)
                outlet = None
            if outlet is None:
                outlet = self._outlets[row] = _Outlet(address, _opened(self._link.hub, address))
            channel = outlet.channel
            if not channel.hub.line_status(channel.board, channel.line).running:
                self._close(row)  # it keeps nobody's line from being reset
                raise WrongState(f"{address} does not run: nothing can be sent there until it is started")
            if channel.status().pending:
                raise WrongState(f"{address}: the last frame still waits, since nobody has acknowledged it")
            channel.send(frame)

    def delivered(self, row: int) -> int:
        """Number of frames of this row that were acknowledged on the bus."""
        with self._lock:
            count = self._before.get(row, 0)
            outlet = self._outlets.get(row)
            if outlet is not None:
                with suppress(CanwireError):  # it has just gone: what it had sent last is not known
                    count += outlet.channel.status().delivered
        return count

    def drop(self, row: int) -> None:
        """Send no more frames of this row."""
        with self._lock:
            self._close(row)

    def close(self) -> None:
        """Close all channels; frames that are still queued are discarded."""
        with self._lock:
            for row in list(self._outlets):
                self._close(row)

    def _close(self, row: int) -> None:
        outlet = self._outlets.pop(row, None)
        if outlet is not None:
            with suppress(CanwireError):  # as above
                self._before[row] = self._before.get(row, 0) + outlet.channel.status().delivered
            outlet.channel.close()


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
