"""The portable variant between processes that have nothing which Windows lacks; and what is left behind where one dies.

The processes are real ones, started with CANWIRE_PLATFORM=portable whatever these tests themselves run on.
"""

from __future__ import annotations

import os
import signal
import socket
import stat
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

import pytest

AGES = 30.0  # seconds; only a broken build waits that long
ROOT = Path(__file__).parent.parent.parent

LINES = """
import sys, canwire
TIMING = canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)

def channel(hub, number):
    board = hub.boards()[0].id
    control = hub.open_control(board, number)
    control.initialise(canwire.LineMode(TIMING))
    control.start()
    made = hub.open_channel(board, number)
    made.set_up(canwire.ChannelMode(256, 64))
    made.activate()
    return made
"""

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """Where hubs listen and memory lies; nothing else is in there."""
    made = tmp_path / "run"
    made.mkdir(mode=0o700)
    return made


@pytest.fixture
def start(place: Path) -> Iterator[Start]:
    """Starts a program without Linux's own names: words of the command line, or code."""
    running: list[subprocess.Popen[str]] = []

    def begin(*words: str) -> subprocess.Popen[str]:
        environment = os.environ | {
            "CANWIRE_PLATFORM": "portable",
            "XDG_RUNTIME_DIR": str(place),
            "PYTHONPATH": os.pathsep.join((str(ROOT / "src"), str(ROOT))),
        }
        command = [sys.executable, "-m", "tests.platform.bare", *words]
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
            cwd=ROOT,
        )
        running.append(process)
        return process

    yield begin
    for process in running:
        process.kill()
        process.communicate(timeout=AGES)


def stdout_of(process: subprocess.Popen[str]) -> IO[str]:
    assert process.stdout is not None
    return process.stdout


def serve(start: Start, place: Path) -> subprocess.Popen[str]:
    """A hub that listens."""
    hub = start("serve", "--time", "fast", "--socket", str(place / "hub"))
    assert "canwire hub on" in stdout_of(hub).readline()
    return hub


def client(start: Start, place: Path, code: str) -> subprocess.Popen[str]:
    """A program that has printed its first line."""
    program = start("-c", LINES + textwrap.dedent(code), str(place / "hub"))
    assert stdout_of(program).readline() == "ready\n"
    return program


def files(place: Path) -> list[str]:
    """What lies there, without the lock that stays."""
    return sorted(path.name for path in place.iterdir() if path.name != "canwire.lock")


def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + AGES
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


EVERYTHING = """
import select
with canwire.connect(sys.argv[1], name="one") as one, canwire.connect(sys.argv[1], name="two") as two:
    sending, receiving = channel(one, 0), channel(two, 1)
    print("ready", flush=True)
    for number in range(100):
        sending.send(canwire.Frame(number, bytes([number])))
        assert receiving.receive(10).id == number

    event = canwire.Event()
    receiving.reading.assign(event)
    sending.send(canwire.Frame(0x222, b"selected"))
    assert select.select([event.fileno()], [], [], 10)[0]
    assert event.wait(0) and not event.is_set()
    assert not select.select([event.fileno()], [], [], 0)[0]
    assert receiving.receive(0).id == 0x222
    receiving.reading.assign(None)

    fifo = one.create_fifo(4, 8)
    writer, reader = one.open_fifo(fifo.id, "writer"), two.open_fifo(fifo.id, "reader")
    for number in range(4):
        writer.end_of_ring.ring.put_bytes(bytes([number]) * 8)
    assert reader.end_of_ring.wait(10)
    assert [reader.end_of_ring.ring.take_bytes()[0] for _ in range(4)] == [0, 1, 2, 3]

    boards = canwire.Event()
    two.watch(boards)
    one.plug("usb-to-can", "HW77")
    assert boards.wait(10)

import can
from canwire.python_can import CanwireBus
heard = can.BufferedReader()
with CanwireBus("can0", hub=sys.argv[1]) as here, CanwireBus("can0", hub=sys.argv[1]) as there:
    notifier = can.Notifier(there, [heard])
    here.send(can.Message(arbitration_id=0x345, is_extended_id=False))
    assert heard.get_message(10).arbitration_id == 0x345
    notifier.stop()
print("done", flush=True)
"""


@pytest.mark.realtime
def test_frames_events_and_fifos_need_nothing_that_windows_lacks(start: Start, place: Path) -> None:
    hub = serve(start, place)
    program = client(start, place, EVERYTHING)
    assert stdout_of(program).readline() == "done\n"
    assert program.wait(AGES) == 0
    hub.send_signal(signal.SIGTERM)
    assert hub.wait(AGES) == 0
    assert files(place) == []


def test_what_others_could_use_is_for_its_user_alone(start: Start, place: Path) -> None:
    """And a name is there only while somebody may still have to open it: a FIFO's, not a channel's."""
    serve(start, place)
    client(
        start,
        place,
        """
        hub = canwire.connect(sys.argv[1])
        channel(hub, 0)
        fifo = hub.create_fifo(16, 8)
        hub.boards()
        print("ready", flush=True)
        sys.stdin.read()
        """,
    )
    until(lambda: len(files(place)) == 2)
    [ring, hub] = files(place)
    assert (hub, ring.startswith("canwire-"), ring.endswith(".ring")) == ("hub", True, True)
    for name in (ring, hub):
        assert stat.S_IMODE((place / name).stat().st_mode) == 0o600


HOLDER = """
hub = canwire.connect(sys.argv[1])
channel(hub, 0)
fifo = hub.create_fifo(16, 8)
print("ready", flush=True)
sys.stdin.read()
"""


def test_nothing_is_left_of_a_client_that_was_killed(start: Start, place: Path) -> None:
    serve(start, place)
    program = client(start, place, HOLDER)
    assert len(files(place)) >= 2
    program.kill()
    until(lambda: files(place) == ["hub"])


def test_what_a_killed_hub_left_is_replaced_by_the_next_one(start: Start, place: Path) -> None:
    hub = serve(start, place)
    program = client(start, place, HOLDER)
    hub.kill()
    hub.wait(AGES)
    program.kill()
    left = files(place)
    assert "hub" in left
    assert any(name.endswith(".ring") for name in left)
    foreign = place / f"canwire-{os.getpid()}-{'0' * 32}.ring"  # of a process that lives
    foreign.write_bytes(b"")
    serve(start, place)
    assert files(place) == [foreign.name, "hub"]
    again = client(
        start, place, "hub = canwire.connect(sys.argv[1])\nprint('ready', flush=True)\nhub.boards()\n"
    )
    assert again.wait(AGES) == 0


def test_socketcand_runs_there(start: Start, place: Path) -> None:
    """No epoll: its server waits with what is left, and a frame goes from one of its clients to another."""
    serve(start, place)
    served = start("socketcand", "--hub", str(place / "hub"), "--listen", "127.0.0.1:0")
    port = int(stdout_of(served).readline().rpartition(":")[2])

    def program() -> tuple[socket.socket, IO[bytes]]:
        made = socket.create_connection(("127.0.0.1", port), AGES)
        made.sendall(b"< open can0 >< rawmode >")
        return made, made.makefile("rb")

    (sender, told), (receiver, heard) = program(), program()
    with sender, receiver, told, heard:
        for read in (told, heard):
            assert read.read(len(b"< hi >< ok >< ok >")) == b"< hi >< ok >< ok >"
        sender.sendall(b"< send 123 2 11 22 >")
        assert heard.read(len(b"< frame 123 ")) == b"< frame 123 "


HELP = """
import contextlib, io, sys
from canwire.commands import VERBS, main
for verb in VERBS:
    if verb == "slcan":  # it asks sys.platform, which is Linux still, for pseudo terminals
        continue
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
        main([verb, "--help"])
print("all", flush=True)
"""


def test_every_verb_says_what_it_does(start: Start) -> None:
    """None imports what only Linux has."""
    assert stdout_of(start("-c", HELP)).readline() == "all\n"


def test_the_doctor_looks_at_such_a_machine(start: Start, place: Path) -> None:
    serve(start, place)
    said, _ = start("doctor", "--hub", str(place / "hub")).communicate(timeout=AGES)
    assert "a hub in another process" in said or str(place / "hub") in said
