"""A link over a Unix socket: the hub's descriptors arrive with its replies."""

from __future__ import annotations

import array
import socket

from canwire.hub.links.stream.client import StreamLink
from canwire.hub.links.unix_socket.sockets import dial
from canwire.platform import Descriptor, EventDescriptor

_RECEIVED_AT_ONCE = 1 << 16
_MOST_DESCRIPTORS = 64  # more than one message ever has
_CLOSE_ON_EXEC = getattr(socket, "MSG_CMSG_CLOEXEC", 0)


class SocketLink(StreamLink):
    """A link to the hub at the path `address`."""

    _dial = staticmethod(dial)

    def _receive_some(self) -> bytes:
        data, ancillary, flags, _ = self._socket.recvmsg(
            _RECEIVED_AT_ONCE,
            socket.CMSG_SPACE(_MOST_DESCRIPTORS * array.array("i").itemsize),
            _CLOSE_ON_EXEC,
        )
        for level, kind, content in ancillary:
            if level == socket.SOL_SOCKET and kind == socket.SCM_RIGHTS:
                descriptors = array.array("i")
                descriptors.frombytes(content[: len(content) - len(content) % descriptors.itemsize])
                self._descriptors.extend(descriptors)
        self._truncated |= bool(flags & socket.MSG_CTRUNC)
        return data

    def _doorbell_of(self, descriptors: tuple[Descriptor, ...]) -> EventDescriptor:
        return EventDescriptor.adopt(*descriptors)
