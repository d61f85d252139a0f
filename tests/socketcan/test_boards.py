"""Boards that are plugged in while a server of either kind begins are interfaces like all others."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import Event, Hub, Unsupported, WantedMode
from canwire.socketcan.daemon.daemon import Daemon
from canwire.socketcan.interfaces import Interfaces
from canwire.socketcan.launch import shim
from canwire.socketcan.server import Server

pytest.importorskip("numpy")


def serve_programs(hub: Hub, home: Path) -> None:
    """As `canwire run` does, for a program that has ended already."""
    if sys.platform != "linux":
        pytest.skip("SocketCAN programs are Linux's")
    try:
        library = shim()
    except Unsupported as error:
        pytest.skip(str(error))
    server = Server(hub, str(home), library, {}, WantedMode(), 0, lambda said: None)
    reading, writing = os.pipe()
    os.close(writing)
    server.run((reading, os.dup(reading)))


def serve_connections(hub: Hub, home: Path) -> None:
    """As `canwire socketcand` does, until it is stopped in its first turn."""
    del home
    stop = Event()
    stop.set()
    Daemon(hub, ("127.0.0.1", 0), WantedMode(), 0, lambda said: None).run(stop)
    stop.close()


@pytest.mark.finding("socketcan 1")
@pytest.mark.parametrize("serve", [serve_programs, serve_connections])
def test_a_board_that_comes_while_a_server_begins(
    serve: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Interfaces] = []

    class Listed(Interfaces):
        def __init__(self, hub: Hub, *rest: Any) -> None:
            super().__init__(hub, *rest)
            made.append(self)
            hub.plug("usb-to-can-fd", "HW000077", buses=("can0", "can0"))

    monkeypatch.setattr("canwire.socketcan.server.Interfaces", Listed)
    monkeypatch.setattr("canwire.socketcan.daemon.daemon.Interfaces", Listed)
    with canwire.connect(time="virtual") as hub:
        serve(hub, tmp_path)
    (interfaces,) = made
    assert "HW000077_0" in {one.name for one in interfaces.by_index.values()}
