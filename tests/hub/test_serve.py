"""`canwire serve` as a real process with real clients and real signals.

Times are upper bounds that only a broken build reaches; what matters is the order of things.
"""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import (
    BitTiming,
    ChannelMode,
    Event,
    Frame,
    Hub,
    HubChannel,
    HubError,
    HubLost,
    InUse,
    LineMode,
    connect,
    serve,
)
from canwire.hub import serve as hub_serve
from canwire.hub.owner.engine import Engine
from canwire.platform import PORTABLE
from tests.hubs import status_of, until
from tests.missing import not_on_windows

AGES = 60.0  # seconds; only a broken build waits that long
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)  # Windows ends processes so by any signal
TIMING = BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)


class Served:
    """A hub process; `line` is what it said when it was ready."""

    def __init__(self, *words: str, **environment: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "canwire", "serve", *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, **environment},
        )
        assert self.process.stdout is not None
        self.line = self.process.stdout.readline().rstrip("\n")

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str]:
        """Exit status, and what it had to complain about."""
        self.process.send_signal(number)
        _, complaints = self.process.communicate(timeout=AGES)
        return self.process.returncode, complaints


Serve = Callable[..., Served]


@pytest.fixture
def start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Serve]:
    """Start hubs; clients of this test find them by CANWIRE_HUB's absence only if they are the user's usual one."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(Path(canwire.__file__).parent.parent))  # may be a relative one
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    for name in ("CANWIRE_HUB", "CANWIRE_CONFIG", "NOTIFY_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    started: list[Served] = []

    def begin(*words: str, **environment: str) -> Served:
        started.append(Served(*words, **environment))
        return started[-1]

    yield begin
    for served in started:
        if served.process.poll() is None:
            served.process.kill()
        served.process.communicate()


def lines_up(hub: Hub) -> int:
    """Both lines of the first board on the bus; its id."""
    board = hub.boards()[0].id
    for line in (0, 1):
        control = hub.open_control(board, line)
        control.initialise(LineMode(TIMING))
        control.start()
    return board


def channel(hub: Hub, board: int, line: int) -> HubChannel:
    made = hub.open_channel(board, line)
    made.set_up(ChannelMode(1024, 64))
    made.activate()
    return made


def refused(*words: str) -> str:
    """The one line that a hub complains with when it cannot start."""
    done = subprocess.run(
        [sys.executable, "-m", "canwire", "serve", *words], capture_output=True, text=True, timeout=AGES
    )
    assert (done.returncode, done.stdout) == (2, "")
    [line] = done.stderr.splitlines()
    return line


# beginning and end


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("kind", ["real", "fast"])
def test_it_serves_until_it_is_told_to_stop(
    start: Serve, tmp_path: Path, kind: str, number: signal.Signals
) -> None:
    path = str(tmp_path / "s")
    hub = start("--socket", path, "--time", kind)
    assert re.fullmatch(rf"canwire hub on {path}: 2 buses, 4 boards, {kind} time", hub.line)
    with connect(path) as client:
        assert (client.time, len(client.boards())) == (kind, 4)
    assert hub.end(number) == (0, "")
    assert not os.path.exists(path)


def test_the_usual_socket_is_where_programs_look(start: Serve, tmp_path: Path) -> None:
    hub = start()
    assert hub.line.startswith(f"canwire hub on {tmp_path}/canwire.sock: ")
    with connect() as client:
        assert client.address == str(tmp_path / "canwire.sock")
    assert hub.end() == (0, "")


def test_a_second_hub_on_the_same_socket_is_refused(start: Serve, tmp_path: Path) -> None:
    start()
    path = str(tmp_path / "canwire.sock")
    assert (
        refused()
        == f"canwire: another hub listens on {path}; connect to that one, or give --socket another path"
    )
    with connect() as client:
        assert client.boards()


def test_clients_see_a_clean_end(start: Serve, tmp_path: Path) -> None:
    hub = start()
    client = connect()
    receiver = channel(client, lines_up(client), 1)
    assert hub.end()[0] == 0
    with pytest.raises(HubLost):
        receiver.receive(timeout=AGES)
    client.close()


@pytest.mark.parametrize("abstract", [False, True])
def test_systemd_is_told(start: Serve, tmp_path: Path, abstract: bool) -> None:
    address = f"@canwire-{os.getpid()}" if abstract else str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.settimeout(AGES)
        systemd.bind(address.replace("@", "\0"))
        hub = start(NOTIFY_SOCKET=address)
        assert systemd.recv(100) == b"READY=1"
        assert hub.end() == (0, "")
        assert systemd.recv(100) == b"STOPPING=1"


def test_configurations(start: Serve, tmp_path: Path) -> None:
    for place, name in enumerate(("given.toml", "environment.toml", "canwire.toml"), 1):
        buses = "".join(f'[[bus]]\nname = "can{number}"\n' for number in range(place))
        boards = '[[board]]\nkind = "usb-to-can"\n' * place
        (tmp_path / name).write_text(buses + boards)
    environment = {"CANWIRE_CONFIG": "environment.toml"}
    assert start("--socket", "a", "--config", "given.toml", **environment).line.endswith(
        "1 bus, 1 board, real time"
    )
    assert "2 buses, 2 boards" in start("--socket", "b", **environment).line
    assert "3 buses, 3 boards" in start("--socket", "c").line


@pytest.mark.conforms("AC-08")
def test_unusual_copper_is_pointed_out(start: Serve, tmp_path: Path) -> None:
    (tmp_path / "canwire.toml").write_text(
        "[[bus]]\nname = 'can0'\nlength_m = 80\nnode_delay_ns = 75\ntermination_ohm = 60\n"
    )
    served = start("--socket", str(tmp_path / "hub"))
    assert served.line.endswith("1 bus, 0 boards, real time")
    assert served.end() == (
        0,
        "canwire: bus can0: terminated with 60 ohm; each end of the cable takes 120 to 180 ohm\n"
        "canwire: bus can0: 110 m (80 m of cable, 30 m for the nodes' delay) at 500000 bit/s, "
        "where 100 m are the longest; nodes far apart may not understand each other\n",
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--config", "bad.toml"], "bad.toml"),
        (["--config", "missing.toml"], "missing.toml"),
        (["--socket", "x" * (300 if PORTABLE else 200)], "too long"),
        (["--socket", "nowhere/s"], "nowhere"),
        (["--socket", "bad.toml"], "no socket"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
@pytest.mark.usefixtures("start")
def test_mistakes_take_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    (tmp_path / "bad.toml").write_text("[[bus]]\nnam = 3\n")
    assert status_of("serve", *words) == 2
    found = capsys.readouterr()
    [line] = found.err.splitlines()
    assert (said in line, found.out) == (True, "")


def test_serving_within_a_program(tmp_path: Path) -> None:
    stop = Event()
    lines: list[str] = []
    serving = threading.Thread(
        target=lambda: serve(str(tmp_path / "s"), time="fast", ready=lines.append, stop=stop)
    )
    serving.start()
    until(lambda: bool(lines))
    with connect(str(tmp_path / "s")) as client:
        assert client.boards()
    stop.set()
    serving.join(AGES)
    assert not serving.is_alive()
    assert not (tmp_path / "s").exists()
    stop.close()


# frames


SENDER = """
import sys
from canwire import ChannelMode, Frame, connect
with connect() as hub:
    sender = hub.open_channel(hub.boards()[0].id, 0)
    sender.set_up(ChannelMode(16, 64))
    sender.activate()
    for number in range(500):
        sender.send(Frame(0x100, number.to_bytes(2, "big")), timeout=20)
    while sender.status().pending:
        pass
"""


@pytest.mark.parametrize("kind", ["real", "fast"])
def test_frames_pass_between_processes_in_order(start: Serve, kind: str) -> None:
    start("--time", kind)
    with connect() as hub:
        receiver = channel(hub, lines_up(hub), 1)
        sender = subprocess.Popen([sys.executable, "-c", SENDER])
        numbers: list[int] = []
        while len(numbers) < 500:
            frame = receiver.receive(timeout=AGES)
            assert frame is not None
            numbers.append(int.from_bytes(frame.data, "big"))
        assert sender.wait(AGES) == 0
        assert numbers == list(range(500))
        assert receiver.status().lost == 0


# kill -9


def test_a_killed_hub_wakes_up_everybody_who_waits(start: Serve) -> None:
    hub = start("--time", "fast")
    client = connect()
    board = lines_up(client)
    receiver, other = channel(client, board, 1), connect()
    listening = other.open_control(other.boards()[1].id, 0)
    woken: dict[str, tuple[BaseException | None, float]] = {}

    def wait(what: str, blocked: Callable[[], object]) -> None:
        try:
            blocked()
            woken[what] = None, time.monotonic()
        except HubLost as error:
            woken[what] = error, time.monotonic()

    waiting = [
        threading.Thread(target=wait, args=("receive", lambda: receiver.receive(timeout=None))),
        threading.Thread(target=wait, args=("call", lambda: listening.detect([(TIMING, None)], 10**8))),
    ]
    for thread in waiting:
        thread.start()
    time.sleep(0.1)  # both wait by now; on a machine too slow for that the test shows less, but fails not
    killed = time.monotonic()
    hub.end(KILL)
    for thread in waiting:
        thread.join(AGES)
    assert {what: type(error) for what, (error, _) in woken.items()} == {"receive": HubLost, "call": HubLost}
    print({what: f"{(at - killed) * 1000:.1f} ms" for what, (_, at) in woken.items()})
    for call in (client.boards, other.now_ns, receiver.status, lambda: receiver.send(Frame(1))):
        with pytest.raises(HubLost):
            call()
    client.close()
    other.close()


def test_after_a_kill_a_new_hub_takes_the_socket_and_clients_come_back(start: Serve) -> None:
    hub = start()
    client = connect()
    name = client.boards()[0].hardware_id
    hub.end(KILL)
    assert os.path.exists("canwire.sock")
    again = start()
    with pytest.raises(HubLost):
        client.boards()
    client.close()
    with connect() as back:
        control = back.open_control(back.board(name).id, 0)
        control.initialise(LineMode(TIMING))
    assert again.end() == (0, "")


HOLDER = """
import sys, time
from canwire import connect
hub = connect(name="holder")
board = hub.boards()[0].id
held = [hub.open_control(board, 0), hub.open_channel(board, 0, exclusive=True), hub.open_scheduler(board, 0)]
print("held", flush=True)
time.sleep(60)
"""


@pytest.mark.parametrize("number", [KILL, signal.SIGTERM])
def test_a_killed_client_loses_what_it_held(start: Serve, number: signal.Signals) -> None:
    start()
    with connect() as hub:
        board = hub.boards()[0].id
        holder = subprocess.Popen([sys.executable, "-c", HOLDER], stdout=subprocess.PIPE, text=True)
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        opens: list[Callable[[], object]] = [
            lambda: hub.open_control(board, 0),
            lambda: hub.open_channel(board, 0),
            lambda: hub.open_scheduler(board, 0),
        ]
        for opened in opens:
            with pytest.raises(InUse, match="holder"):
                opened()
        holder.send_signal(number)
        holder.wait(AGES)
        holder.stdout.close()
        until(lambda: not hub.line_status(board, 0).control_holder)
        for opened in opens:
            opened()


def test_an_engine_that_stops_by_itself_ends_the_hub_with_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    engines: list[Engine] = []
    made = hub_serve._engine

    def kept(*arguments: Any) -> Engine:
        engines.append(made(*arguments))
        return engines[0]

    monkeypatch.setattr(hub_serve, "_engine", kept)
    with pytest.raises(HubError, match="the hub's engine stopped"), closing(Event()) as stop:
        serve(str(tmp_path / "s"), ready=lambda _: engines[0].close(), stop=stop)


@not_on_windows("has no limit of descriptors")
def test_a_hub_may_open_as_many_descriptors_as_the_system_allows(tmp_path: Path) -> None:
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    fewer = min(soft, 1024) - 1
    seen: list[int] = []
    resource.setrlimit(resource.RLIMIT_NOFILE, (fewer, hard))
    try:
        with closing(Event()) as stop:
            stop.set()
            serve(
                str(tmp_path / "s"),
                ready=lambda _: seen.append(resource.getrlimit(resource.RLIMIT_NOFILE)[0]),
                stop=stop,
            )
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert seen[0] > fewer
