"""The Python blocks of docs/porting-acan.md do what they are meant to, on a hub here and on one in another process.

A block stands behind `<!-- sample: name -->`. Time is fast; a USB-to-CAN on the same bus is the rest of the world.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import re
import threading
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import BitTiming, ChannelMode, Frame, LineMode, acan
from canwire.acan import api
from canwire.boards.config.configuration import Config
from canwire.bus.can.faults.faults import Faults
from canwire.commands import VERBS
from canwire.commands.acan.words import parsed
from canwire.hub.handles.hub import Hub
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from tests.hubs import connected, embedded, serving

GUIDE = Path(__file__).resolve().parent.parent.parent / "docs" / "porting-acan.md"
BLOCK = re.compile(r"^(?:<!-- sample: (\S+) -->\n)?```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FENCE = r"^```{}\n(.*?)^```$"
LONG = 30.0  # seconds after which something that should happen never will
BOARD, PEER = "HW000104", "HW000001"
CONFIG = f"""
[[bus]]
name = "can0"

[[board]]
kind = "inducan104"
serial = "{BOARD}"

[[board]]
kind = "usb-to-can"
serial = "{PEER}"
"""
RATE = BitTiming.from_btr(0xC1, 0x49)  # what HardConfig() makes: 250 kbit/s


def samples() -> dict[str, str]:
    return dict(BLOCK.findall(GUIDE.read_text(encoding="utf-8")))


def run(name: str) -> Any:
    """A block's names after it has run."""
    space: dict[str, Any] = {"__name__": name}
    exec(compile(samples()[name], f"<sample {name}>", "exec"), space)
    return argparse.Namespace(**space)


def fenced(language: str) -> list[str]:
    return re.findall(FENCE.format(language), GUIDE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def hub_process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Socket of `canwire serve`."""
    with serving(tmp_path_factory.mktemp("hub"), CONFIG) as (address, _):
        yield address


@pytest.fixture(params=["embedded", "process"])
def connect(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[[], canwire.Hub]]:
    """Connections to one hub; `canwire.connect()` makes one, too, so samples find it as programs would."""
    with contextlib.ExitStack() as closing:
        if request.param == "process":
            address = request.getfixturevalue("hub_process")
            monkeypatch.setenv("CANWIRE_HUB", address)
            yield lambda: closing.enter_context(canwire.connect(address))
        else:
            engine = closing.enter_context(embedded(CONFIG))
            monkeypatch.setattr(canwire, "connect", lambda: connected(engine, "sample"))
            yield lambda: closing.enter_context(connected(engine, "test"))


@pytest.fixture
def hub(connect: Callable[[], canwire.Hub]) -> Iterator[canwire.Hub]:
    """The hub, with a controller that nobody has set up; afterwards it is so again."""
    made = connect()
    yield made
    api.use(None)
    made.set_note("acan", b"")
    with made.open_control(made.board(BOARD).id, 0) as control:
        control.reset()


@pytest.fixture
def driver(hub: canwire.Hub) -> Iterator[acan.Driver]:
    """Set up and on the bus."""
    with acan.open(hub) as made:
        made.configure(acan.HardConfig())
        made.bus_on()
        yield made


@pytest.fixture
def library(driver: acan.Driver, hub: canwire.Hub) -> Any:
    """The manual's functions, with the controller set up and on the bus."""
    api.use(hub)
    assert api.ACAN_Init()
    return api


class Peer:
    """Another machine's line at the same rate."""

    def __init__(self, hub: canwire.Hub) -> None:
        board = hub.board(PEER)
        self.control = hub.open_control(board.id, 0)
        self.control.initialise(LineMode(RATE))
        self.channel = hub.open_channel(board.id, 0)
        self.channel.set_up(ChannelMode(500, 500))
        self.channel.activate()
        self.control.start()

    def send(self, *frames: Frame) -> None:
        for frame in frames:
            self.channel.send(frame)

    def receive(self) -> Frame:
        frame = self.channel.receive(LONG)
        assert frame is not None
        return frame


@pytest.fixture
def peer(connect: Callable[[], canwire.Hub], hub: canwire.Hub) -> Iterator[Peer]:
    made = Peer(connect())
    yield made
    made.channel.close()
    made.control.reset()
    made.control.close()


def test_every_block_has_a_name() -> None:
    names = [name for name, _ in BLOCK.findall(GUIDE.read_text(encoding="utf-8"))]
    assert all(names)
    assert len(names) == len(set(names))


def test_the_page_is_short() -> None:
    assert len(GUIDE.read_text(encoding="utf-8").splitlines()) < 600


# programs


def test_first(hub: canwire.Hub, capsys: pytest.CaptureFixture[str]) -> None:
    """As printed, but for the time."""
    run("first")
    [shown] = re.findall(
        r"^```text\n(\[Frame.*?)^```$", GUIDE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
    time = re.compile(r"timestamp_ns=\d+")
    assert time.sub("", capsys.readouterr().out) == time.sub("", shown)


@pytest.mark.conforms("AC-20", "AC-21", "AC-31", "AC-35")
def test_whole(hub: canwire.Hub, peer: Peer) -> None:
    answers: list[Frame] = []

    def answer() -> None:
        answers.append(peer.receive())
        peer.send(Frame(0x124, b"yes"))

    answering = threading.Thread(target=answer)
    answering.start()
    sample = run("whole")
    answering.join(LONG)
    assert answers == [Frame(0x123, b"\x11\x22")]
    assert sample.answer == Frame(0x124, b"yes")
    assert sample.driver.hub.lost


@pytest.mark.conforms("AC-05", "AC-06")
def test_ini() -> None:
    sample = run("ini")
    assert sample.installation == sample.same == acan.Installation(0x280, 5)


@pytest.mark.conforms("AC-09", "AC-10")
@pytest.mark.parametrize("name", ["start", "start-api"])
def test_start(hub: canwire.Hub, name: str) -> None:
    start = run(name).start
    assert start() == "virgin"
    with acan.open(hub) as driver:
        driver.configure(acan.HardConfig())
    assert start() == "initialised"
    api.use(None)
    hub.set_note("acan", b"uninstalled")
    assert "operational" in start() or "uninstalled" in start()


@pytest.mark.conforms("AC-11", "AC-13", "AC-16")
def test_hard_api(hub: canwire.Hub) -> None:
    api.use(hub)
    api.ACAN_Init()
    assert run("hard-api").set_up() == 0x0001
    values = {value.name: value.value for value in hub.registers(hub.board(BOARD).id, 0)}
    assert (values["BTR0"], values["BTR1"], values["IER"]) == (0x81, 0x49, 0xAD)


@pytest.mark.conforms("AC-11", "AC-12")
def test_hard(hub: canwire.Hub) -> None:
    sample = run("hard")
    with acan.open(hub) as driver:
        assert "ts1" in sample.set_up(driver, ts1=18)
        assert driver.config() is None
        assert "Clock: 16000 KHz, Rate: 250 Kbps" in sample.set_up(driver)
        assert driver.on_bus


@pytest.mark.conforms("AC-14", "AC-18", "AC-19")
def test_machine(driver: acan.Driver, peer: Peer) -> None:
    run("machine").become(driver, 3)
    config = driver.config()
    assert config is not None
    assert (config.machine_id, config.rate_kbps, driver.on_bus) == (3 << 18, 250, True)
    with driver.register(acan.TaskBlock([acan.Filter.any()])) as block:
        peer.send(*[Frame(0x48 | number) for number in range(8)])
        found: list[Frame] = []
        while len(found) < 2:
            assert block.wait(LONG)
            found += block.retrieve()
    assert [frame.id & 7 for frame in found] == [0, 3]


@pytest.mark.conforms("AC-16", "AC-33", "AC-34")
def test_bus_off() -> None:
    """In virtual time, where bits can be disturbed: each message is given up at its first error, TEC 8 more."""
    engine = Engine(World(Config.parse(CONFIG), virtual=True), "virtual")
    with contextlib.closing(engine), Hub(LocalLink(engine, "sample")) as hub, acan.open(hub) as driver:
        driver.configure(acan.HardConfig())
        driver.bus_on()
        bus: Any = engine.world.buses["can0"]
        Faults(bus, 1).inject("bit", frame_id=1, times=None)
        for _ in range(40):
            driver.send(Frame(1))
        run("bus-off").watch(driver)
        assert driver.on_bus


# task blocks


@pytest.mark.conforms("AC-20", "AC-25", "AC-26", "AC-30", "AC-36")
def test_block_and_loop_api(library: Any, peer: Peer) -> None:
    sample, loop = run("block-api"), run("loop-api")
    fields = sample.registered()
    peer.send(Frame(0x123, b"1"), Frame(0x124), Frame(0x01C0ABCD, b"2", extended=True))
    found: list[Any] = []
    while len(found) < 2:
        assert sample.event.wait(LONG)
        sample.event.clear()
        loop.process(fields, found.append)
    assert [(message.dwID, message.bData[:1]) for message in found] == [
        (0x123 << 18, b"1"),
        (0x01C0ABCD, b"2"),
    ]


@pytest.mark.conforms("AC-20", "AC-25", "AC-26")
def test_block_and_loop(driver: acan.Driver, peer: Peer) -> None:
    sample, loop = run("block"), run("loop")
    block = sample.registered(driver)
    peer.send(Frame(0x123, b"1"), Frame(0x124), Frame(0x01C0ABCD, b"2", extended=True))
    found: list[Any] = []
    while len(found) < 2:
        assert sample.event.wait(LONG)
        sample.event.clear()
        loop.process(driver, block, found.append)
    assert found == [Frame(0x123, b"1"), Frame(0x01C0ABCD, b"2", extended=True)]


@pytest.mark.conforms("AC-27", "AC-28", "AC-33")
@pytest.mark.parametrize("with_functions", [False, True])
def test_the_loops_tell_of_a_bus_error(library: Any, driver: acan.Driver, with_functions: bool) -> None:
    """Nobody else is on the bus."""
    said: list[Any] = []
    sample = run("block-api" if with_functions else "block")
    block = sample.registered() if with_functions else sample.registered(driver)
    driver.send(Frame(1))
    assert sample.event.wait(LONG)
    if with_functions:
        run("loop-api").process(block, said.append)
    else:
        run("loop").process(driver, block, said.append)
    assert said == ["ECC D9h TEC 8"]


# messages and channels


def test_filters() -> None:
    """The manual's table, on messages with and without the pattern."""
    ended = run("filters")
    for identifier, extended in (
        (0x123, False),
        (0x124, False),
        (0x01C0ABCD, True),
        (0x01C1ABCD, True),
        (0x70, False),
    ):
        word = acan.acan_word(identifier, extended)
        found = [one.passes(word) for one in (ended.ANY, ended.ONE, ended.PATTERN)]
        assert found == [one.matches(word) for one in ended.same]
        assert found == [True, identifier == 0x123, word >> 16 == 0x01C0]


@pytest.mark.conforms("AC-17", "AC-31")
def test_send_api(library: Any, peer: Peer) -> None:
    send = run("send-api").send
    for number in range(700):  # more than there are buffers
        send(number, b"\1")
        if number >= 300:
            assert peer.receive().id == number - 300
    assert peer.receive() == Frame(400, b"\1", extended=True)


@pytest.mark.conforms("AC-32")
def test_priority_0(driver: acan.Driver, peer: Peer) -> None:
    with driver.register(acan.TaskBlock([acan.Filter.any()])) as block:
        assert run("priority-0").broadcast(driver, block) == [Frame(0x048, b"to all")]
    assert peer.receive() == Frame(0x048, b"to all")


@pytest.mark.conforms("AC-22", "AC-23", "AC-24")
def test_channels(driver: acan.Driver, peer: Peer, hub: canwire.Hub) -> None:
    sample = run("channels")
    with sample.serve(driver) as block:
        peer.send(Frame(0x100, b"\x10\x20\x30"))
        assert block.wait(LONG)
        assert sample.speed == b"\x10\x20"
        head = (0x200 << 18).to_bytes(4, "little")
        peer.send(Frame(0x101, head + bytes([0, 8])))
        assert peer.receive() == Frame(0x200, b"ready")
        sample.request(driver, 0x201)
        assert peer.receive() == Frame(0x101, (0x201 << 18).to_bytes(4, "little") + bytes([0, 8]))


@pytest.mark.conforms("AC-38")
def test_int2d(hub: canwire.Hub) -> None:
    api.use(hub)
    sample = run("int2d")
    assert sample.configured
    assert sample.entry_point == sample.driver.entry_point
    assert sample.his == acan.HardConfig().to_hi()


# what is no Python


def test_command_lines() -> None:
    parser = argparse.ArgumentParser()
    verbs = parser.add_subparsers()
    for name, verb in VERBS.items():
        importlib.import_module(verb.module).add_arguments(verbs.add_parser(name))
    lines = [line.partition("#")[0].split() for text in fenced("sh") for line in text.splitlines()]
    commands = [words[1:] for words in lines if words[0] == "canwire"]
    assert len(commands) >= 7
    for words in commands:
        parser.parse_args(words)
    parsed(["/C:16000", "/R:250", "/I", "/E", "1", "0"], "CR", "IEL")


@pytest.mark.conforms("AC-01")
def test_the_board_in_the_configuration() -> None:
    (text,) = fenced("toml")
    assert tomllib.loads(text)
    (board,) = Config.parse(text).board
    assert (board.kind, board.base, board.irq) == ("inducan104", 0x280, 5)
