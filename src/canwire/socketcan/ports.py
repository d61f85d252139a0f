"""The interfaces in use: opened when a socket first needs one, open until the end."""

from __future__ import annotations

import errno
import os
from typing import TYPE_CHECKING

from canwire import CanwireError, HubLost, NoSuchBoard, Unplugged
from canwire.socketcan.port import Port
from canwire.socketcan.table import UP

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.setting import Setting


def refuse(error: int) -> OSError:
    """What a call of the program fails with."""
    return OSError(error, os.strerror(error))


class Ports:
    """One per interface, shared by all sockets of the programs that this server serves."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._open: dict[int, Port] = {}
        self._heard_before = 0  # by ports that are gone
        self.matches = 0  # frames that sockets were given

    def port(self, index: int) -> Port:
        """Of this interface; raises OSError: ENODEV if there is none, ENETDOWN where its line cannot be had."""
        found = self._open.get(index)
        if found is not None:
            return found
        interface = self._setting.interfaces.by_index.get(index)
        if interface is None:
            raise refuse(errno.ENODEV)
        if not interface.flags & UP:  # taken down by netlink
            raise refuse(errno.ENETDOWN)
        return self._opened(interface)

    def of_all(self) -> list[Port]:
        """Those that a socket bound to all interfaces hears; raises OSError if none of them can be had."""
        found: list[Port] = []
        failure: OSError | None = None
        for interface in self._setting.interfaces.of_all():
            try:
                found.append(self.port(interface.index))
            except OSError as error:
                failure = error
        if not found and failure is not None:
            raise failure
        return found

    def is_down(self, index: int) -> bool:
        """It was taken down before any socket used it: a socket that binds to it waits until it is up."""
        interface = self._setting.interfaces.by_index.get(index)
        return index not in self._open and interface is not None and not interface.flags & UP

    def in_use(self) -> list[Port]:
        return list(self._open.values())

    def forget_stamper(self, slot: int) -> None:
        """Who wanted to know when its frames were on the bus is gone."""
        for port in self._open.values():
            port.stampers.pop(slot, None)

    def known(self, index: int) -> Port | None:
        """One that is open already."""
        return self._open.get(index)

    def pending(self) -> int:
        """Frames on their way to a bus."""
        return sum(port.pending for port in list(self._open.values()))  # one may turn out to be lost

    def heard(self) -> int:
        """Frames that have come from lines, since the beginning."""
        return self._heard_before + sum(port.heard for port in self._open.values())

    def progress(self) -> int:
        """Grows with each frame that goes out."""
        return sum(port.sent for port in self._open.values())

    def close(self) -> None:
        for port in self._open.values():
            port.close()
        self._open.clear()

    def _opened(self, interface: Interface) -> Port:
        try:
            port = self._open[interface.index] = Port(self._setting, interface, self._lost)
        except CanwireError as error:
            self._setting.say(f"{interface.name}: {error}")
            gone = isinstance(error, NoSuchBoard | Unplugged | HubLost)
            raise refuse(errno.ENODEV if gone else errno.ENETDOWN) from error
        return port

    def _lost(self, port: Port) -> None:
        self._open.pop(port.interface.index, None)
        self._heard_before += port.heard
        self._setting.interfaces.remove(port.interface)
