"""CanWrite and CanRead of CANDRV's manual, compiled as printed, on a hub.

The listings come out of the manual as tests/commands/candrv/test_listings.py cuts them; what it says of CanRead's
misprints holds here, too.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire import candrv
from canwire.candrv import CanbusEvent
from tests.commands.candrv.test_listings import ARGUMENTS, MANUAL, listing
from tests.native.drivers.conftest import Build, Machine

pytestmark = [
    pytest.mark.skipif(not MANUAL.exists(), reason=f"the manual's text is not at {MANUAL}"),
    pytest.mark.conforms("N-41"),
]


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory, build: Build) -> dict[str, Path]:
    """CanWrite and CanRead by their names."""
    home = tmp_path_factory.mktemp("listings")
    write, read = listing("CanWrite"), listing("CanRead")
    [parsing] = ARGUMENTS.findall(write)
    first = read.index("/* Parse command line arguments */")
    read = read[:first] + parsing + read[read.index("/* Print usage, if required */") :]
    made = {}
    for name, source in (("CanWrite", write), ("CanRead", read)):
        (home / f"{name}.c").write_text(source, encoding="utf-8")
        made[name] = build(home / f"{name}.c", "candrv")
    return made


@pytest.fixture
def other(machine: Machine) -> Iterator[candrv.Handle]:
    """CID2:, which hears every message."""
    with canwire.connect(machine.address) as hub, candrv.open("CID2:", hub=hub) as handle:
        handle.accept_all()
        handle.mask = CanbusEvent.RECEIVED
        yield handle


def test_can_write_sends_what_it_logs(
    programs: dict[str, Path], machine: Machine, other: candrv.Handle
) -> None:
    out = machine.run(programs["CanWrite"], "-d", "CID1:", "-f", "log")
    assert "Start sending 1000 messages to CID1:, baudrate=1000000 Hz" in out
    came = [other.read_event() for _ in range(1000)]
    sent = "".join(f"{event.identifier:x} 0 8 {'0 ' * 8}".rstrip() + "\n" for event in came)
    assert sent == (machine.home / "log").read_text()


def test_can_read_shows_and_logs_events(
    programs: dict[str, Path], machine: Machine, other: candrv.Handle
) -> None:
    reader = machine.start(programs["CanRead"], "-f", "log")
    assert reader.stdout is not None
    while "Start receiving" not in (line := reader.stdout.readline()):
        assert line, "it ended before it received anything"
    other.write("731 0 4 11 22 33 44\n112 1 0\n")
    shown = [reader.stdout.readline() for _ in range(4)]
    assert shown[0].startswith("received\t0:")
    assert shown[0].endswith("\t00000731\t0\t4\n")  # \r\n in the text, which Python reads as one end of line
    assert shown[1] == "\t11\t22\t33\t44\t0\n"
    assert shown[2].endswith("\t00000112\t1\t0\n")


def test_words_that_go_nowhere(programs: dict[str, Path], machine: Machine) -> None:
    for program in programs.values():
        process = machine.start(program, "-d", "CID9:")
        out, _ = process.communicate()
        assert (process.returncode, out.splitlines()[1:]) == (1, ["Can't open device CID9:, error 2"])
    usage = subprocess.run([programs["CanWrite"], "-h"], capture_output=True, text=True)
    assert usage.returncode == 2
    assert "-d <dev> : Device name (CID1:)" in usage.stdout
