"""Messages that wait to be sent on a non-blocking socket: bytes, and descriptors with their first byte."""

from __future__ import annotations

import errno
import socket
from collections import deque

from canwire.errors import LimitReached
from canwire.hub.protocol.messages import LARGEST_REPLY
from canwire.platform import Descriptor, close_descriptors

_MOST_DESCRIPTORS = 256


class Outbox:
    """Messages for one client, in order. It owns descriptors from `put` on, and closes them once they are sent."""

    def __init__(self, connection: socket.socket, most_bytes: int = LARGEST_REPLY) -> None:
        self._connection = connection
        self._most_bytes = max(most_bytes, LARGEST_REPLY)
        self._waiting: deque[tuple[memoryview, tuple[Descriptor, ...], bytes]] = deque()
        self._bytes = 0
        self._descriptors = 0

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def put(self, message: bytes, descriptors: tuple[Descriptor, ...] = (), otherwise: bytes = b"") -> None:
        """Queue a message; `otherwise` is sent instead if the system cannot pass its descriptors on.

        Raises LimitReached if too much waits because this client does not read.
        """
        if (
            self._bytes + len(message) > self._most_bytes
            or self._descriptors + len(descriptors) > _MOST_DESCRIPTORS
        ):
            close_descriptors(*descriptors)
            raise LimitReached(
                f"{self._bytes} of {self._most_bytes} waiting_bytes wait for a client that does not read them; "
                f"set waiting_bytes under [limits] in the hub's canwire.toml"
            )
        self._waiting.append((memoryview(message), descriptors, otherwise))
        self._bytes += len(message)
        self._descriptors += len(descriptors)

    def flush(self) -> None:
        """Send as much as the socket accepts; raises OSError if the client is gone."""
        while self._waiting:
            message, descriptors, otherwise = self._waiting[0]
            try:
                sent = self._send(message, descriptors)
            except BlockingIOError:
                return
            except OSError as error:
                if error.errno != errno.ETOOMANYREFS:
                    raise
                self._sent(memoryview(otherwise), descriptors)
                self._bytes -= len(message) - len(otherwise)
                continue
            self._sent(message[sent:], descriptors)
            self._bytes -= sent

    def close(self) -> None:
        """Drop everything."""
        for _, descriptors, _ in self._waiting:
            close_descriptors(*descriptors)
        self._waiting.clear()

    def _send(self, message: memoryview, descriptors: tuple[Descriptor, ...]) -> int:
        if descriptors:
            return socket.send_fds(self._connection, [message], list(descriptors))
        return self._connection.send(message)

    def _sent(self, rest: memoryview, descriptors: tuple[Descriptor, ...]) -> None:
        """Descriptors went with the first byte, so the rest has none."""
        close_descriptors(*descriptors)
        self._descriptors -= len(descriptors)
        self._waiting.popleft()
        if rest:
            self._waiting.appendleft((rest, (), b""))
