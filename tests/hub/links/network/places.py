"""A hub that is offered on this machine's loopback, and a cable to it that can be cut."""

from __future__ import annotations

import contextlib
import selectors
import socket
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import Any, NamedTuple

from canwire import BitTiming, ChannelMode, Hub, HubChannel, LineMode
from canwire.hub.links.local import LocalLink
from canwire.hub.links.network.bridge import Bridge
from canwire.hub.links.network.client import NetworkLink
from canwire.hub.links.network.offered import Offered
from canwire.hub.links.network.session.settings import Patience
from canwire.hub.owner.engine import Engine
from tests.hubs import LONG_S, embedded, free_port

RATE = BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)
# a connection that is broken is given up soon; an answer may take long on a busy machine
QUICK = Patience(call_s=LONG_S, broken_s=0.8)
PATIENT = Patience(call_s=LONG_S, broken_s=LONG_S)
CONFIG = """
[[bus]]
name = "can0"

[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"

[[board]]
kind = "usb-to-can-fd"
serial = "HW000002"
"""


class Place(NamedTuple):
    """A hub in this process, and where it is offered."""

    engine: Engine
    port: int
    bridge: Bridge

    @property
    def address(self) -> str:
        return f"zenoh://tests/bench?via=tcp/127.0.0.1:{self.port}"

    def here(self, name: str = "here") -> Hub:
        """A program beside it."""
        return Hub(LocalLink(self.engine, name))


@contextmanager
def offered(**changes: Any) -> Iterator[Place]:
    """A hub and its offer; `changes` of Offered."""
    port = free_port()
    place: dict[str, Any] = {"realm": "tests", "name": "bench", "listen": (f"tcp/127.0.0.1:{port}",)}
    place["age_s"] = 0.0  # a busy machine takes its time
    with embedded(CONFIG) as engine:
        bridge = Bridge(lambda name: LocalLink(engine, name), Offered(**(place | changes)), lambda: None)
        with closing(bridge):
            yield Place(engine, port, bridge)


def elsewhere(address: str, patience: Patience = QUICK, name: str = "elsewhere") -> Hub:
    """A program on another machine."""
    return Hub(NetworkLink(address, name, patience=patience))


def running(hub: Hub) -> None:
    """Both boards' first lines are on the bus, whatever becomes of who started them."""
    for number in (0, 1):
        board = hub.boards()[number].id
        hub.keep_settings(board, 0)
        with hub.open_control(board, 0) as control:
            control.initialise(LineMode(timing=RATE))
            control.start()


def channel(hub: Hub, board: int, *, receive: int = 1024, transmit: int = 1024) -> HubChannel:
    """An active channel on a board's first line."""
    made = hub.open_channel(hub.boards()[board].id, 0)
    made.set_up(ChannelMode(receive=receive, transmit=transmit))
    made.activate()
    return made


class Cable:
    """Forwards TCP connections to a port, until it is cut: then nothing gets through, and nobody is told."""

    def __init__(self, port: int) -> None:
        self._target = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        self._whole = threading.Event()
        self._whole.set()
        self._ending = False
        self._open: list[socket.socket] = []
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def cut(self) -> None:
        self._whole.clear()

    def mend(self) -> None:
        self._whole.set()

    def hang_up(self) -> None:
        """Break every connection, and let new ones in."""
        for one in self._open:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        self._ending = True
        self.mend()
        self.hang_up()
        self._thread.join(LONG_S)
        for one in (*self._open, self._listener):
            one.close()

    def _run(self) -> None:
        with selectors.DefaultSelector() as selector:
            selector.register(self._listener, selectors.EVENT_READ, None)
            while not self._ending:
                for key, _ in selector.select(0.05):
                    self._whole.wait()
                    self._handle(selector, key)

    def _handle(self, selector: selectors.BaseSelector, key: selectors.SelectorKey) -> None:
        if key.data is None:
            near, _ = self._listener.accept()
            try:
                far = socket.create_connection(("127.0.0.1", self._target), LONG_S)
            except OSError:  # nobody listens there at the moment
                near.close()
                return
            self._open += (near, far)
            for one, other in ((near, far), (far, near)):
                selector.register(one, selectors.EVENT_READ, other)
            return
        one, other = key.fileobj, key.data
        assert isinstance(one, socket.socket)
        try:
            data = one.recv(1 << 16)
            if data:
                other.sendall(data)
                return
        except OSError:
            pass
        selector.unregister(one)
        for each in (one, other):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
