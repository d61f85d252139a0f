"""Limits with names: who asks for too much is told so, and nobody else notices."""

from __future__ import annotations

import contextlib
import errno
import gc
import os
import resource
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import canwire
from canwire import BadConfig, ChannelMode, Hub, LimitReached
from canwire.boards.config.configuration import Config
from canwire.boards.lin.modes import LinMonitorMode
from canwire.hub.links.local import LocalLink
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.held.shared_ring import SharedRings
from canwire.hub.owner.world import World
from canwire.platform import EventDescriptor, create_memory, raise_descriptor_limit
from tests import warm
from tests.attacks.clients import Honest
from tests.hub.in_memory import Bench
from tests.hubs import LONG_S

SMALL = """
[limits]
connections = 3
channels = 2
fifos = 2
leases = 2
boards = 1
notes = 2
[[board]]
kind = "usb-to-can-fd"
"""
LOW = 64  # descriptors; an idle hub has some 12


LIMITED = """
import resource, runpy, sys
*soft, _, most = sys.argv.pop(1).split()
highest = resource.getrlimit(resource.RLIMIT_NOFILE)[1] if soft else int(most)
resource.setrlimit(resource.RLIMIT_NOFILE, (int(most), highest))
runpy.run_module("canwire", run_name="__main__", alter_sys=True)
"""


@contextlib.contextmanager
def hub_with(tmp_path: Path, limit: str, config: str = "") -> Iterator[subprocess.Popen[str]]:
    """`canwire serve` under `ulimit LIMIT`, on tmp_path/hub."""
    serve = ["serve", "--time", "fast", "--socket", str(tmp_path / "hub")]
    if config:
        (tmp_path / "hub.toml").write_text(config)
        serve += ["--config", str(tmp_path / "hub.toml")]
    command = [sys.executable, "-c", LIMITED, limit, *serve]
    with warm.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert "canwire hub on" in process.stdout.readline()
        try:
            yield process
        finally:
            process.kill()


@pytest.fixture
def small(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    with hub_with(tmp_path, f"-n {LOW}") as process:
        yield process


def descriptors(pid: int | str) -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))


pytestmark = pytest.mark.skipif(
    not os.path.exists("/proc/self/fd"), reason="descriptors are counted in /proc"
)


@pytest.mark.finding("faults 3")
def test_who_takes_the_last_descriptor_is_refused_and_nobody_else(
    tmp_path: Path, small: subprocess.Popen[str]
) -> None:
    address = str(tmp_path / "hub")
    honest = Honest(address)
    honest.exchange(3)
    before = descriptors(small.pid)
    for _ in range(10):
        with canwire.connect(address) as greedy:
            board = greedy.boards()[0].id
            with pytest.raises(LimitReached, match=f"all of its {LOW} descriptors"):  # noqa: PT012
                for _ in range(LOW):
                    greedy.open_channel(board, 0).set_up(ChannelMode(8, 8))
            with pytest.raises(LimitReached, match="descriptors"):  # noqa: PT012
                for _ in range(LOW):
                    greedy.create_fifo(10, 16)
            honest.exchange(3)
        assert honest.hub.boards()
    honest.exchange(3)
    extra = honest.hub.open_channel(honest.board, 0)
    extra.set_up(ChannelMode(8, 8))
    extra.close()
    assert descriptors(small.pid) <= before
    honest.close()


@pytest.mark.finding("faults 3", "faults-2 10")
def test_callers_without_number_end_nobody(tmp_path: Path, small: subprocess.Popen[str]) -> None:
    address = str(tmp_path / "hub")
    honest = Honest(address)
    callers = []
    for _ in range(2 * LOW):
        try:
            callers.append(canwire.connect(address))
        except canwire.HubError:
            honest.exchange(1)
    assert callers
    for caller in callers:
        caller.close()
    honest.exchange(3)
    with canwire.connect(address) as newcomer:
        assert newcomer.boards()
    silent = [socket.socket(socket.AF_UNIX) for _ in range(2 * LOW)]
    for each in silent:  # these say nothing, and make room for who does
        each.connect(address)
    with canwire.connect(address) as newcomer:
        assert newcomer.boards()
    for each in silent:
        each.close()
    honest.close()


@pytest.mark.finding("faults 3")
def test_a_hub_takes_all_descriptors_it_may_have(tmp_path: Path) -> None:
    with hub_with(tmp_path, f"-S -n {LOW}") as process:
        with canwire.connect(str(tmp_path / "hub")) as hub:
            before = descriptors(process.pid)
            for _ in range(2 * LOW):
                hub.open_channel(hub.boards()[0].id, 0).set_up(ChannelMode(8, 8))
            assert descriptors(process.pid) - before < 4 * 2 * LOW  # three for each, and the last reply
        process.terminate()
        assert process.wait(LONG_S) == 0


def test_the_limit_is_raised_as_far_as_it_goes() -> None:
    script = (
        "import resource, canwire.platform as p; p.raise_descriptor_limit(); p.raise_descriptor_limit(); "
    )
    shown = "print(p.descriptor_limit(), *resource.getrlimit(resource.RLIMIT_NOFILE))"
    command = ["bash", "-c", 'ulimit -S -n 50; ulimit -H -n 77; exec "$@"', "-", sys.executable, "-c"]
    done = subprocess.run([*command, script + shown], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["77", "77", "77"]
    assert callable(raise_descriptor_limit)
    assert resource.getrlimit(resource.RLIMIT_NOFILE)[0] > 0


class Failing:
    """Stands in for a function, and fails as the system does at the call with this number."""

    def __init__(self, function: Callable[..., object], at: int) -> None:
        self._function = function
        self._left = at

    def __call__(self, *args: object, **keywords: object) -> object:
        self._left -= 1
        if self._left == 0:
            raise OSError(errno.EMFILE, "Too many open files")
        return self._function(*args, **keywords)


STEPS = [("os.open", 1), ("os.open", 2), ("os.open", 3), ("os.open", 4), ("os.pipe", 1), ("os.pipe", 2)]


@pytest.mark.finding("faults 3")
@pytest.mark.parametrize(("step", "at"), [*STEPS, ("canwire.hub.owner.held.shared_ring.create_memory", 1)])
def test_rings_that_cannot_be_made_leave_nothing_behind(
    monkeypatch: pytest.MonkeyPatch, step: str, at: int
) -> None:
    """Whichever step finds no descriptor left."""
    gc.collect()
    before = descriptors("self")
    failing = Failing({"os.open": os.open, "os.pipe": os.pipe}.get(step, create_memory), at)
    with monkeypatch.context() as patch:
        patch.setattr(step, failing)
        with pytest.raises(OSError, match="Too many open files"):
            SharedRings(8, 8, exact=True, doorbell=None, halts=None)
    gc.collect()
    assert descriptors("self") == before


@pytest.mark.finding("faults 3")
def test_a_refused_set_up_leaves_the_channel_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench()
    hub = bench.hub()
    bench.control(hub)
    bench.control(hub, 1)
    sending, receiving = bench.channel(hub), bench.channel(hub, 1)
    with monkeypatch.context() as patch:
        failing = Failing(EventDescriptor.copies, 2)
        patch.setattr(EventDescriptor, "copies", lambda event: failing(event))
        with pytest.raises(LimitReached, match="descriptors"):
            sending.set_up(ChannelMode(32, 32))
        failing = Failing(EventDescriptor.copies, 1)
        with pytest.raises(LimitReached, match="descriptors"):
            hub.create_fifo(10, 10)
    assert not bench.world.pipes._pipes
    sending.send(canwire.Frame(0x123))
    hub.run_for(0.01)
    frame = receiving.receive()
    assert frame is not None
    assert frame.id == 0x123
    bench.close()


@pytest.fixture
def bench() -> Iterator[Bench]:
    made = Bench(Config.parse(SMALL))
    yield made
    made.close()


def test_every_limit_has_a_name(bench: Bench) -> None:
    hub, other = bench.hub("greedy"), bench.hub("other")
    board = bench.board

    def refused(name: str, ask: Callable[[Hub], object], limit: int = 2) -> None:
        taken = [ask(hub) for _ in range(limit)]
        wanted = rf"greedy \(100\) has {limit} of {limit} {name} of this hub; .* set {name} under \[limits\]"
        for _ in range(2):
            with pytest.raises(LimitReached, match=wanted):
                ask(hub)
        assert ask(other) is not hub
        for thing in taken:
            if hasattr(thing, "close"):
                thing.close()
        if taken and hasattr(taken[0], "close"):
            ask(hub).close()  # type: ignore[attr-defined]

    refused("channels", lambda hub: hub.open_channel(board, 0))
    refused("fifos", lambda hub: hub.create_fifo(10, 10))
    refused("leases", lambda hub: hub.open_layer(board, "bal"))
    refused("leases", lambda hub: hub.keep_settings(board, 0))
    refused("boards", lambda hub: hub.plug("usb-to-can"), 1)
    numbers = iter(range(100))
    refused("notes", lambda hub: hub.set_note(f"note {next(numbers)}", b"x"))


def test_monitors_are_channels(bench: Bench) -> None:
    hub = bench.hub()
    monitor = hub.open_monitor(bench.board, 2)
    monitor.set_up(LinMonitorMode(8))
    hub.open_channel(bench.board, 0)
    with pytest.raises(LimitReached, match="2 of 2 channels"):
        hub.open_monitor(bench.board, 2)
    with pytest.raises(LimitReached, match="2 of 2 channels"):
        hub.open_channel(bench.board, 0)


def test_a_pulled_board_makes_room(bench: Bench) -> None:
    hub = bench.hub()
    for _ in range(5):
        plugged = hub.plug("usb-to-can")
        for _ in range(2):
            hub.open_channel(plugged.id, 0)
        hub.unplug(plugged.hardware_id)


@pytest.mark.finding("faults 8")
def test_notes_of_those_who_left_block_nobody(bench: Bench) -> None:
    """The oldest of them go when there are too many."""
    for number in range(20):
        hub = bench.hub()
        hub.set_note(f"note {number} a", b"1")
        hub.set_note(f"note {number} b", b"1")
        bench.link(hub).die()
    last = bench.hub()
    assert sorted(last.notes("note 1")) == [
        f"note {number} {letter}" for number in (16, 17, 18, 19) for letter in "ab"
    ]
    last.set_note("note 19 a", b"mine")
    last.set_note("mine", b"2")
    assert last.note("note 19 a") == b"mine"
    with pytest.raises(LimitReached, match="2 of 2 notes"):
        last.set_note("one more", b"3")
    last.set_note("mine", b"4")
    last.set_note("mine", b"")
    last.set_note("one more", b"3")


def test_connections_of_one_process(tmp_path: Path) -> None:
    with hub_with(tmp_path, "-n 1000", SMALL) as process:
        address = str(tmp_path / "hub")
        hubs = [canwire.connect(address) for _ in range(3)]
        with pytest.raises(canwire.HubError, match=f"process {os.getpid()} has 3 of 3 connections"):
            canwire.connect(address)
        hubs.pop().close()
        for _ in range(100):  # its end is noticed soon
            try:
                hubs.append(canwire.connect(address))
                break
            except canwire.HubError:
                assert hubs[0].boards()
        assert len(hubs) == 3
        for hub in hubs:
            hub.close()
        process.terminate()


def test_a_program_without_descriptors_hears_so_and_stays_connected(tmp_path: Path) -> None:
    script = """
import os, resource, sys, canwire
hub = canwire.connect(sys.argv[1])
board = hub.boards()[0].id
resource.setrlimit(resource.RLIMIT_NOFILE, (60, 60))
try:
    for _ in range(60):
        hub.open_channel(board, 0).set_up(canwire.ChannelMode(8, 8))
except (canwire.LimitReached, OSError) as error:
    print(error)
print(len(hub.boards()) > 0)
"""
    with hub_with(tmp_path, "-n 1000") as process:
        done = warm.run(
            [sys.executable, "-c", script, str(tmp_path / "hub")],
            capture_output=True,
            text=True,
            timeout=LONG_S,
        )
        process.terminate()
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[1] == "True"
    assert "descriptors" in done.stdout or "Too many open files" in done.stdout


def test_limits_come_from_the_file() -> None:
    config = Config.parse(SMALL)
    assert (config.limits.channels, config.limits.notes) == (2, 2)
    assert len(Config.parse("[limits]\nchannels = 5").board) == len(Config.default().board)
    with pytest.raises(BadConfig, match=r"limits\.channel: no such key; there are connections, channels"):
        Config.parse("[limits]\nchannel = 5")
    with pytest.raises(BadConfig, match=r"limits\.channels = 0"):
        Config.parse("[limits]\nchannels = 0")
    with pytest.raises(BadConfig, match="limits = 5: expected a table"):
        Config.parse("limits = 5")


def test_limits_hold_in_this_process_too() -> None:
    engine = Engine(World(Config.parse(SMALL)), "fast")
    with Hub(LocalLink(engine, "one")) as hub:
        for _ in range(2):
            hub.create_fifo(10, 10)
        with pytest.raises(LimitReached, match="fifos"):
            hub.create_fifo(10, 10)
    engine.close()
