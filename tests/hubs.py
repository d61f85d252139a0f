"""Hubs to test on, reached in every way there is: embedded in this process, and served by a process of its own.

Whoever tests on all of them writes `hub_process, hub_network, mortal_hub, connect = fixtures(CONFIG)` into a
conftest.py. One more way to reach a hub is a name in WAYS and a branch of `reached`.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import cache, partial
from pathlib import Path
from time import monotonic, sleep
from typing import NamedTuple

import pytest

import canwire
from canwire.boards.config.configuration import Config
from canwire.commands import main
from canwire.hub.handles.hub import Hub
from canwire.hub.links.answering import Server
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.world import World
from tests import warm

WAYS = ("embedded", "process", "network")
NETWORK = os.environ.get("CANWIRE_TEST_NETWORK", "")  # "all": every behaviour test runs over the network, too
_FREE_PORTS = range(15_000, 32_000)
_ONE_OF = 8  # else one in so many, and always the same
# what programs see of one FIFO without asking the hub is there at once in shared memory, elsewhere a moment later
_SHARED_MEMORY = (
    "test_order_is_kept_and_what_is_too_much_is_refused",
    "test_levels_and_reset",
    "test_threads_of_a_program_share_an_end",
    "test_a_fifo_lives_as_long_as_somebody_refers_to_it",
)
LONG_S = 60  # after which something that should happen never will

Connect = Callable[[str], canwire.Hub]  # a connection of this name; each stands for a program of its own


class Served(NamedTuple):
    """A hub in a process of its own: its address, and that process."""

    address: str
    process: subprocess.Popen[str]


@contextmanager
def serving(home: Path, config: str = "", *, time: str = "fast", cold: bool = False) -> Iterator[Served]:
    """`canwire serve` with this configuration (none: the usual boards), its files in a directory of its own.

    `cold`: a child of this process; else a fork of one that has canwire imported, see tests/warm.
    """
    address = str(home / "hub.sock")
    command = [sys.executable, "-m", "canwire", "serve", "--time", time, "--socket", address]
    if config:
        (home / "hub.toml").write_text(config)
        command += ["--config", str(home / "hub.toml")]
    process = (subprocess.Popen if cold else warm.Popen)(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        assert "canwire hub on" in process.stdout.readline()
        yield Served(address, process)
    finally:
        process.terminate()
        process.wait(LONG_S)
        process.stdout.close()


@cache
def parsed(config: str) -> Config:
    """The same, checked: once for all tests that embed a hub of this configuration."""
    return Config.parse(config)


@contextmanager
def served_here(home: Path, config: str = "", *, time: str = "fast") -> Iterator[str]:
    """A hub in this process that serves programs on a socket, as `canwire serve` does; that socket."""
    world = World(Config.parse(config) if config else Config.default())
    with closing(Engine(world, time)) as engine, closing(Server(engine, str(home / "hub.sock"))) as server:
        yield server.path


@contextmanager
def embedded(config: str, *, time: str = "fast") -> Iterator[Engine]:
    """What a hub in this process consists of; in "virtual" time it stands still while nobody waits."""
    with closing(Engine(World(parsed(config), virtual=time == "virtual"), time)) as engine:
        yield engine


def connected(engine: Engine, name: str = "program") -> canwire.Hub:
    """A program's connection to a hub in this process."""
    return Hub(LocalLink(engine, name))


@contextmanager
def offering(hub: str, *options: str, port: int = 0) -> Iterator[Served]:
    """`canwire offer` for the hub of that socket, on a port of its own of this machine's loopback: address, process."""
    port = port or free_port()
    command = [sys.executable, "-m", "canwire", "offer", "--hub", hub, "--realm", "tests", "--name", "bench"]
    command += ["--age", "0"]  # a busy machine takes its time
    process = warm.Popen(
        [*command, "--listen", f"tcp/127.0.0.1:{port}", *options], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        assert "offered as" in process.stdout.readline()
        yield Served(f"zenoh://tests/bench?via=tcp/127.0.0.1:{port}", process)
    finally:
        process.terminate()
        process.wait(LONG_S)
        process.stdout.close()


@contextmanager
def stopped_meanwhile(hub: canwire.Hub) -> Iterator[None]:
    """The line of the next channel is stopped, by way of `hub`, just before that channel hears of anything."""
    activate = canwire.HubChannel.activate
    with pytest.MonkeyPatch.context() as patch:

        def stop_first(channel: canwire.HubChannel) -> canwire.LineStatus:
            patch.undo()
            with hub.open_control(channel.board, channel.line) as control:
                control.stop()
            return activate(channel)

        patch.setattr(canwire.HubChannel, "activate", stop_first)
        yield


@contextmanager
def left_meanwhile(leaving: canwire.HubChannel) -> Iterator[None]:
    """Who has this channel leaves just before the next one is opened."""
    open_channel = canwire.Hub.open_channel
    with pytest.MonkeyPatch.context() as patch:

        def leave_first(hub: canwire.Hub, *where: int, **how: bool) -> canwire.HubChannel:
            patch.undo()
            leaving.close()
            return open_channel(hub, *where, **how)

        patch.setattr(canwire.Hub, "open_channel", leave_first)
        yield


@contextmanager
def taken_meanwhile(hub: canwire.Hub) -> Iterator[None]:
    """Another program begins to use the next line whose control is taken, by way of `hub`, just before that."""
    open_control = canwire.Hub.open_control
    with pytest.MonkeyPatch.context() as patch, ExitStack() as held:

        def take_first(asking: canwire.Hub, board: int, line: int) -> canwire.Control:
            patch.undo()
            with open_control(hub, board, line) as control:
                control.initialise(
                    canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000))
                )
                held.enter_context(hub.open_channel(board, line))
                control.start()
            return open_control(asking, board, line)

        patch.setattr(canwire.Hub, "open_control", take_first)
        yield


def status_of(*words: str) -> int:
    """What `canwire WORDS` exits with, in this process."""
    try:
        return main(words)
    except SystemExit as ended:  # argparse's
        return int(ended.code or 0)


def until(condition: Callable[[], object]) -> None:
    """Look again and again, for as long as it may take; AssertionError if it never comes."""
    deadline = monotonic() + LONG_S
    while not condition():
        assert monotonic() < deadline, "it never happened"
        sleep(0.001)


def free_port() -> int:
    """A port of the loopback that nobody listens on, and none of those that the system gives away by itself.

    Else a connection of somebody's could have it before it is used. Nor does another process that asks this way get
    it soon afterwards: all of them count in one file, each on from where the others are.
    """
    while True:
        port = _FREE_PORTS[_counted() % len(_FREE_PORTS)]
        with suppress(OSError), socket.create_server(("127.0.0.1", port)):
            return port


def _counted() -> int:
    """A number that no other process gets: where its byte stands in the file to whose end everybody writes."""
    file = os.open(shared_file("ports"), os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    try:
        os.write(file, b".")
        return os.lseek(file, 0, os.SEEK_CUR)
    finally:
        os.close(file)


def shared_file(name: str) -> Path:
    """For what all test runs of this user on this machine have to share."""
    return Path(tempfile.gettempdir(), f"canwire-tests-{getattr(os, 'getuid', int)()}-{name}")


def runs(item: pytest.Item) -> bool:
    """For tests that run in every way: is this one to run in this way?"""
    callspec = getattr(item, "callspec", None)
    if callspec is None or callspec.params.get("connect") != "network":
        return True
    if item.name.startswith(_SHARED_MEMORY):
        return False
    return NETWORK == "all" or zlib.crc32(item.nodeid.encode()) % _ONE_OF == 0


@contextmanager
def reached(way: str, config: str, served: Callable[[], str]) -> Iterator[Connect]:
    """Makes connections to one hub, which are closed in the end; `served` starts it, if need be, and has its socket."""
    with ExitStack() as stack:
        program: Callable[..., canwire.Hub]
        if way == "network":
            from tests.hub.links.network.places import PATIENT, elsewhere  # needs an extra

            program = partial(elsewhere, served(), PATIENT)
        elif way == "process":
            program = partial(canwire.connect, served())
        else:
            assert way == "embedded", way
            program = partial(connected, stack.enter_context(embedded(config)))
        yield lambda name: stack.enter_context(program(name=name))


def fixtures(config: str) -> tuple[object, object, object, object]:
    """`hub_process`, `hub_network`, `mortal_hub` and `connect` for a conftest.py, on hubs of this configuration."""

    @pytest.fixture(scope="session")
    def hub_process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
        """Socket of a hub that all tests of this run share; what a test leaves behind goes with its connections."""
        with serving(tmp_path_factory.mktemp("hub"), config) as (address, _):
            yield address

    @pytest.fixture(scope="session")
    def hub_network(hub_process: str) -> Iterator[str]:
        """The same hub's address on the network."""
        with offering(hub_process) as (address, _):
            yield address

    @pytest.fixture
    def mortal_hub(tmp_path: Path) -> Iterator[Served]:
        """A hub for this test alone, with its process."""
        with serving(tmp_path, config) as made:
            yield made

    @pytest.fixture(params=WAYS)
    def connect(request: pytest.FixtureRequest) -> Iterator[Connect]:
        """Makes connections to one hub; each stands for a program of its own."""
        served = "hub_network" if request.param == "network" else "hub_process"
        with reached(request.param, config, lambda: str(request.getfixturevalue(served))) as made:
            yield made

    return hub_process, hub_network, mortal_hub, connect
