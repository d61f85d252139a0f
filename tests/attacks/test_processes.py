"""Processes as they are: signals, closed streams, full disks, exec, fork, and hubs that stand still for a while."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import canwire
from tests import warm
from tests.attacks.clients import Honest
from tests.hubs import LONG_S, Served, serving

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and descriptors as Unix has them")

SHORT = {  # verbs that end by themselves
    "--version": "--version",
    "help": "--help",
    "demo": "demo",
    "devices": "devices --hub HUB",
    "registers": "registers HW000003 --hub HUB",
    "up": "up can0 --hub HUB",
    "recover": "recover HW000002:0 --hub HUB",
    "plug": "plug usb-to-can --hub HUB",
    "completion": "completion bash",
    "stop": "stop HW000002:0 --hub HUB",
    "send": "send HW000002:0 123#11 --hub HUB",
    "unplug": "unplug HW000005 --hub HUB",
    "bits": "bits 123#1122",
    "timing": "timing 500000",
    "candrv": "candrv registry list",
}
LONG = {  # verbs that go on until they are ended, and what they say when they have begun
    "serve": ("serve --socket HOME/own.sock", "canwire hub on"),
    "slcan": ("slcan --pty HOME/link --hub HUB", ""),
    "dump": ("dump can0 --hub HUB", ""),
    "lin dump": ("lin dump lin0 --hub HUB", ""),
}
STREAMS = {"stdin": "0", "stdout": "1", "stderr": "2", "all": "012", "full disk": ""}  # those that are closed
# what an interpreter makes of closed streams
CLOSING = """
import os, runpy, sys
for number in map(int, sys.argv.pop(1)):
    os.close(number)
    name = ("stdin", "stdout", "stderr")[number]
    setattr(sys, name, None)
    setattr(sys, f"__{name}__", None)
runpy.run_module("canwire", run_name="__main__", alter_sys=True)
"""
IN_SHELLS = {  # the same
    "stdin": "<&-",
    "stdout": ">&-",
    "stderr": "2>&-",
    "all": "<&- >&- 2>&-",
    "full disk": ">/dev/full",
}


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(tmp_path_factory.mktemp("hub")) as made:
        yield made


def words(line: str, hub: str, home: Path) -> list[str]:
    given = line.replace("HUB", hub).replace("HOME", str(home)).split()
    return [sys.executable, "-m", "canwire", *given]


@pytest.mark.finding("faults 10")
@pytest.mark.parametrize("streams", STREAMS)
@pytest.mark.parametrize("verb", SHORT)
def test_no_verb_falls_over_a_stream(shared: Served, tmp_path: Path, verb: str, streams: str) -> None:
    """One that is closed from the beginning, or that nothing can be written to: a sentence at most."""
    given = words(SHORT[verb], shared.address, tmp_path)[3:]
    with open("/dev/full" if streams == "full disk" else os.devnull, "w") as out:
        command = [sys.executable, "-c", CLOSING, STREAMS[streams], *given]
        done = warm.run(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.PIPE, text=True, timeout=LONG_S
        )
    check_words(verb, streams, done)


@pytest.mark.finding("faults 10")
@pytest.mark.parametrize("streams", IN_SHELLS)
def test_no_process_falls_over_a_stream(shared: Served, tmp_path: Path, streams: str) -> None:
    """Not while it is loaded either."""
    command = words(SHORT["devices"], shared.address, tmp_path)
    shell = ["bash", "-c", f'exec "$@" {IN_SHELLS[streams]}', "bash", *command]
    done = subprocess.run(shell, capture_output=True, text=True, timeout=LONG_S, stdin=subprocess.DEVNULL)
    check_words("devices", streams, done)


def check_words(verb: str, streams: str, done: subprocess.CompletedProcess[str]) -> None:
    assert done.returncode in (0, 1, 2), done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    if streams == "full disk" and verb in ("--version", "demo", "devices", "bits", "timing"):
        assert done.returncode == 2
        assert "No space left on device" in done.stderr


def started(command: list[str], said: str, *, cold: bool = True) -> subprocess.Popen[str]:
    process = (subprocess.Popen if cold else warm.Popen)(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    if said:
        assert process.stdout is not None
        assert said in process.stdout.readline()
    return process


@pytest.mark.finding("faults 10")
@pytest.mark.parametrize("number", ["SIGTERM", "SIGHUP", "SIGINT"])
@pytest.mark.parametrize("verb", LONG)
def test_signals_end_what_goes_on_for_ever(shared: Served, tmp_path: Path, verb: str, number: str) -> None:
    line, said = LONG[verb]
    with canwire.connect(shared.address) as hub:
        until(lambda: not listens(hub))  # the test before this one has left
        process = started(
            words(line, shared.address, tmp_path), said, cold=verb == "serve"
        )  # one stands for all
        if not said:
            until(lambda: listens(hub))  # it is at work
    process.send_signal(getattr(signal, number))
    _, errors = process.communicate(timeout=LONG_S)
    assert process.returncode in (0, 128 + getattr(signal, number)), errors
    assert "Traceback" not in errors
    left = [name for name in os.listdir(tmp_path) if not name.endswith(".lock")]
    assert left == []  # neither socket nor link; a lock is the kernel's, and its file says nothing


def listens(hub: canwire.Hub) -> bool:
    """Some process has a channel or a monitor open."""
    return any(
        hub.line_status(board.id, number).channels
        if line.lin is None
        else hub.lin_status(board.id, number).status.monitors
        for board in hub.boards()
        for number, line in enumerate(board.lines)
    )


def until(condition: Callable[[], bool]) -> None:
    event = canwire.Event()
    for _ in range(LONG_S * 50):
        if condition():
            return
        event.wait(0.02)
    raise AssertionError("it never came")


@pytest.mark.finding("faults 10")
def test_nohup_is_respected(tmp_path: Path) -> None:
    command = ["nohup", *words("serve --socket HOME/own.sock", "", tmp_path)]
    process = started(command, "canwire hub on")
    process.send_signal(signal.SIGHUP)
    with canwire.connect(str(tmp_path / "own.sock")) as hub:
        assert hub.boards()
    process.terminate()
    process.communicate(timeout=LONG_S)
    assert process.returncode == 0


HOLDING = """
import os, sys, canwire
hub = canwire.connect(sys.argv[1])
board = hub.boards()[0].id
control = hub.open_control(board, 0)
scheduler = hub.open_scheduler(board, 0)
lin = hub.open_lin_control(board, 2)
monitor = hub.open_monitor(board, 2, exclusive=True)
channel = hub.open_channel(board, 0, exclusive=True)
channel.set_up(canwire.ChannelMode(8, 8))
fifo = hub.create_fifo(10, 10)
layer = hub.open_layer(board, "mine")
"""
EXEC = """
os.set_inheritable(1, True)
os.execv("/bin/sh", ["sh", "-c", "echo other; exec sleep 60"])
"""
FORK = """
pid = os.fork()
if pid == 0:
    said = []
    for use in (hub.boards, control.start, channel.activate, scheduler.status, lin.start, monitor.activate,
                fifo.reset, lambda: channel.send(canwire.Frame(1)), lambda: channel.receive(0)):
        try:
            use()
        except canwire.CanwireError as error:
            said.append("forked" in str(error))
    hub.close()
    os.write(1, f"{said.count(True)}\\n".encode())
    os._exit(0)
os.waitpid(pid, 0)
print(len(hub.boards()) > 0, control.status().control_holder != "", flush=True)
"""


def test_another_program_in_this_process_holds_nothing(shared: Served) -> None:
    command = [sys.executable, "-c", HOLDING + EXEC, shared.address]
    with warm.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "other\n"
        while not {"0", "1", "2"}.issuperset(
            os.listdir(f"/proc/{process.pid}/fd")
        ):  # until `sleep` is loaded
            assert process.poll() is None
        with canwire.connect(shared.address) as hub:
            board = hub.boards()[0].id
            event = canwire.Event()
            while hub.line_status(board, 0).control_holder:
                event.wait(0.01)
            hub.open_channel(board, 0, exclusive=True).close()
            hub.open_monitor(board, 2, exclusive=True).close()
            hub.open_layer(board, "another").close()
        process.kill()


def test_every_handle_says_so_in_a_fork_and_the_parent_goes_on(shared: Served) -> None:
    done = warm.run(
        [sys.executable, "-c", HOLDING + FORK, shared.address], capture_output=True, text=True, timeout=LONG_S
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["9", "True", "True"]


def test_a_hub_that_is_stopped_goes_on_where_it_was(tmp_path: Path) -> None:
    with serving(tmp_path, cold=True) as served:  # whose stopping is told to its parent alone
        honest = Honest(served.address)
        honest.exchange(3)
        os.kill(served.process.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, served.process.pid, os.WSTOPPED)  # until then it may answer still
        answers: list[int] = []
        asking = threading.Thread(target=lambda: answers.append(len(honest.hub.boards())))
        asking.start()
        for number in range(20):
            honest.sending.send(canwire.Frame(0x300 + number))
        assert answers == []
        os.kill(served.process.pid, signal.SIGCONT)
        asking.join(LONG_S)
        assert answers == [len(honest.hub.boards())]
        got = [honest.receiving.receive(LONG_S) for _ in range(20)]
        assert [frame.id for frame in got if frame is not None] == list(range(0x300, 0x314))
        honest.exchange(3)
        honest.close()


def test_a_client_that_is_stopped_costs_nobody_else(tmp_path: Path) -> None:
    with serving(tmp_path) as served:
        script = HOLDING + "print('ready', flush=True)\nsys.stdin.read()"
        command = [sys.executable, "-c", script.replace("board, 0", "hub.boards()[1].id, 0"), served.address]
        with warm.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            os.kill(process.pid, signal.SIGSTOP)
            honest = Honest(served.address)
            honest.exchange(50)
            honest.close()
            process.kill()
