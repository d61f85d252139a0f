"""Controllers of one bus at different rates, as copper allows it: who points it out, in which words (ruling 44)."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire import BitTiming, LineMode, LinMode
from canwire.commands import main
from tests import warm
from tests.hubs import LONG_S

pytestmark = pytest.mark.conforms("N-03")

CONFIG = """
[[bus]]
name = "can0"
[[bus]]
name = "lin0"
type = "lin"
[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"
[[board]]
kind = "inducan104"
serial = "HW000002"
base = 0x280
irq = 5
[[board]]
kind = "picocom1"
serial = "HW000003"
[[board]]
kind = "usb-to-can-fd"
serial = "HW000004"
buses = ["", "", "lin0"]
[candrv.CID1]
Board = "HW000003"
Baudrate = 500000
"""
OTHER = 250_000
MARK = re.compile(
    r"(?:canwire: )?! can0: different bit rates on one bus: "
    r".*HW000001:0 at 250000 bit/s, set by stranger \(\d+\).*"
)
LIN_MARK = re.compile(
    r"canwire: ! lin0: different bit rates on one bus: HW000001:2 at 9600 bit/s, control stranger \(\d+\); "
    r"HW000004:2 at 19200 bit/s, control .*"
)


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "canwire.toml"
    path.write_text(CONFIG)
    monkeypatch.setenv("CANWIRE_CONFIG", str(path))
    return path


@pytest.fixture
def told(tmp_path: Path) -> Path:
    """What the hub said on stderr."""
    return tmp_path / "stderr"


@pytest.fixture
def address(config: Path, told: Path) -> Iterator[str]:
    """A hub with a stranger on HW000001:0, at another rate than all others will use; and on its LIN line."""
    socket = str(config.with_name("hub.sock"))
    command = [sys.executable, "-m", "canwire", "serve", "--socket", socket, "--config", str(config)]
    with told.open("w") as file:
        hub = warm.Popen(command, stdout=subprocess.PIPE, stderr=file, text=True)
    assert hub.stdout is not None
    try:
        assert "canwire hub on" in hub.stdout.readline()
        with canwire.connect(socket, name="stranger") as stranger:
            board = stranger.board("HW000001")
            control = stranger.open_control(board.id, 0)
            control.initialise(LineMode(BitTiming.for_bit_rate(OTHER)))
            control.start()
            lin = stranger.open_lin_control(board.id, 2)
            lin.initialise(LinMode(True, 9600))
            lin.start()
            yield socket
    finally:
        hub.terminate()
        hub.wait(LONG_S)
        hub.stdout.close()


def _first_line(words: list[str], address: str, text: str | None = None) -> str:
    """On stderr, of a program of its own."""
    command = [sys.executable, "-m", "canwire", *words, "--hub", address]
    done = warm.run(command, input=text, capture_output=True, text=True, timeout=LONG_S, check=False)
    return done.stderr.partition("\n")[0]


VERBS = {
    "dump": ["dump", "HW000001:1", "-T", "0"],
    "send": ["send", "HW000001:1", "123#", "--timeout", "0.05"],
    "up": ["up", "HW000001:1"],
    "play": ["play", "-", "HW000001:1", "--timeout", "0.05"],
    "candrv send": ["candrv", "send", "-n", "1", "-t", "1"],
    "acan term": ["acan", "term", "/R:500", "1", "2", "--timeout", "0"],
    "acan wct": ["acan", "wct", "/R:500", "--timeout", "0"],
}


@pytest.mark.parametrize("verb", VERBS)
def test_the_first_line_of_a_verb(
    address: str, verb: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "(1.000000) can0 123#\n" if verb == "play" else ""
    first = _first_line(VERBS[verb], address, text)
    assert MARK.fullmatch(first), first
    assert "at 500000 bit/s" in first
    assert first.count("set by") == 2


def test_two_who_agree_have_nothing_to_be_told(address: str) -> None:
    words = ["dump", "HW000001:1", "--bit-rate", str(OTHER), "-T", "0"]
    assert _first_line(words, address).startswith("canwire: HW000001:1 on can0: 250000 bit/s")


@pytest.mark.parametrize("verb", ["dump", "send"])
def test_lin_lines(address: str, verb: str) -> None:
    words = {"dump": ["-T", "0"], "send": ["10#01", "--timeout", "0.05"]}[verb]
    first = _first_line(["lin", verb, "HW000004:2", *words], address)
    assert LIN_MARK.fullmatch(first), first


def test_devices_ends_with_it(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["devices", "--hub", address]) == 0
    assert "different bit rates" not in capsys.readouterr().out
    assert main(["up", "HW000001:1", "--hub", address]) == 0
    capsys.readouterr()
    assert main(["devices", "--hub", address]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert MARK.fullmatch(last), last
    assert last.startswith("! ")
    assert main(["devices", "--json", "--hub", address]) == 0
    (fact,) = json.loads(capsys.readouterr().out)["conflicts"]
    assert f"! {fact}" == last


def test_serve_says_it_once(address: str, told: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """When the second line starts; not again for a third program on it."""
    assert told.read_text() == ""
    assert main(["up", "HW000001:1", "--hub", address]) == 0
    warned = told.read_text()
    assert MARK.fullmatch(warned.strip().replace("canwire: ", "canwire: ! ", 1)), warned
    assert main(["dump", "HW000001:1", "-T", "0", "--hub", address]) == 0
    assert told.read_text() == warned
