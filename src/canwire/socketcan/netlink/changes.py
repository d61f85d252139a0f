"""Messages to rtnetlink's groups: changes of the server's interfaces, and those that the kernel reports.

Each subscriber gets a separate message: groups of NETLINK_USERSOCK are an administrator's.
"""

from __future__ import annotations

import errno
import socket
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.socketcan.loop import READABLE
from canwire.socketcan.netlink.messages import DELETE_LINK, NEW_LINK, message
from canwire.socketcan.ports import refuse
from canwire.socketcan.table import GONE

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.netlink.links import Links
    from canwire.socketcan.setting import Setting

_SOL_NETLINK, _ADD, _DROP = 270, 1, 2
LINK_GROUP = 1  # RTNLGRP_LINK
_LARGEST = 1 << 17
_MOST_SUBSCRIBERS = 256


class Changes:
    """Reports changes through `end`, the server's socket."""

    def __init__(self, setting: Setting, links: Links, end: socket.socket) -> None:
        self._setting = setting
        self._links = links
        self._end = end
        self._groups: dict[int, set[int]] = {}  # of subscribers, by port
        self._kernel: dict[int, socket.socket] = {}  # what the kernel tells each of them comes by these
        self._changed: dict[int, Interface] = {}
        setting.interfaces.changed = self._note

    def close(self) -> None:
        for port in list(self._groups):
            self._end_subscription(port)

    def subscribe(self, port: int, group: int) -> None:
        """Send the messages of this group to this port; a group below 0 ends that. Raises OSError."""
        if not 0 < abs(group) < 64:
            raise refuse(errno.EINVAL)
        groups = self._groups.get(port)
        if groups is None:
            self._begin(port)
            groups = self._groups[port]
        kernel = self._kernel[port]
        kernel.setsockopt(_SOL_NETLINK, _ADD if group > 0 else _DROP, abs(group))
        groups.add(group) if group > 0 else groups.discard(-group)

    def _begin(self, port: int) -> None:
        if len(self._groups) >= _MOST_SUBSCRIBERS:
            raise refuse(errno.ENOBUFS)
        kernel = socket.socket(socket.AF_NETLINK, socket.SOCK_RAW | socket.SOCK_NONBLOCK, 0)
        self._groups[port], self._kernel[port] = set(), kernel
        self._setting.loop.watch(kernel.fileno(), READABLE, lambda _: self._of_kernel(port))

    def _end_subscription(self, port: int) -> None:
        del self._groups[port]
        kernel = self._kernel.pop(port)
        self._setting.loop.forget(kernel.fileno())
        kernel.close()

    def _of_kernel(self, port: int) -> None:
        with suppress(OSError):  # too much came: ENOBUFS, as the program would have had it
            self._tell(port, self._kernel[port].recv(_LARGEST))

    def _note(self, interface: Interface) -> None:
        """Report a change in the loop's next turn, once for all changes until then."""
        if not self._groups:
            return
        if not self._changed:
            self._setting.loop.soon(self._tell_all)
        self._changed[interface.index] = interface

    def _tell_all(self) -> None:
        changed, self._changed = self._changed, {}
        for interface in changed.values():
            try:
                if interface.flags & GONE:
                    told = message(DELETE_LINK, 0, 0, 0, self._links.gone(interface))
                else:
                    told = message(NEW_LINK, 0, 0, 0, self._links.link(interface))
            except CanwireError:  # its board is being removed, which is reported next
                continue
            for port in [port for port, groups in self._groups.items() if LINK_GROUP in groups]:
                self._tell(port, told)

    def _tell(self, port: int, data: bytes) -> None:
        """Send a message; a slow reader misses it, as from the kernel, and a closed port is removed."""
        try:
            self._end.sendto(data, (port, 0))
        except BlockingIOError:
            pass
        except ConnectionRefusedError:
            self._end_subscription(port)
