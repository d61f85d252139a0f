"""CANDRV on real hubs: one in this process, one in a process of its own; and one in virtual time.

CID1: drives the INduCAN104 (SJA1000) of CONFIG or its PicoCOM1 (MCP2515). The first line of a USB-to-CAN on the same
bus is the rest of the world.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import pytest

import canwire
from canwire import candrv
from canwire.candrv import Handle
from canwire.candrv.registry.registry import RegistryStore
from tests.candrv.bench import BOARD, Bench, Peer
from tests.hubs import Connect, embedded, fixtures

CONFIG = """
[[bus]]
name = "can0"

[[board]]
kind = "inducan104"
serial = "HW000104"
buses = ["can0"]

[[board]]
kind = "picocom1"
serial = "HW000501"
buses = ["can0"]

[[board]]
kind = "usb-to-can"
serial = "HW000001"
buses = ["can0", "can0"]
"""
REGISTRY = '[candrv.CID1]\nBoard = "{}"\n'
BOARDS = ["inducan104", "picocom1"]

hub_process, hub_network, mortal_hub, connect = fixtures(CONFIG)


@pytest.fixture(autouse=True)
def registry(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> RegistryStore:
    """The registry of this test; what is set in it acts when the driver is loaded."""
    path = tmp_path_factory.mktemp("registry") / "canwire.toml"
    path.write_text(REGISTRY.format(BOARD))
    monkeypatch.setenv("CANWIRE_CONFIG", str(path))
    return RegistryStore(path)


@pytest.fixture
def hub(connect: Connect) -> Iterator[canwire.Hub]:
    """A hub on which the driver is not loaded; it is unloaded afterwards."""
    made = connect("first program")
    yield made
    forget(made)


def forget(hub: canwire.Hub) -> None:
    hub.set_note("candrv/CID1:", b"")
    hub.set_note("candrv/CID1:/virtualize", b"")
    with hub.open_control(hub.board(BOARD).id, 0) as control:
        control.reset()


@pytest.fixture
def handle(hub: canwire.Hub) -> Iterator[Handle]:
    """CID1: for reading and writing, every frame accepted."""
    with candrv.open(hub=hub) as made:
        made.accept_all()
        yield made


@pytest.fixture
def peer(connect: Connect) -> Iterator[Peer]:
    with contextlib.closing(Peer(connect("the rest"))) as made:
        yield made


@pytest.fixture(params=BOARDS)
def bench(request: pytest.FixtureRequest, registry: RegistryStore) -> Iterator[Bench]:
    """Virtual time, which stands still while nobody waits."""
    registry.set("CID1", "Board", request.param)
    with embedded(CONFIG, time="virtual") as engine, Bench(engine) as made:
        yield made
