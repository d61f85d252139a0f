"""CANDRV on real hubs: one in this process, one in a process of its own; and one in virtual time.

CID1: drives the INduCAN104 (SJA1000) of CONFIG or its PicoCOM1 (MCP2515). The first line of a USB-to-CAN on the same
bus is the rest of the world.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import BitTiming, ChannelMode, Frame, LineMode, candrv
from canwire.boards.config.configuration import Config
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults import Faults
from canwire.candrv import Handle
from canwire.candrv.registry.registry import RegistryStore
from canwire.hub.handles.hub import Hub
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World

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
BOARD, PEER_BOARD = "HW000104", "HW000001"
BOARDS = ["inducan104", "picocom1"]
RATE = 1_000_000  # the registry's default
LONG = 30  # seconds after which something that should happen never will
READ, WRITE = 0x8000_0000, 0x4000_0000

Connect = Callable[[str], canwire.Hub]


@pytest.fixture(autouse=True)
def registry(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> RegistryStore:
    """The registry of this test; what is set in it acts when the driver is loaded."""
    path = tmp_path_factory.mktemp("registry") / "canwire.toml"
    path.write_text(REGISTRY.format(BOARD))
    monkeypatch.setenv("CANWIRE_CONFIG", str(path))
    return RegistryStore(path)


@contextlib.contextmanager
def serving(home: Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A hub in a process of its own, and its socket."""
    config, address = home / "world.toml", str(home / "hub.sock")
    config.write_text(CONFIG)
    command = [sys.executable, "-m", "canwire", "serve", "--time", "fast", "--socket", address]
    process = subprocess.Popen([*command, "--config", str(config)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        assert "canwire hub on" in process.stdout.readline()
        yield address, process
    finally:
        process.terminate()
        process.wait(LONG)
        process.stdout.close()


@pytest.fixture(scope="session")
def hub_process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Socket of a hub that all tests of this run share."""
    with serving(tmp_path_factory.mktemp("hub")) as (address, _):
        yield address


@pytest.fixture
def mortal_hub(tmp_path: Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A hub for this test alone, with its process."""
    with serving(tmp_path) as made:
        yield made


@pytest.fixture(params=["embedded", "process"])
def connect(request: pytest.FixtureRequest) -> Iterator[Connect]:
    """Makes connections to one hub; each stands for a program of its own."""
    with contextlib.ExitStack() as closing:
        if request.param == "process":
            address = request.getfixturevalue("hub_process")

            def link(name: str) -> canwire.Hub:
                return closing.enter_context(canwire.connect(address, name=name))
        else:
            engine = Engine(World(Config.parse(CONFIG)), "fast")
            closing.callback(engine.close)

            def link(name: str) -> canwire.Hub:
                return closing.enter_context(Hub(LocalLink(engine, name)))

        yield link


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
    engine = Engine(World(Config.parse(CONFIG), virtual=True), "virtual")
    with contextlib.closing(engine), Bench(engine) as made:
        yield made


class Peer:
    """Another machine's line, started or (as long as `off`) not there at all."""

    def __init__(self, hub: canwire.Hub, *, off: bool = False, rate: int = RATE) -> None:
        board = hub.board(PEER_BOARD)
        self._control = hub.open_control(board.id, 0)
        self._control.initialise(LineMode(BitTiming.for_bit_rate(rate, clock_hz=8_000_000)))
        self._channel = hub.open_channel(board.id, 0)
        self._channel.set_up(ChannelMode(4000, 4000, filter_size=0))
        self._channel.activate()
        if not off:
            self._control.start()

    def start(self) -> None:
        self._control.start()

    def stop(self) -> None:
        self._control.stop()

    def send(self, *frames: Frame) -> None:
        for frame in frames:
            self._channel.send(frame, timeout=LONG)

    def receive(self, timeout: float | None = LONG) -> Frame | None:
        return self._channel.receive(timeout)

    def received(self, count: int) -> list[Frame]:
        frames = [self.receive() for _ in range(count)]
        assert None not in frames, f"{frames}: not {count}"
        return [frame for frame in frames if frame is not None]

    def close(self) -> None:
        self._channel.close()
        self._control.close()


class Bench:
    """A hub in virtual time with several programs, a peer, and what only a bench can do."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.hub = self.program("program")
        bus = engine.world.buses["can0"]
        assert isinstance(bus, CanBus)
        self.faults = Faults(bus, 1)
        self._closing = contextlib.ExitStack()
        self._peer: Peer | None = None

    def program(self, name: str) -> canwire.Hub:
        return Hub(LocalLink(self.engine, name))

    def open(self, *, accept: bool = True, hub: canwire.Hub | None = None, **how: Any) -> Handle:
        """A handle on CID1:; with `accept` every frame passes its filter."""
        made = candrv.open(hub=hub or self.hub, **how)
        self._closing.callback(made.close)
        if accept and made.readable:
            made.accept_all()
        return made

    @property
    def peer(self) -> Peer:
        if self._peer is None:
            self._peer = Peer(self.program("the rest"))
        return self._peer

    def absent_peer(self) -> Peer:
        self._peer = Peer(self.program("the rest"), off=True)
        return self._peer

    @property
    def board(self) -> int:
        """That of CID1:."""
        return self.hub.board(str(RegistryStore(os.environ["CANWIRE_CONFIG"]).get("CID1", "Board"))).id

    def run(self, seconds: float) -> None:
        self.hub.run_for(seconds)

    def registers(self) -> dict[str, int]:
        found = self.hub.registers(self.board, 0)
        return {register.name: register.value for register in found}

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *error: object) -> None:
        self._closing.close()
        self.hub.close()
