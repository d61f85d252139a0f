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
    """The OSError with which a call of the program fails."""
    return OSError(error, os.strerror(error))


class Ports:
    """One per interface, shared by all sockets of the programs that this server serves."""

    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._open: dict[int, Port] = {}
        self._heard_before = 0  # by ports that are gone
        self.matches = 0  # frames that sockets were given

    def port(self, index: int) -> Port:
        """The port of this interface; raises OSError: ENODEV if it does not exist, ENETDOWN if its line fails."""
        found = self._open.get(index)
        if found is not None:
            if found.lost:  # its hub is away
                raise refuse(errno.ENETDOWN)
            return found
        interface = self._setting.interfaces.by_index.get(index)
        if interface is None:
            raise refuse(errno.ENODEV)
        if not interface.flags & UP:  # taken down by netlink
            raise refuse(errno.ENETDOWN)
        return self._opened(interface)

    def of_all(self) -> list[Port]:
        """The ports from which a socket bound to all interfaces receives; raises OSError if none can be used."""
        found: list[Port] = []
        failure: OSError | None = None
        for interface in self._setting.interfaces.of_all():
            try:
                found.append(self.port(interface.index))
            except OSError as error:
                failure = error
        if not found and failure is not None and not self._setting.hub.lost:
            raise failure
        return found

    def is_down(self, index: int) -> bool:
        """True if it is down without a port that hears when it is up: a socket that binds to it waits for that."""
        interface, port = self._setting.interfaces.by_index.get(index), self._open.get(index)
        return (port is None or port.lost) and interface is not None and not interface.flags & UP

    def in_use(self) -> list[Port]:
        return list(self._open.values())

    def forget_stamper(self, slot: int) -> None:
        """A socket with time stamps of its sent frames was closed."""
        for port in self._open.values():
            port.stampers.pop(slot, None)

    def known(self, index: int) -> Port | None:
        """The port of this interface, if it is already open."""
        return self._open.get(index)

    def pending(self) -> int:
        """The number of frames on their way to a bus."""
        return sum(port.pending for port in list(self._open.values()))  # one may turn out to be lost

    def heard(self) -> int:
        """The number of frames received from lines since the start."""
        return self._heard_before + sum(port.heard for port in self._open.values())

    def progress(self) -> int:
        """A number that grows with each frame sent."""
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
            away = self._setting.comes_back and isinstance(error, HubLost)
            gone = isinstance(error, NoSuchBoard | Unplugged | HubLost) and not away
            raise refuse(errno.ENODEV if gone else errno.ENETDOWN) from error
        return port

    def _lost(self, port: Port) -> None:
        self._open.pop(port.interface.index, None)
        self._heard_before += port.heard
        self._setting.interfaces.remove(port.interface)
