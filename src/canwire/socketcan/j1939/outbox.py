"""Sends the messages of one socket, one after the other."""

from __future__ import annotations

import errno
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from canwire.socketcan.j1939.addresses import Cancellable
from canwire.socketcan.j1939.message import LARGEST_SINGLE, Message
from canwire.socketcan.j1939.reports import Report, What
from canwire.socketcan.j1939.sending import Sending
from canwire.socketcan.ports import refuse

if TYPE_CHECKING:
    from canwire.socketcan.j1939.endpoint import Endpoint
    from canwire.socketcan.j1939.network import Network

_ECHO_S = 10.0  # for a single frame to be on the bus
_REST_S = 0.01  # after a message that failed, for the receiver to recover


@dataclass
class _Single:
    """A message of one frame that waits to be on the bus."""

    number: int
    message: Message
    timer: Cancellable


class Outbox:
    """`over` is called after each message, with 0 or an errno."""

    def __init__(self, network: Network, endpoint: Endpoint, over: Callable[[int], object]) -> None:
        self._network = network
        self._endpoint = endpoint
        self._over = over
        self._queue: deque[tuple[int, Message]] = deque()
        self._active: Sending | None = None
        self._rests: Cancellable | None = None
        self._singles: deque[_Single] = deque()
        self._count = 0

    @property
    def pending(self) -> int:
        """The number of messages that are not finished."""
        return len(self._queue) + len(self._singles) + (self._active is not None)

    def send(self, message: Message) -> None:
        """Send or queue a message; raises OSError, with which the program's call fails."""
        source, destination = self._network.addresses.resolved(message)
        message = replace(message, source=source, destination=destination)
        idle = not self._queue and self._active is None and self._rests is None
        if idle and len(message.data) > LARGEST_SINGLE and self._network.is_busy(message):
            raise refuse(errno.EBUSY)
        self._queue.append((self._count, message))
        self._count += 1
        if idle:
            self._next()

    def confirm(self, message: Message) -> None:
        """A single frame of this socket was on the bus."""
        for single in self._singles:
            sent = single.message
            if (sent.identifier, sent.data) == (message.identifier, message.data):
                self._singles.remove(single)
                single.timer.cancel()
                self._tell(What.ACKNOWLEDGED, single.number, sent, len(sent.data))
                self._over(0)
                return

    def stop(self, error: int) -> None:
        """The bus is gone, or no program has the socket any more."""
        for single in self._singles:
            single.timer.cancel()
            self._tell(What.ABORTED, single.number, single.message, 0, error)
        for number, message in self._queue:
            self._tell(What.ABORTED, number, message, 0, error)
        self._singles.clear()
        self._queue.clear()
        if self._rests is not None:
            self._rests.cancel()
            self._rests = None
        if self._active is not None:
            self._active.end(error)

    def _next(self) -> None:
        self._rests = None
        while self._queue and self._active is None:
            number, message = self._queue.popleft()
            if len(message.data) <= LARGEST_SINGLE:
                self._send_single(number, message)
            elif self._network.is_busy(message):
                self._tell(What.ABORTED, number, message, 0, errno.EBUSY)
                self._over(errno.EBUSY)
            else:
                self._begin(number, message)

    def _send_single(self, number: int, message: Message) -> None:
        def lost() -> None:
            self._singles.remove(single)
            self._tell(What.ABORTED, number, message, 0, errno.ETIME)
            self._over(0)  # of which only the error queue tells

        single = _Single(number, message, self._network.timers.call_in(_ECHO_S, lost))
        self._singles.append(single)
        self._network.put(message, self._endpoint)
        self._tell(What.SCHEDULED, number, message, len(message.data))

    def _begin(self, number: int, message: Message) -> None:
        def scheduled() -> None:
            self._tell(What.SCHEDULED, number, message, sending.acknowledged_size)

        def over(error: int) -> None:
            self._active = None
            self._network.forget(sending)
            what = What.ABORTED if error else What.ACKNOWLEDGED
            self._tell(what, number, message, sending.acknowledged_size, error or errno.ENOMSG)
            self._over(error)
            if error:
                self._rests = self._network.timers.call_in(_REST_S, self._next)
            else:
                self._next()

        def put(frame: Message) -> None:
            self._network.put(frame, self._endpoint)

        sending = self._active = Sending(self._network.timers, message, put, over, scheduled)
        self._network.add(sending)
        sending.begin()

    def _tell(self, what: What, number: int, message: Message, done: int, error: int = errno.ENOMSG) -> None:
        self._endpoint.report(Report(what, number, message, len(message.data), done, error))
