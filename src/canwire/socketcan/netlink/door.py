"""Answers the netlink sockets of programs: each is a socket of NETLINK_USERSOCK, whose messages the shim sends here.

Requests about the server's interfaces are answered here, all others by the kernel.
"""

from __future__ import annotations

import errno
import os
import socket
import struct
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.socketcan.loop import READABLE, URGENT
from canwire.socketcan.netlink.changes import Changes
from canwire.socketcan.netlink.links import Links, Refused
from canwire.socketcan.netlink.messages import (
    ACKNOWLEDGE,
    DELETE_LINK,
    DONE,
    ERROR,
    GET_LINK,
    MULTI,
    NEW_LINK,
    SET_LINK,
    Request,
    answer_to,
    message,
    readdressed,
    requests_in,
)

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.setting import Setting

_USER_SOCKET, _ROUTE = 2, 0  # NETLINK_
_PASS_CREDENTIALS, _CREDENTIALS = 16, struct.Struct("<iII")
_LARGEST = 1 << 17


class NetlinkDoor:
    """The server's end of these sockets; raises OSError if the kernel does not support them."""

    def __init__(self, setting: Setting, links: Links) -> None:
        self._setting = setting
        self._links = links
        self._end = socket.socket(socket.AF_NETLINK, socket.SOCK_RAW | socket.SOCK_NONBLOCK, _USER_SOCKET)
        self._end.setsockopt(socket.SOL_SOCKET, _PASS_CREDENTIALS, 1)
        self._end.bind((0, 0))
        setting.table.set_netlink_port(self._end.getsockname()[0])
        setting.loop.watch(self._end.fileno(), READABLE | URGENT, self._arrived)
        self._changes = Changes(setting, links, self._end)

    def close(self) -> None:
        self._changes.close()
        self._setting.loop.forget(self._end.fileno())
        self._end.close()

    def _arrived(self, _: int) -> None:
        with suppress(BlockingIOError):
            data, ancillary, _, sender = self._end.recvmsg(_LARGEST, socket.CMSG_SPACE(_CREDENTIALS.size))
            users = [_CREDENTIALS.unpack(value)[1] for _, _, value in ancillary]
            if users and users[0] in (0, os.geteuid()):  # any process can send to such a socket
                self.answer(data, sender[0])

    def subscribe(self, port: int, group: int) -> None:
        """Report changes to the socket of this port; a group below 0 ends that. Raises OSError."""
        self._changes.subscribe(port, group)

    def answer(self, data: bytes, port: int) -> None:
        """Answer what a program has sent to the kernel from the socket of this port."""
        for request in requests_in(data):
            self._answer(request, port)

    def _answer(self, request: Request, port: int) -> None:
        interface = self._links.meant(request.body)
        try:
            if request.kind == GET_LINK and request.dumps:
                for one in self._links.all:  # each by itself: programs have room for a page
                    self._send(self._link(one, request, port, MULTI), port)
                self._ask_kernel(request, port)
            elif interface is None or request.kind not in (GET_LINK, SET_LINK, NEW_LINK, DELETE_LINK):
                self._ask_kernel(request, port)
            else:
                self._answer_about(interface, request, port)
        except Refused as refused:
            self._send(answer_to(request, port, refused.error, refused.why), port)
        except (CanwireError, OSError) as error:
            number = error.errno if isinstance(error, OSError) else errno.ENETDOWN
            self._send(answer_to(request, port, number or errno.EIO, str(error)), port)

    def _answer_about(self, interface: Interface, request: Request, port: int) -> None:
        if request.kind == DELETE_LINK:
            raise Refused(errno.EOPNOTSUPP, "`canwire unplug` takes boards away")
        if request.kind == GET_LINK:
            self._send(self._link(interface, request, port, 0), port)
        else:
            self._links.change(interface, request.body)
        if request.flags & ACKNOWLEDGE:
            self._send(answer_to(request, port, 0), port)

    def _link(self, interface: Interface, request: Request, port: int, flags: int) -> bytes:
        return message(NEW_LINK, flags, request.sequence, port, self._links.link(interface))

    def _ask_kernel(self, request: Request, port: int) -> None:
        """The kernel answers within the request; a dump continues as its parts are read."""
        with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW | socket.SOCK_NONBLOCK, _ROUTE) as kernel:
            kernel.send(request.whole)
            with suppress(BlockingIOError):
                while data := kernel.recv(_LARGEST):
                    self._send(readdressed(data, port), port)
                    if any(one.kind in (DONE, ERROR) for one in requests_in(data)):
                        return

    def _send(self, data: bytes, port: int) -> None:
        """Send an answer; a slow reader misses it, as from the kernel."""
        if data:
            with suppress(ConnectionRefusedError, BlockingIOError):
                self._end.sendto(data, (port, 0))
