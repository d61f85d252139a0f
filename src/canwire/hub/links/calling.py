"""How programs connect to a hub in another process on this system: over a Unix socket, or the loopback address."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.platform import PORTABLE

if TYPE_CHECKING or not PORTABLE:
    from canwire.hub.links.unix_socket.client import SocketLink as RemoteLink
    from canwire.hub.links.unix_socket.sockets import somebody_listens
else:
    from canwire.hub.links.loopback.client import LoopbackLink as RemoteLink
    from canwire.hub.links.loopback.sockets import somebody_listens

__all__ = ["RemoteLink", "somebody_listens"]
