"""How verbs end by signals, with their output closed, full or gone: alike, and told by the exit status."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from canwire import connect
from canwire.commands import VERBS, main
from tests import warm

pytestmark = pytest.mark.finding("newcomer F13")

CAR = Path(__file__).parents[3] / "examples" / "car-candump.log"
NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Lasting(NamedTuple):
    """Words that go on for long, what they print once they do, and whether a signal is their regular end."""

    words: str
    shows: str
    regular: bool = False


# {folder} is the test's own, {car} a log, {examples} its folder; --hub is added where the verb has it
LASTING = [
    Lasting("dump can0", "listening"),
    Lasting("view can0", "listening"),
    Lasting("gen can0 --timeout 600", "--seed"),
    Lasting("load --interval 0.05", "frames/s"),
    Lasting("send can0 123#11 -n 1000000 --gap 0.001 --timeout 600", ""),
    Lasting("simulate Engine can0 --db {examples}/engine.dbc", "Engine sends"),
    Lasting("play {car} --time real", "private bus"),
    Lasting("play {car} HW000001:0", "frames onto"),
    Lasting("record can0 {folder}/out.blf", "recording", regular=True),
    Lasting("plot can0 --db {examples}/engine.dbc EngineData --seconds 600 -o {folder}/x.html", "listening"),
    Lasting("demo --time real", "sensor"),
    Lasting("registers HW000003 --follow", "MOD"),
    Lasting("lin dump lin0", "listening"),
    Lasting("isotp dump can0", "listening"),
    Lasting("isotp recv can0", "receiving"),
    Lasting("lin send lin0 10#R -n 1000000", "not delivered"),
    Lasting("lin schedule lin0 10#0102@10ms", "10#0102"),
    Lasting("candrv write", "Start sending"),
    Lasting("candrv read", "Start receiving", regular=True),  # the manual's programs end with 0
    Lasting("candrv mon", "Start receiving", regular=True),
    Lasting("candrv attach CID1: {folder}/cid1", "CID1: is", regular=True),
    Lasting("fault can0 noise --rate 1e-9", ": set"),
    Lasting("slcan --pty {folder}/pty", "dongle", regular=True),
    Lasting("socketcand --listen 127.0.0.1:0", "socketcand on", regular=True),
    Lasting("serve --socket {folder}/own.sock", "canwire hub on", regular=True),
    Lasting("offer --listen tcp/127.0.0.1:0", "offered as", regular=True),
    Lasting("router --listen tcp/127.0.0.1:0 --access {folder}/lab.toml", "router on", regular=True),
]
WITHOUT_HUB = ("demo", "serve", "router")
ACCESS = '[users.anna]\nmay = "listen"\npassword = "a long one"\n'
AT_ONCE = {
    "acan",
    "adapters",
    "bits",
    "bridge",
    "campaign",
    "completion",
    "detect",
    "convert",
    "db",
    "decode",
    "devices",
    "doctor",
    "native",
    "pace",
    "plug",
    "query",
    "recover",
    "relay",
    "run",
    "share",
    "stats",
    "stop",
    "timing",
    "uds",
    "unplug",
    "up",
    "web",
}
"""They end by themselves at once, or are shown to end in tests of their own: acan's programs, a hub by `share`,
a relay in tests/hub/links/network/test_relay.py, `run` becomes its program, `bridge` takes an interface of the
kernel."""


class Running:
    """A verb in a process of its own, which has begun its work."""

    def __init__(self, one: Lasting, folder: Path, address: str) -> None:
        words = one.words.format(folder=folder, car=CAR, examples=CAR.parent).split()
        if words[0] not in WITHOUT_HUB and "--time" not in words:
            words += ["--hub", address]
        self.process = warm.Popen(
            [sys.executable, "-m", "canwire", *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=folder,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )
        if one.shows:
            self._wait_for(one.shows)
        else:
            with connect(address) as hub:
                board = hub.boards()[0].id
                while not hub.line_status(board, 0).running:
                    assert self.process.poll() is None

    def end(self, number: int) -> tuple[int, str]:
        self.process.send_signal(number)
        shown, _ = self.process.communicate(timeout=60)
        return self.process.returncode, shown

    def _wait_for(self, text: str) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if text in line:
                return
        raise AssertionError(f"ended with {self.process.wait()} before it showed {text!r}")


@pytest.fixture
def running(tmp_path: Path, hub_address: str, request: pytest.FixtureRequest) -> Iterator[Running]:
    (tmp_path / "lab.toml").touch(0o600)
    (tmp_path / "lab.toml").write_text(ACCESS)
    found = Running(request.param, tmp_path, hub_address)
    yield found
    found.process.kill()
    found.process.communicate()


def test_every_verb_is_in_the_table() -> None:
    assert {one.words.split()[0] for one in LASTING} | AT_ONCE == set(VERBS)


@pytest.mark.parametrize("number", NUMBERS, ids=lambda number: number.name)
@pytest.mark.parametrize(("running", "one"), [(one, one) for one in LASTING], indirect=["running"],
                         ids=[" ".join(one.words.split()[:2]) for one in LASTING])  # fmt: skip
def test_signals_end_verbs_alike(running: Running, one: Lasting, number: signal.Signals) -> None:
    status, shown = running.end(number)
    assert status == (0 if one.regular else 128 + number)
    assert "Traceback" not in shown


@pytest.mark.parametrize("words", ["devices", "dump can0 -T 0", "bits 123#11", "timing 500000", "--version"])
def test_closed_output_is_no_traceback(hub_address: str, words: str) -> None:
    """`canwire ... >&-`, as some daemons start programs."""
    ended = subprocess.run(
        ["sh", "-c", f"exec {sys.executable} -m canwire {words} 1>&-"],
        stderr=subprocess.PIPE,
        text=True,
        timeout=60,
        env={**os.environ, "CANWIRE_HUB": hub_address},
    )
    assert "Traceback" not in ended.stderr
    assert ended.returncode == 0


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
@pytest.mark.parametrize("words", ["devices", "bits 123#11", "timing 500000", "demo", "play {car}"])
def test_a_full_disk_is_one_line_and_a_status(hub_address: str, words: str) -> None:
    with open("/dev/full", "w") as full:
        ended = warm.run(
            [sys.executable, "-m", "canwire", *words.format(car=CAR).split()],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=120,
            env={**os.environ, "CANWIRE_HUB": hub_address},
        )
    assert (ended.returncode, ended.stderr) == (2, "canwire: standard output: No space left on device\n")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
@pytest.mark.parametrize("option", ["--log", "--vcd"])
def test_play_names_the_file_that_cannot_be_written(capsys: pytest.CaptureFixture[str], option: str) -> None:
    assert main(["play", str(CAR), option, "/dev/full", "--senders", "one"]) == 2
    assert "canwire: /dev/full: No space left on device\n" in capsys.readouterr().err
