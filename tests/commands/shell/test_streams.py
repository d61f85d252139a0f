"""Streams that are closed from the beginning, full, or whose reader has gone: of verbs that others do not stand for."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import PIPE
from typing import Any, NamedTuple

import pytest

from canwire import Hub, connect, every_line
from canwire.boards.config.configuration import Config
from canwire.commands.shell.ending import GONE
from tests import warm
from tests.commands.conftest import served_here
from tests.hubs import LONG_S

pytestmark = [
    pytest.mark.finding("faults 10"),
    pytest.mark.usefixtures(
        "python_can_without_mf4"
    ),  # which `share` and `doctor` load, cold ones with pandas
    pytest.mark.skipif(sys.platform == "win32", reason="signals and descriptors as Unix has them"),
]

CONFIG = """
[[bus]]
name = "can0"
[[bus]]
name = "can1"
[[board]]
kind = "usb-to-can"
serial = "HW000001"
buses = ["can0", "can1"]
[[board]]
kind = "inducan104"
serial = "HW000002"
buses = ["can0"]
"""
CAMPAIGN = """
import canwire

@canwire.campaign(n=[1, 2])
def odd(lab, n):
    lab.can_bus("can0")
    assert n == 1, "it is even"
"""
SHORT: dict[str, tuple[int, ...]] = {  # and the status with which each ends by itself
    "share": (0,),
    "doctor --problems --hub {hub}": (0, 1),
    "campaign {home}/odd.py --workers 1": (1,),
    "campaign {home}/odd.py --repeat 0": (0,),
}


class Lasting(NamedTuple):
    """Words, what it says on `stream` when it is at work, and how one sees that at the hub."""

    words: str
    says: str
    at_work: Callable[[Hub], bool]


def _boards(count: int) -> Callable[[Hub], bool]:
    return lambda hub: len(hub.boards()) == count


def _channels(count: int) -> Callable[[Hub], bool]:
    return lambda hub: sum(place.status(hub).channels for place in every_line(hub)) == count


LASTING = {
    "bridge": Lasting("bridge can0 can1 --hub {hub}", "passing on", _channels(2)),
    "web": Lasting("web --hub {hub}", "canwire web:", _boards(2)),
    "acan spy": Lasting("acan spy --hub {hub}", "TRACE IS ON", _channels(1)),
    "acan wct": Lasting("acan wct --hub {hub}", "WCT", _channels(1)),
}


@pytest.fixture
def hub_address(tmp_path: Path) -> Iterator[str]:
    with served_here(tmp_path, Config.parse(CONFIG)) as address:
        yield address


@contextmanager
def begun(
    words: str, hub: str, home: Path, *, closed: str = "", stdout: Any = PIPE, stderr: Any = PIPE
) -> Iterator[subprocess.Popen[str]]:
    """That verb in a process of its own. A shell closes streams, and becomes it: signals are its own."""
    (home / "odd.py").write_text(CAMPAIGN)
    command = [sys.executable, "-m", "canwire", *words.format(hub=hub, home=home).split()]
    start: Callable[..., subprocess.Popen[str]] = warm.Popen
    if closed:
        start, command = subprocess.Popen, ["sh", "-c", f'exec "$@" {closed}', "sh", *command]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    process = start(command, stdin=PIPE, stdout=stdout, stderr=stderr, text=True, env=environment)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def unharmed(errors: str) -> bool:
    return "Traceback" not in errors and "Exception ignored" not in errors


@pytest.mark.parametrize("streams", [">&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize("words", SHORT)
def test_closed_streams(hub_address: str, tmp_path: Path, words: str, streams: str) -> None:
    with begun(words, hub_address, tmp_path, closed=streams) as process:
        _, errors = process.communicate(timeout=LONG_S)
    assert unharmed(errors)
    assert process.returncode in SHORT[words], errors


@pytest.fixture
def gone_reader() -> Iterator[int]:
    """A pipe's writing end whose reading end is closed before anybody writes."""
    reading, writing = os.pipe()
    os.close(reading)
    yield writing
    os.close(writing)


@pytest.mark.parametrize("words", SHORT)
def test_a_reader_that_has_gone(hub_address: str, tmp_path: Path, words: str, gone_reader: int) -> None:
    with begun(words, hub_address, tmp_path, stdout=gone_reader) as process:
        _, errors = process.communicate(timeout=LONG_S)
    assert (process.returncode, errors) == (GONE, "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
@pytest.mark.parametrize("words", SHORT)
def test_a_full_disk(hub_address: str, tmp_path: Path, words: str) -> None:
    with (
        open("/dev/full", "w") as full,
        begun(words, hub_address, tmp_path, stdout=full) as process,
    ):
        _, errors = process.communicate(timeout=LONG_S)
    assert (process.returncode, errors) == (2, "canwire: standard output: No space left on device\n")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
def test_a_full_disk_under_complaints(tmp_path: Path) -> None:
    """There is nobody to tell; the status is that of the mistake, not of a traceback."""
    with (
        open("/dev/full", "w") as full,
        begun("send can0 not-a-frame", "", tmp_path, stderr=full) as process,
    ):
        process.communicate(timeout=LONG_S)
    assert process.returncode == 2


def wait_for(begun_work: Callable[[Hub], bool], address: str, process: subprocess.Popen[str]) -> None:
    with connect(address) as hub:
        while not begun_work(hub):
            assert process.poll() is None
            hub.sleep(0.01)


@pytest.mark.parametrize("streams", [">&-", ">&- 2>&-"])
@pytest.mark.parametrize("verb", ["bridge", "acan spy", "acan wct"])
def test_lasting_verbs_with_closed_streams(hub_address: str, tmp_path: Path, verb: str, streams: str) -> None:
    lasting = LASTING[verb]
    with begun(lasting.words, hub_address, tmp_path, closed=streams) as process:
        wait_for(lasting.at_work, hub_address, process)
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=LONG_S)
    assert unharmed(errors)
    assert process.returncode == 128 + signal.SIGTERM, errors


@pytest.mark.parametrize("verb", LASTING)
def test_lasting_verbs_whose_reader_goes(hub_address: str, tmp_path: Path, verb: str) -> None:
    """`canwire bridge can0 can1 2>&1 | head -1`: it works on, and ends without a traceback's status."""
    lasting = LASTING[verb]
    with begun(lasting.words, hub_address, tmp_path, stderr=subprocess.STDOUT) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if lasting.says in line:
                break
        process.stdout.close()
        wait_for(lasting.at_work, hub_address, process)
        process.send_signal(signal.SIGTERM)
        assert process.wait(LONG_S) in (0, GONE, 128 + signal.SIGTERM)
    with connect(hub_address) as hub:
        assert _channels(0)(hub)


def test_share_with_closed_streams(tmp_path: Path) -> None:
    own = str(tmp_path / "own.sock")
    with begun(f"share python-can:virtual/streams --hub {own}", "", tmp_path, closed=">&- 2>&-") as process:
        while not os.path.exists(own):
            assert process.poll() is None
        wait_for(lambda hub: any(board.kind == "python-can" for board in hub.boards()), own, process)
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=LONG_S)
    assert (process.returncode, errors) == (0, "")
