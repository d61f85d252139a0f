"""What waits to be sent on a socket that must not block: bytes, and descriptors beside their first byte."""

from __future__ import annotations

import socket
from collections import deque

from canwire.errors import HubError
from canwire.hub.protocol.messages import LARGEST_REPLY
from canwire.platform import close_descriptors

_MOST_DESCRIPTORS = 256


class Outbox:
    """Messages for one client, in order. Descriptors are its own from `put` on, and closed once they are sent."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._waiting: deque[tuple[memoryview, tuple[int, ...]]] = deque()
        self._bytes = 0
        self._descriptors = 0

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def put(self, message: bytes, descriptors: tuple[int, ...] = ()) -> None:
        """Queue a message; raises HubError once too much waits: this client does not read."""
        if (
            self._bytes + len(message) > LARGEST_REPLY
            or self._descriptors + len(descriptors) > _MOST_DESCRIPTORS
        ):
            close_descriptors(*descriptors)
            raise HubError(f"{self._bytes} bytes wait for a client that does not read them")
        self._waiting.append((memoryview(message), descriptors))
        self._bytes += len(message)
        self._descriptors += len(descriptors)

    def flush(self) -> None:
        """Send what the socket takes; raises OSError if the client is gone."""
        while self._waiting:
            message, descriptors = self._waiting[0]
            try:
                if descriptors:
                    sent = socket.send_fds(self._connection, [message], list(descriptors))
                else:
                    sent = self._connection.send(message)
            except BlockingIOError:
                return
            self._sent(message[sent:], descriptors)
            self._bytes -= sent

    def close(self) -> None:
        """Drop everything."""
        for _, descriptors in self._waiting:
            close_descriptors(*descriptors)
        self._waiting.clear()

    def _sent(self, rest: memoryview, descriptors: tuple[int, ...]) -> None:
        """Descriptors went with the first byte, so the rest has none."""
        close_descriptors(*descriptors)
        self._descriptors -= len(descriptors)
        self._waiting.popleft()
        if rest:
            self._waiting.appendleft((rest, ()))
