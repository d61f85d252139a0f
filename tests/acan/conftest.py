"""ACAN on real hubs: one in this process, one in a process of its own; and one in virtual time.

The INduCAN104 of CONFIG and the first line of a USB-to-CAN FD share a bus; that line is the rest of the world.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import pytest

import canwire
from canwire import Frame
from canwire.acan.driver import Driver, open_driver
from canwire.acan.hard_config import HardConfig
from canwire.acan.task_block import TaskBlock
from tests.acan.bench import BOARD, Arrived, Peer, Virtual
from tests.hubs import LONG_S, Connect, connected, embedded, fixtures

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
hub_process, hub_network, mortal_hub, connect = fixtures(CONFIG)


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
    with embedded(CONFIG, time="virtual") as engine, connected(engine) as hub, open_driver(hub) as driver:
        driver.configure(HardConfig())
        driver.bus_on()
        yield Virtual(engine, hub, driver)


@pytest.fixture
def arrived() -> Arrived:
    """The next so many frames of a block."""

    def take(block: TaskBlock, count: int) -> list[Frame]:
        frames: list[Frame] = []
        while len(frames) < count:
            assert block.wait(LONG_S), f"{len(frames)} of {count} frames came: {frames}"
            block.acknowledge()
            frames += block.retrieve(count - len(frames))
        return frames

    return take
