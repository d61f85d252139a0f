"""The server: connections, interfaces, and a beacon that clients can find."""

from __future__ import annotations

import errno
import ipaddress
import itertools
import os
import socket
import tempfile
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

from canwire import BadValue, Event, HubError
from canwire.socketcan.daemon.client import Client
from canwire.socketcan.daemon.configuring import configure, start
from canwire.socketcan.daemon.listening import Address, forget, listener
from canwire.socketcan.daemon.waiting import usual
from canwire.socketcan.interfaces import Interfaces
from canwire.socketcan.loop import READABLE, Loop
from canwire.socketcan.netlink.links import Links
from canwire.socketcan.ports import Ports, refuse
from canwire.socketcan.setting import Setting
from canwire.socketcan.table import Table

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub, WantedMode
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port

_BEACON_PORT = 42000
_BEACON_S = 2.0
_MOST_CLIENTS = 256
_FIRST_SLOT = 1 << 16  # numbers of clients, apart from those of the table


def check_beacon(listens: Address, beacon: str) -> None:
    """Raises BadValue if the beacon would name a loopback address or a Unix socket to other machines."""
    if isinstance(listens, str):
        raise BadValue(f"beacon to {beacon}: other machines cannot reach {listens}; give --listen HOST:PORT")
    if _is_loopback(listens[0]) and not _is_loopback(beacon):
        raise BadValue(
            f"beacon to {beacon}: it would name {listens[0]}, by which other machines cannot reach this one; give "
            "--listen with an address that they can reach"
        )


def announced(listens: str, beacon: str) -> str:
    """The address that a beacon names: if the server listens on all, this machine's address on the way to `beacon`."""
    if not ipaddress.ip_address(listens).is_unspecified:
        return listens
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as way:
        way.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        way.connect((beacon, _BEACON_PORT))  # sends nothing
        return str(way.getsockname()[0])


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


class Daemon:
    """Serves the hub's buses until `stop` is signalled or the hub is gone. `say` shows one line to the user."""

    def __init__(
        self,
        hub: Hub,
        address: Address,
        wanted: WantedMode,
        epoch_ns: int,
        say: Callable[[str], object],
        *,
        mappings: dict[str, str] | None = None,
        beacon: str = "",
        greeting_s: float = 30,
    ) -> None:
        """`beacon`: an address to which it announces itself every 2 s, "" for none. A client that has opened no bus
        after `greeting_s` seconds is closed, and earlier if other clients need its place.

        Raises OSError, HubError, and BadValue for a beacon that names an unreachable port.
        """
        if beacon:
            check_beacon(address, beacon)
        self._directory = tempfile.TemporaryDirectory(prefix="canwire-socketcand-")
        self._listener = listener(address)
        self.address: Address = address if isinstance(address, str) else self._listener.getsockname()[:2]
        self._loop = Loop(usual())
        self._boards = Event()
        hub.watch(self._boards)  # before the list of boards is read: later boards are reported
        table = Table(os.path.join(self._directory.name, "table"), b"socketcand")
        interfaces = Interfaces(hub, table, mappings or {})
        self._setting = Setting(hub, self._loop, table, interfaces, wanted, epoch_ns, say)
        self._ports = Ports(self._setting)
        self._links = Links(self._setting, self._ports)
        self._clients: dict[Client, None] = {}  # the oldest first
        self._greeting_s = greeting_s
        self._configured: set[str] = set()  # interfaces that are down since a command has set them up
        self._slots = itertools.count(_FIRST_SLOT)
        self._loop.watch(self._boards.fileno(), READABLE, self._boards_changed)
        self._loop.watch(self._listener.fileno(), READABLE, self._accept)
        self._beacon = beacon
        self._announcer = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        if beacon and not isinstance(self.address, str):
            self._announcer.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            self._announced = f"can://{announced(self.address[0], beacon)}:{self.address[1]}"
            self._announce()

    def run(self, stop: Event) -> None:
        """Serve until `stop` is signalled; then the clients' connections end."""
        self._loop.watch(stop.fileno(), READABLE, lambda _: self._loop.stop())
        try:
            self._loop.run()
        finally:
            self.close()

    def close(self) -> None:
        for loss in self._setting.interfaces.losses():
            self._setting.say(loss)
        for client in list(self._clients):
            client.close()
        self._ports.close()
        self._listener.close()
        forget(self.address)
        self._announcer.close()
        self._boards.close()
        self._setting.table.close()
        self._loop.close()
        self._directory.cleanup()

    def _accept(self, _: int) -> None:
        try:
            end, peer = self._listener.accept()
        except (
            OSError
        ) as error:  # it went away meanwhile, or there are no descriptors left: one connection less
            if error.errno not in (errno.EMFILE, errno.ENFILE) or not self._make_room():
                self._setting.say(f"a connection was refused: {error.strerror}")
            return
        if len(self._clients) >= _MOST_CLIENTS and not self._make_room():
            self._setting.say(
                f"{peer[0] if peer else 'a program'}: refused, there are {_MOST_CLIENTS} clients"
            )
            end.close()
            return
        if not isinstance(self.address, str):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        slot = next(self._slots)
        client = Client(self._setting, self._find, self._configure, slot, end, self._gone, self._greeting_s)
        self._clients[client] = None

    def _make_room(self) -> bool:
        """Close the client that has waited longest without opening a bus; False if each has one."""
        silent = next((client for client in self._clients if client.silent), None)
        if silent is not None:
            silent.end_with("too many clients, and no bus opened here")
        return silent is not None

    def _gone(self, client: Client) -> None:
        self._clients.pop(client, None)
        if client.lost:
            self._setting.say(
                f"a client has left; {client.lost} frames were lost because it did not read them"
            )

    def _find(self, name: str) -> Port:
        interface = self._interface(name)
        if name in self._configured:
            start(self._links, interface)
            self._configured.remove(name)
        return self._ports.port(interface.index)

    def _configure(self, words: list[str]) -> None:
        configure(self._links, self._interface(words[0]), words)
        self._configured.add(words[0])

    def _interface(self, name: str) -> Interface:
        for interface in self._setting.interfaces.by_index.values():
            if interface.name == name:
                return interface
        raise refuse(errno.ENODEV)

    def _boards_changed(self, _: int) -> None:
        self._boards.wait(0)
        if self._setting.hub.lost:
            self._loop.stop()
            return
        try:
            gone = self._setting.interfaces.refresh()
        except HubError:
            self._loop.stop()
            return
        for interface in gone:
            if self._ports.known(interface.index) is None:
                self._setting.interfaces.remove(interface)

    def _announce(self) -> None:
        """Send one datagram of the beacon, in the form of doc/protocol.md."""
        names = [one.name for one in self._setting.interfaces.of_all()]
        buses = "".join(f"<Bus name={quoteattr(name)}/>" for name in names)
        host = socket.gethostname()
        text = (
            f'<CANBeacon name={quoteattr(host)} type="SocketCAN" description="canwire">'
            f"<URL>{self._announced}</URL>{buses}</CANBeacon>"
        )
        try:
            self._announcer.sendto(text.encode(), (self._beacon, _BEACON_PORT))
        except OSError as error:
            self._setting.say(f"beacon to {self._beacon}: {error.strerror}")
        self._loop.call_in(_BEACON_S, self._announce)
