"""SocketCAN programs in a lockstep hub's time: the same every time, to the byte."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import pytest

from tests import warm
from tests.hubs import LONG_S, serving
from tests.missing import find_program
from tests.socketcan.test_program import compiled

pytest.importorskip("numpy")

WAYS = (
    "poll", "ppoll", "select", "pselect", "epoll", "epoll2", "timeout", "sleep", "alarm", "timerfd", "interval",
    "semaphore", "condition", "mutex", "timer", "timer_thread", "timer_thread_id",
    "sigwait",
)  # fmt: skip


class Ended(NamedTuple):
    status: int
    output: str
    errors: str


@pytest.fixture(scope="session")
def ecu(tmp_path_factory: pytest.TempPathFactory) -> str:
    return compiled("ecu", tmp_path_factory)


@pytest.fixture(scope="session")
def workers(tmp_path_factory: pytest.TempPathFactory) -> str:
    return compiled("workers", tmp_path_factory)


@pytest.fixture(scope="session")
def holders(tmp_path_factory: pytest.TempPathFactory) -> str:
    return compiled("holders", tmp_path_factory)


@pytest.fixture(scope="session")
def forks(tmp_path_factory: pytest.TempPathFactory) -> str:
    return compiled("forks", tmp_path_factory)


def played(
    home: Path, cast: dict[str, Sequence[str]], stdin: str = "", longest_s: float = LONG_S
) -> dict[str, Ended]:
    """What each of these programs printed, on a hub of their own that has begun once all of them were there."""
    home.mkdir()
    hub = {"CANWIRE_HUB": str(home / "hub.sock"), "CANWIRE_TIMED": "1"}
    words = ["serve", "--time", "lockstep", "--programs", ",".join(cast), "--socket", hub["CANWIRE_HUB"]]
    with ExitStack() as closing:
        server = _started(words, {})
        closing.callback(server.communicate)
        closing.callback(server.terminate)
        assert server.stdout is not None
        assert "canwire hub on" in server.stdout.readline()
        (home / "stdin").write_text(stdin)
        programs = {
            name: _started(["run", "--", *program], {**hub, "CANWIRE_NAME": name}, home / "stdin")
            for name, program in cast.items()
        }
        return {name: _ended(one, longest_s) for name, one in programs.items()}


def _started(words: list[str], more: dict[str, str], stdin: Path = Path(os.devnull)) -> subprocess.Popen[str]:
    with stdin.open() as given:
        return warm.Popen(
            [sys.executable, "-m", "canwire", *words],
            env={**os.environ, **more},
            stdin=given,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )


def _ended(program: subprocess.Popen[str], longest_s: float = LONG_S) -> Ended:
    output, errors = program.communicate(timeout=longest_s)
    return Ended(program.returncode, output, errors)


def of_can_utils(home: Path, ecu: str) -> dict[str, Sequence[str]]:
    """Programs of can-utils, and an ECU; `isotpsend` sends what comes from its standard input."""
    for name in ("candump", "cangen", "canplayer", "isotpsend", "isotprecv"):
        find_program(name)
    requests = home / "requests"
    requests.write_text("".join(f"({100 + at * 0.013:.6f}) can0 7DF#{at:02X}\n" for at in range(4)))
    return {
        "log": ["candump", "-L", "-T", "200", "can0"],
        "noise": ["cangen", "can0", "-g", "9", "-n", "5"],
        "tester": ["canplayer", "-I", str(requests)],
        "ecu": [ecu, "1", "poll", "6"],
        "receiver": ["isotprecv", "-s", "321", "-d", "123", "can0"],
        "sender": ["isotpsend", "-s", "123", "-d", "321", "can0"],
    }


@pytest.mark.finding("machines 14")
def test_the_same_every_time(tmp_path: Path, ecu: str) -> None:
    cast = of_can_utils(tmp_path, ecu)
    message = " ".join(f"{byte:02X}" for byte in range(30))
    first, second = (played(tmp_path / name, cast, message + "\n") for name in ("first", "second"))
    assert {one.status for one in first.values()} == {0}, first
    assert first == second
    ids = [line.split()[2].split("#")[0] for line in first["log"].output.splitlines()]
    assert [ids.count(name) for name in ("7DF", "101", "111", "321")] == [4, 4, 2, 1]
    assert first["receiver"].output == message + " \n"


def of_every_way(ecu: str) -> dict[str, Sequence[str]]:
    """An ECU for each way to wait."""
    return {f"{number}-{way}": [ecu, str(number), way, "4"] for number, way in enumerate(WAYS)}


def test_every_way_to_wait(tmp_path: Path, ecu: str) -> None:
    """Four silences of 25 ms, by every clock."""
    cast = of_every_way(ecu)
    ended = played(tmp_path / "hub", cast)
    assert {name: one.output for name, one in ended.items()} == dict.fromkeys(
        cast, "0 answered, 0.100000000 0.100000000 0.100000 0\n"
    )


def test_threads_that_wait_for_each_other(tmp_path: Path, workers: str) -> None:
    """A mutex, a condition, a semaphore and joins: no wait holds up the others, and the log is the same every time."""
    find_program("candump")
    cast: dict[str, Sequence[str]] = {
        "log": ["candump", "-L", "-T", "500", "can0"],
        "workers": [workers],
    }
    first, second = (played(tmp_path / name, cast) for name in ("first", "second"))
    assert first["workers"] == (0, "40 sent, 0.200000000\n", "")
    assert first == second
    ids = [line.split()[2].split("#")[0] for line in first["log"].output.splitlines()]
    assert [ids.count(name) for name in ("100", "101", "102", "103")] == [10] * 4


def test_mutexes_and_children_are_waited_for_in_the_hubs_time(tmp_path: Path, holders: str) -> None:
    """Whoever holds a lock, or is a child, sleeps by the hub's time: who waits for it holds up nobody."""
    ended = played(tmp_path / "hub", {"holders": [holders]})["holders"]
    assert ended == (
        0,
        "mutex 20\nwriter 20\nreader 20\nalready its own 35\nchild that sleeps 30\nany child 30\nwaitid 30\n"
        "shell whose command sleeps 30\nchild that computes 0\nnone left\n",
        "",
    )


def test_a_fork_takes_part_from_its_beginning(tmp_path: Path, forks: str) -> None:
    """Time waits for what a child computes before its first wait, and not for one that waits for a pipe."""
    ended = played(tmp_path / "hub", {"forks": [forks]})["forks"]
    assert ended == (0, "computed 5\nread\nran\n", "")


def test_what_takes_no_part_is_named(tmp_path: Path, ecu: str) -> None:
    ended = played(tmp_path / "hub", {"ecu": [ecu, "1", "barrier", "2"]})
    assert (
        "ecu uses pthread_barrier_wait: by the computer's clock, not by the hub's time" in ended["ecu"].errors
    )


def test_a_script_is_one_program_after_the_other(tmp_path: Path, ecu: str) -> None:
    find_program("cansend")
    script = f"{ecu} 1 poll 1; sleep 2; cansend can0 123#; {ecu} 1 poll 1"
    assert played(tmp_path / "hub", {"script": ["sh", "-c", script]})["script"].output == (
        "0 answered, 0.025000000 0.025000000 0.025000 0\n0 answered, 2.050000000 2.050000000 2.050000 2\n"
    )


def test_a_hub_whose_time_passes_otherwise_refuses(tmp_path: Path) -> None:
    with serving(tmp_path) as hub:
        timed = {"CANWIRE_HUB": hub.address, "CANWIRE_TIMED": "1"}
        status, _, errors = _ended(_started(["run", "--", "true"], timed))
    assert status != 0
    assert "lockstep" in errors
