"""Boards that are plugged in while a server of either kind begins are interfaces like all others."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import Event, Hub, WantedMode
from canwire.socketcan.daemon.daemon import Daemon
from canwire.socketcan.interfaces import Interfaces
from canwire.socketcan.launch import shim
from canwire.socketcan.server import Server
from canwire.socketcan.table import Table
from tests.missing import supported
from tests.socketcan.bench import Bench

pytest.importorskip("numpy")


def library() -> str:
    """The shim."""
    if sys.platform != "linux":
        pytest.skip("SocketCAN programs are Linux's")
    return supported(shim)


def serve_programs(hub: Hub, home: Path) -> None:
    """As `canwire run` does, for a program that has ended already."""
    server = Server(hub, str(home), library(), {}, WantedMode(), 0, lambda said: None)
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


@pytest.mark.finding("socketcan 9")
def test_boards_that_come_and_go_without_end(tmp_path: Path) -> None:
    """There were 64 places, none of which was used again: after 26 boards a running server saw no new one."""
    with canwire.connect(time="virtual") as hub:
        table = Table(str(tmp_path / "table"), b"test")
        interfaces = Interfaces(hub, table, {})
        indexes: set[int] = set()
        for _ in range(40):
            hub.plug("usb-to-can-fd", "HW000077", buses=("can0", "can0"))
            assert interfaces.refresh() == []
            indexes |= {one.index for one in interfaces.by_index.values() if "HW000077" in one.name}
            hub.unplug("HW000077")
            for gone in interfaces.refresh():
                interfaces.remove(gone)
        assert len(indexes) == 80  # an index is nobody else's ever
        assert interfaces.unplaced == set()
        table.close()


@pytest.mark.parametrize("target", ["usb-to-can-fd:1", "HW000077:0", "can0"])
def test_an_interface_of_a_mapping_stays_as_long_as_its_line(tmp_path: Path, target: str) -> None:
    """A mapping to a kind of board was taken for gone when any other board came."""
    config = tmp_path / "canwire.toml"
    config.write_text('[[bus]]\nname = "can0"\n[[bus]]\nname = "can1"\n')
    with canwire.connect(time="virtual", config=config) as hub:
        hub.plug("usb-to-can-fd", "HW000077", buses=("can0", "can0"))
        table = Table(str(tmp_path / "table"), b"test")
        interfaces = Interfaces(hub, table, {"can7": target})
        hub.plug("inducan104", "HW000078", buses=("can1",))
        assert interfaces.refresh() == []
        hub.unplug("HW000077")
        assert "can7" in {one.name for one in interfaces.refresh()}
        table.close()


@pytest.mark.finding("socketcan 9", "faults-2 6")
def test_a_program_sees_more_boards_than_anybody_has(bench: Bench) -> None:
    for number in range(40):
        bench.hub.plug("usb-to-can-fd", f"HW0005{number:02}", buses=("can0", "can0"))
    names = "import socket; print(*(socket.if_nametoindex(f'HW0005{n:02}_1') for n in range(40)))"
    found = bench.run(sys.executable, "-c", names).split()
    assert len(set(found)) == 40


@pytest.mark.finding("socketcan 9")
def test_a_table_that_is_full_names_who_has_no_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An IndexError was swallowed."""
    monkeypatch.setattr("canwire.socketcan.table.MOST_INTERFACES", 3)
    monkeypatch.setattr("canwire.socketcan.boards.boards.MOST_INTERFACES", 3)
    said: list[str] = []
    with canwire.connect(time="virtual") as hub:
        server = Server(hub, str(tmp_path), library(), {}, WantedMode(), 0, said.append)
        server.close()
    assert len(said) == 1
    assert said[0].startswith("3 interfaces are all there can be: HW000002_0 and 3 more")
