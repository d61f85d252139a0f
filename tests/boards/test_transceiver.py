"""Output pins that float drive nothing: who sees what of such a controller."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import canwire
from canwire import BitTiming, ChannelMode, ErrorKind, EventKind, Frame, LineMode
from canwire.boards.config.configuration import Config
from canwire.bus.can.bus import CanBus
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from tests.hubs import connected

pytestmark = [pytest.mark.core, pytest.mark.conforms("AC-12"), pytest.mark.finding("acan A7")]

CONFIG = """
[[bus]]
name = "can0"
[[board]]
kind = "inducan104"
serial = "HW000001"
base = 0x280
irq = 5
buses = ["can0"]
[[board]]
kind = "pc-i04"
serial = "HW000002"
buses = ["can0"]
[[board]]
kind = "usb-to-can"
serial = "HW000003"
buses = ["can0", ""]
"""
FLOATING, DRIVING = 0x00, 0x6A
RATE = BitTiming.for_bit_rate(250_000)
AT_ACK = 0xD9  # of ECC: no acknowledge


class Program:
    """One line, and what it hears."""

    def __init__(self, hub: canwire.Hub, name: str, ocr: int | None = None) -> None:
        self.hub = hub
        self.board = hub.board(name).id
        self.control = hub.open_control(self.board, 0)
        self.start(ocr)
        self.channel = hub.open_channel(self.board, 0)
        self.channel.set_up(ChannelMode(100, 100, events=(EventKind.ERROR,)))
        self.channel.activate()

    def start(self, ocr: int | None) -> None:
        self.control.initialise(
            LineMode(RATE, error_frames=True, registers=() if ocr is None else (("OCR", ocr),))
        )
        self.control.start()

    def heard(self) -> list[int]:
        found = []
        while (one := self.channel.receive_any(0)) is not None:
            if isinstance(one, Frame):
                found.append(one.id)
        return found

    def errors(self) -> list[ErrorKind]:
        found = []
        while (one := self.channel.receive_any(0)) is not None:
            if not isinstance(one, Frame) and one.kind is EventKind.ERROR:
                found.append(one.error)
        return found

    @property
    def status(self) -> canwire.LineStatus:
        return self.hub.line_status(self.board, 0)

    def register(self, name: str) -> int:
        return next(one.value for one in self.hub.registers(self.board, 0) if one.name == name)


@pytest.fixture
def engine() -> Iterator[Engine]:
    engine = Engine(World(Config.parse(CONFIG), virtual=True), "virtual")
    yield engine
    engine.close()


@pytest.fixture
def hub(engine: Engine) -> Iterator[canwire.Hub]:
    with connected(engine) as made:
        yield made


@pytest.fixture(params=["HW000001", "HW000002"], ids=["inducan104", "pc-i04"])
def floating(hub: canwire.Hub, request: pytest.FixtureRequest) -> Program:
    return Program(hub, request.param, FLOATING)


@pytest.fixture
def other(hub: canwire.Hub) -> Program:
    return Program(hub, "HW000003")


def test_nobody_hears_it_and_it_gets_no_acknowledge(
    hub: canwire.Hub, floating: Program, other: Program
) -> None:
    floating.channel.send(Frame(0x123, b"\x01"))
    hub.run_for(0.1)
    assert other.heard() == []
    assert other.status.errors == other.status.rec == 0
    assert floating.register("ECC") == AT_ACK
    assert (floating.status.frames_sent, floating.status.tec) == (0, 128)  # passive, and never bus-off
    assert set(floating.errors()) == {ErrorKind.ACK}


def test_it_hears_others_and_acknowledges_nobody(hub: canwire.Hub, floating: Program, other: Program) -> None:
    other.channel.send(Frame(0x100))
    hub.run_for(0.1)
    assert (other.status.frames_sent, other.status.last_error) == (0, ErrorKind.ACK)
    third = Program(hub, {"HW000001": "HW000002", "HW000002": "HW000001"}[_name(floating)], DRIVING)
    hub.run_for(0.1)
    assert other.status.frames_sent == 1
    assert third.heard() == [0x100]
    assert set(floating.heard()) == {0x100}


def test_given_up_it_hears_again(hub: canwire.Hub, floating: Program, other: Program) -> None:
    Program(hub, {"HW000001": "HW000002", "HW000002": "HW000001"}[_name(floating)], DRIVING)
    floating.channel.send(Frame(0x123))
    hub.run_for(0.05)
    floating.channel.cancel()
    assert floating.heard() == []
    hub.run_for(0.05)
    other.channel.send(Frame(0x200))
    hub.run_for(0.05)
    assert floating.heard() == [0x200]


def test_set_up_anew_with_outputs_it_is_on_the_bus(
    engine: Engine, hub: canwire.Hub, floating: Program, other: Program
) -> None:
    bus = engine.world.buses["can0"]
    assert isinstance(bus, CanBus)
    nodes = len(bus.nodes)
    for ocr in (DRIVING, FLOATING, DRIVING):
        floating.start(ocr)
    hub.run_for(0.01)
    floating.channel.send(Frame(0x123))
    other.channel.send(Frame(0x321))
    hub.run_for(0.05)
    assert other.heard() == [0x123]
    assert floating.heard() == [0x321]
    assert len(bus.nodes) == nodes


def test_a_board_that_is_pulled_leaves_nothing_on_the_bus(
    engine: Engine, hub: canwire.Hub, floating: Program
) -> None:
    bus = engine.world.buses["can0"]
    assert isinstance(bus, CanBus)
    nodes = len(bus.nodes)
    hub.unplug(_name(floating))
    assert len(bus.nodes) == nodes - 1


def _name(program: Program) -> str:
    return next(board.hardware_id for board in program.hub.boards() if board.id == program.board)
