"""The hub's side of connections on this system. The programs' side is calling.py, which loads no boards."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.platform import PORTABLE

if TYPE_CHECKING or not PORTABLE:
    from canwire.hub.links.unix_socket.server import Server
else:
    from canwire.hub.links.loopback.server import LoopbackServer as Server

__all__ = ["Server"]
