"""Programs that use VCI on real hubs: one in this process, and one in a process of its own.

Time is "fast": what stands in messages is exact, and nobody waits for it. Waiting is for events alone.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire import vci
from canwire.vci import server
from tests.hubs import Connect, Served, connected, embedded, fixtures
from tests.vci.programs import LIN_BOARD, Program, Virtual

CONFIG = """
[[bus]]
name = "can0"
data_bit_rate = 2000000

[[bus]]
name = "can1"

[[bus]]
name = "lin0"
type = "lin"

[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"

[[board]]
kind = "usb-to-can"
serial = "HW000002"
"""

hub_process, hub_network, mortal_hub, connect = fixtures(CONFIG)


@pytest.fixture
def mortal_program(mortal_hub: Served) -> Iterator[Program]:
    with canwire.connect(mortal_hub.address) as hub, contextlib.closing(Program(hub)) as made:
        yield made


@pytest.fixture
def hub(connect: Connect) -> Iterator[canwire.Hub]:
    """The hub that this process was initialised with."""
    made = connect("first program")
    vci.initialize(made)
    yield made
    server._process.clear()


@pytest.fixture
def program(hub: canwire.Hub) -> Iterator[Program]:
    with contextlib.closing(Program(hub)) as made:
        yield made


@pytest.fixture
def lin_board(hub: canwire.Hub) -> Iterator[str]:
    """A second board with a LIN line, on the same bus."""
    hub.plug("usb-to-can-fd", LIN_BOARD)
    yield LIN_BOARD
    hub.unplug(LIN_BOARD)


@pytest.fixture
def other_program(connect: Connect) -> Iterator[Program]:
    """Another program on the same hub."""
    with contextlib.closing(Program(connect("second program"))) as made:
        yield made


@pytest.fixture
def virtual() -> Iterator[Virtual]:
    """A program on a hub of its own in virtual time, which stands still while nobody waits."""
    with (
        embedded(CONFIG, time="virtual") as engine,
        connected(engine) as hub,
        contextlib.closing(Program(hub)) as program,
    ):
        yield Virtual(engine, program)


@pytest.fixture
def event() -> Iterator[canwire.Event]:
    made = canwire.Event()
    yield made
    made.close()


@pytest.fixture
def source_directory() -> str:
    return str(Path(canwire.__file__).parent.parent)
