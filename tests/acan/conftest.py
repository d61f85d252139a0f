"""ACAN on real hubs: one in this process, one in a process of its own; and one in virtual time.

The INduCAN104 of CONFIG and the first line of a USB-to-CAN FD share a bus; that line is the rest of the world.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import canwire
from canwire import BitTiming, ChannelMode, EventKind, Frame, LineMode
from canwire.acan.driver import Driver, open_driver
from canwire.acan.hard_config import HardConfig
from canwire.acan.task_block import TaskBlock
from canwire.boards.config.configuration import Config
from canwire.bus.can.faults import Faults
from canwire.hub.handles.hub import Hub
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World

CONFIG = """
[[bus]]
name = "can0"

[[bus]]
name = "lin0"
type = "lin"

[[board]]
kind = "inducan104"
serial = "HW000104"
base = 0x280
irq = 5
buses = ["can0"]

[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"
buses = ["can0", "can0", "lin0"]
"""
BOARD, PEER_BOARD = "HW000104", "HW000001"
RATE = BitTiming.from_btr(0xC1, 0x49)  # what HardConfig() makes: 250 kbit/s
LONG = 30  # seconds after which something that should happen never will

Connect = Callable[[str], canwire.Hub]


@contextlib.contextmanager
def serving(home: Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """A hub in a process of its own, and its socket."""
    config, address = home / "canwire.toml", str(home / "hub.sock")
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
    """A hub whose INduCAN104 nobody has set up; what a test sets up is forgotten afterwards."""
    made = connect("first program")
    yield made
    forget(made)


def forget(hub: canwire.Hub) -> None:
    hub.set_note("acan", b"")
    with hub.open_control(hub.board(BOARD).id, 0) as control:
        control.reset()


@pytest.fixture
def driver(hub: canwire.Hub) -> Iterator[Driver]:
    with open_driver(hub) as made:
        yield made


@pytest.fixture
def running(driver: Driver) -> Driver:
    """Set up with filters open, and on the bus."""
    driver.configure(HardConfig())
    driver.bus_on()
    return driver


@pytest.fixture
def second(connect: Connect, hub: canwire.Hub) -> Iterator[Driver]:
    """Another program on the same machine."""
    with open_driver(connect("second program")) as made:
        yield made


@pytest.fixture
def peer(connect: Connect) -> Iterator[Peer]:
    with contextlib.closing(Peer(connect("the rest"))) as made:
        yield made


@pytest.fixture
def virtual() -> Iterator[Virtual]:
    """A driver on a hub in virtual time, which stands still while nobody waits, and a peer."""
    engine = Engine(World(Config.parse(CONFIG), virtual=True), "virtual")
    with contextlib.closing(engine), Hub(LocalLink(engine, "program")) as hub, open_driver(hub) as driver:
        driver.configure(HardConfig())
        driver.bus_on()
        yield Virtual(engine, hub, driver)


class Peer:
    """Another machine's line, started or (as long as `off`) not there at all."""

    def __init__(self, hub: canwire.Hub, *, off: bool = False) -> None:
        board = hub.board(PEER_BOARD)
        self._control = hub.open_control(board.id, 0)
        self._control.initialise(LineMode(RATE))
        self._channel = hub.open_channel(board.id, 0)
        self._channel.set_up(ChannelMode(500, 500, events=(EventKind.STATE,), filter_size=0))
        self._channel.activate()
        if not off:
            self._control.start()

    def start(self) -> None:
        self._control.start()

    def stop(self) -> None:
        self._control.stop()

    def send(self, *frames: Frame) -> None:
        for frame in frames:
            self._channel.send(frame)

    def receive(self, timeout: float | None = LONG) -> Frame | None:
        """The next frame; events on the way are dropped."""
        while True:
            found = self._channel.receive_any(timeout)
            if found is None or isinstance(found, Frame):
                return found

    def received(self, count: int) -> list[Frame]:
        frames = [self.receive() for _ in range(count)]
        assert None not in frames, f"{frames}: not {count}"
        return [frame for frame in frames if frame is not None]

    def close(self) -> None:
        self._channel.close()
        self._control.close()


class Virtual:
    """Virtual time, with what only a bench can do: disturb bits, look at the chip."""

    def __init__(self, engine: Engine, hub: canwire.Hub, driver: Driver) -> None:
        self.engine = engine
        self.hub = hub
        self.driver = driver
        self.faults = Faults(engine.world.buses["can0"], 1)

    def peer(self, *, off: bool = False) -> Peer:
        return Peer(self.hub, off=off)

    def registers(self) -> dict[str, int]:
        found = self.hub.registers(self.hub.board(BOARD).id, 0)
        return {register.name: register.value for register in found}


@pytest.fixture
def arrived() -> Callable[[TaskBlock, int], list[Frame]]:
    """The next so many frames of a block."""

    def take(block: TaskBlock, count: int) -> list[Frame]:
        frames: list[Frame] = []
        while len(frames) < count:
            assert block.wait(LONG), f"{len(frames)} of {count} frames came: {frames}"
            block.acknowledge()
            frames += block.retrieve(count - len(frames))
        return frames

    return take
