"""The common part of both ends of a message of several frames: timeouts, control frames, and the end.

Source: SAE J1939-21 5.10.2.4 and 5.10.3; times are those of Linux.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from canwire.socketcan.j1939.addresses import Cancellable, Timers
from canwire.socketcan.j1939.codes import ABORT, PAD, Abort, Kind, error_of
from canwire.socketcan.j1939.message import Message

GAP_S = 0.05  # between frames of a broadcast
DATA_S = 0.75  # T1: for the next data frame
CONTROL_S = 1.25  # T2 and T3: for data after a CTS, for an answer
HOLD_S = 0.55  # T4: after a CTS of no frames
OWN_S = 0.25  # for a frame of one's own to be on the bus


class Transfer:
    """One message; `put` sends a frame, `over` is called once, with 0 or an errno.

    `message` contains the addresses of the sender's frames, and at the sending end the data.
    """

    def __init__(
        self,
        timers: Timers,
        kind: Kind,
        message: Message,
        put: Callable[[Message], object],
        over: Callable[[int], object],
    ) -> None:
        self.kind = kind
        self.message = message
        self._timers = timers
        self._put = put
        self._over = over
        self._timeout: Cancellable | None = None
        self._ended = False

    def begin(self) -> None:
        raise NotImplementedError

    def fail(self, reason: Abort) -> None:
        """Abort the message, with an abort frame if it has a single destination."""
        if not self._ended:
            if not self.message.is_broadcast:
                self.control(bytes((ABORT, reason)))
            self.end(error_of(reason))

    def aborted(self, data: bytes) -> None:
        """The other side has ended it."""
        self.end(error_of(data[1]))

    def stop(self) -> None:
        """The socket or the bus is gone; nothing is reported."""
        self._ended = True
        self._await(None)

    def end(self, error: int) -> None:
        """End the message, with 0 for success or an errno."""
        if not self._ended:
            self.stop()
            self._over(error)

    def control(self, data: bytes) -> None:
        """Process a frame that controls the connection."""
        raise NotImplementedError

    def _control_frame(self, data: bytes) -> Message:
        """A control frame with up to five bytes of data, in the direction of the message."""
        whole = data.ljust(5, bytes((PAD,))) + self.message.pgn.to_bytes(3, "little")
        return replace(self.message, pgn=self.kind.control, data=whole)

    def _await(self, seconds: float | None) -> None:
        """Expect a frame within this time; None: expect none."""
        if self._timeout is not None:
            self._timeout.cancel()
        self._timeout = None
        if seconds is not None and not self._ended:
            self._timeout = self._timers.call_in(seconds, lambda: self.fail(Abort.TIMEOUT))


def reversed_message(message: Message) -> Message:
    """The same message from its destination to its source."""
    return replace(
        message,
        source=message.destination,
        destination=message.source,
        source_name=message.destination_name,
        destination_name=message.source_name,
    )
