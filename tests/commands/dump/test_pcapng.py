"""`canwire dump --pcapng`: what is captured, read live by Wireshark's tshark, and how it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

import canwire
from canwire import Frame, HubChannel, open_log
from canwire.commands import main
from tests import warm
from tests.commands.conftest import running_lines
from tests.missing import needs_program

pytestmark = [pytest.mark.realtime, pytest.mark.conforms("PF-07")]
LONG_S = 60
FIRST = Frame(0x123, b"\x11\x22")


@pytest.fixture
def sender(hub_address: str) -> Iterator[HubChannel]:
    """A channel on can0, whose other line acknowledges."""
    with canwire.connect(hub_address) as hub, ExitStack() as closing:
        _, (_, channel) = running_lines(hub, closing, "HW000001:0", "HW000001:1", transmit=64)
        yield channel


@pytest.fixture
def dumping(hub_address: str) -> Iterator[subprocess.Popen[bytes]]:
    words = [sys.executable, "-m", "canwire", "dump", "can0", "--pcapng", "-", "--hub", hub_address]
    process = warm.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stderr is not None
    assert b"listening" in process.stderr.readline()
    yield process
    process.kill()
    process.communicate()


@needs_program("tshark")
def test_tshark_reads_it_live(dumping: subprocess.Popen[bytes], sender: HubChannel) -> None:
    """Each frame is shown while the pipe stays open; Ctrl-C ends both."""
    fields = ["-e", "can.id", "-e", "can.len", "-e", "frame.interface_name"]
    words = ["tshark", "-l", "-n", "-i", "-", "-T", "fields", "-E", "separator=;", *fields]
    with subprocess.Popen(
        words, stdin=dumping.stdout, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as reader:
        assert reader.stdout is not None
        for frame in (FIRST, Frame(0x1ABCDE, b"\x01", extended=True)):
            sender.send(frame)
            id, length, line = reader.stdout.readline().strip().split(";")
            assert (int(id, 0), int(length), line) == (frame.id, len(frame.data), "can0")
        dumping.send_signal(signal.SIGINT)
        assert dumping.wait(LONG_S) == 128 + signal.SIGINT
        assert dumping.stdout is not None
        dumping.stdout.close()
        assert reader.wait(LONG_S) == 0
    assert dumping.stderr is not None
    assert b"2 shown, 0 lost" in dumping.stderr.read()


@pytest.mark.conforms("PC-10")
def test_it_ends_when_its_reader_has_gone(dumping: subprocess.Popen[bytes], sender: HubChannel) -> None:
    assert dumping.stdout is not None
    assert dumping.stdout.read(4) == b"\x0a\x0d\x0d\x0a"  # there before the first frame is
    dumping.stdout.close()
    sender.send(FIRST)
    assert dumping.wait(LONG_S) == 141
    assert dumping.stderr is not None
    assert b"Traceback" not in dumping.stderr.read()


def test_a_file_with_filters_and_a_count(tmp_path: Path, hub_address: str, sender: HubChannel) -> None:
    path = tmp_path / "now.pcapng"
    words = [
        sys.executable,
        "-m",
        "canwire",
        "dump",
        "can0",
        "--pcapng",
        str(path),
        "--filter",
        "100-1FF",
        "-n",
        "2",
    ]
    with warm.Popen([*words, "--hub", hub_address], stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        assert b"listening" in process.stderr.readline()
        for id in (0x123, 0x300, 0x1FF, 0x101):
            sender.send(Frame(id, bytes(3)))
        assert process.wait(LONG_S) == 0
    with open_log(path) as log:
        found = [(entry.channel, entry.frame.id) for entry in log if entry.frame]
        assert log.dated
    assert found == [("can0", 0x123), ("can0", 0x1FF)]


@pytest.mark.parametrize("words", [["--json"], ["-l"], ["-t", "d"]])
def test_packets_are_no_lines(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", "can0", "--pcapng", os.devnull, *words]) == 2
    assert "--pcapng: without --" in capsys.readouterr().err
