"""The target of a replay: a channel of a CAN line, or a LIN line whose master is the page's server."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Protocol

from canwire import Busy, CanwireError, ChannelMode, Frame, HubChannel, LinFrame, QueueFull, WrongState
from canwire.web.lines import find_can_line

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.web.send.lin_outlets import LinOutlets

_QUEUE = 256
_WAIT_S = 0.05  # for room in a queue


class Sink(Protocol):
    """One line. Its methods raise only CanwireError, if the line, its board or the hub is lost."""

    def send(self, frame: Frame | LinFrame) -> bool:
        """Send a frame; returns False if there is no room yet, or the previous frame is not finished."""

    def counts(self) -> tuple[int, int]:
        """Return the number of frames that were acknowledged or received from the bus, and of those that still wait."""

    def cancel(self) -> None:
        """Discard the waiting frames."""

    def close(self) -> None:
        """Release the line; a second call does nothing."""


class CanSink:
    """A channel of a CAN line. Raises WrongState for a line that does not run, NoSuchBoard, HubLost."""

    def __init__(self, hub: Hub, address: str) -> None:
        place = find_can_line(hub, address)
        if not hub.line_status(place.board.id, place.line).running:
            raise WrongState(f"{address} does not run: nothing can be sent there until it is started")
        self._channel: HubChannel = hub.open_channel(place.board.id, place.line)
        try:
            self._channel.set_up(ChannelMode(receive=1, transmit=_QUEUE, frames=False))
            self._channel.activate()
        except CanwireError:
            self._channel.close()
            raise

    def send(self, frame: Frame | LinFrame) -> bool:
        assert isinstance(frame, Frame)
        with suppress(QueueFull):
            self._channel.send(frame, timeout=_WAIT_S)
            return True
        return False

    def counts(self) -> tuple[int, int]:
        status = self._channel.status()
        return status.delivered, status.pending

    def cancel(self) -> None:
        self._channel.cancel()

    def close(self) -> None:
        self._channel.close()


class LinSink:
    """A LIN line: sends headers, and the responses that the log contains.

    Raises WrongState for a line that is no running master, InUse, NoSuchBoard, HubLost.
    """

    def __init__(self, outlets: LinOutlets, address: str) -> None:
        self._outlets, self._address = outlets, address
        self._row = f"replay on {address}"
        outlets.hold(self._row, address)
        self._before = outlets.delivered(self._row)

    def send(self, frame: Frame | LinFrame) -> bool:
        assert isinstance(frame, LinFrame)
        with suppress(Busy):
            self._outlets.send(self._row, self._address, frame)
            return True
        return False

    def counts(self) -> tuple[int, int]:
        waits = self._outlets.under_way(self._row)  # before what was heard, so that its end is
        return self._outlets.delivered(self._row) - self._before, int(waits)

    def cancel(self) -> None:
        """Do nothing: a LIN line has no queue."""

    def close(self) -> None:
        self._outlets.drop(self._row)
