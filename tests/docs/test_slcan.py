"""docs/slcan.md: its first program, and the session of every command."""

from __future__ import annotations

import argparse
import importlib
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from canwire import ChannelMode, Frame, Hub, HubChannel, LinePlace, WantedMode, connect
from canwire.commands import VERBS
from canwire.commands.can_line import bring_up
from tests.commands.conftest import hub_address
from tests.commands.test_slcan import PATIENCE_S, Command
from tests.slcan.bench import Bench

__all__ = ["hub_address"]  # pytest finds the fixture by its name here

PAGE = Path(__file__).resolve().parent.parent.parent / "docs" / "slcan.md"
TEXT = PAGE.read_text(encoding="utf-8")
CAME = Frame(0x100, b"\x11\x33")
STAMP_MS = 19_815


def _session() -> list[tuple[str, str | None, str]]:
    """What it is, the command or None where a frame comes, the answer."""
    rows = TEXT.partition("## Every command")[2].partition("\n## ")[0]
    found = []
    for line in rows.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 3 and cells[2].startswith("`"):
            found.append((cells[0], cells[1].strip("`") if "`" in cells[1] else None, cells[2].strip("`")))
    return found


@pytest.mark.conforms("CT-02", "CT-15")
def test_the_session_of_the_page() -> None:
    bench, session = Bench(), _session()
    power_up = bench.now_ns
    assert len(session) > 20
    for what, command, answer in session:
        wanted = answer.replace("[CR]", "\r").replace("[BELL]", "\a").encode()
        if command is None:
            stamp_ns = power_up + STAMP_MS * 1_000_000
            came = Frame(CAME.id, CAME.data, timestamp_ns=stamp_ns)
            assert bench.receive(came) == wanted, what
        else:
            assert bench.ask(command.encode() + b"\r") == wanted, what
            bench.through(len(bench.can.sent))


def test_every_command_has_a_row() -> None:
    letters = {command[0] for _, command, _ in _session() if command}
    assert letters >= set("VNZSsMmOtTrFCL")


def test_commands_exist() -> None:
    lines = re.findall(r"^(?:\$|   ) (canwire .*)$", TEXT, re.MULTILINE)
    assert len(lines) > 5
    for line in lines:
        _, verb, *words = shlex.split(line, comments=True)
        parser = argparse.ArgumentParser(exit_on_error=False)
        importlib.import_module(VERBS[verb].module).add_arguments(parser)
        parser.parse_args(words)


@pytest.mark.realtime
@pytest.mark.conforms("CT-01")
@pytest.mark.usefixtures("python_can_without_mf4")
def test_the_first_program_runs_as_printed(hub_address: str, tmp_path: Path) -> None:
    """But for where the terminal is."""
    [program] = re.findall(r"<!-- sample: first -->\n```python\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    place = str(tmp_path / "can")
    command = Command(hub_address, tmp_path, "--pty", place)
    try:
        with connect(hub_address) as hub, _node(hub) as node:
            running = subprocess.Popen(
                [sys.executable, "-c", program.replace("/tmp/can", place)], stdout=subprocess.PIPE, text=True
            )
            assert node.receive(PATIENCE_S) == CAME
            node.send(Frame(0x200, b"\x44\x55"))
            assert running.communicate(timeout=PATIENCE_S)[0] == "200: 44 55\n"
    finally:
        command.end()
        command.process.communicate()


def _node(hub: Hub) -> HubChannel:
    """HW000001:0 at 125 kbit/s, as the page's dump has it."""
    board = hub.board("HW000001")
    channel = hub.open_channel(board.id, 0)
    channel.set_up(ChannelMode(100, 100))
    bring_up(hub, LinePlace(board, 0), WantedMode(125_000))
    channel.activate()
    return channel
