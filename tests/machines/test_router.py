"""docs/machines.md, "Through a router": bench and runner reach only a third machine, and rights hold all the same."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.hubs import LONG_S
from tests.machines.namespaces import Machine, machines, why_not

pytest.importorskip("zenoh")
pytestmark = [
    pytest.mark.conforms("N-32"),
    pytest.mark.finding("machines 1"),
    pytest.mark.skipif(bool(why_not()), reason=why_not()),
]
LAB = """
[users.runner]
may = "configure"
password = "a long one"

[users.visitor]
may = "listen"
password = "another one"

[router]
user = "bench"
password = "the hub's own"
"""
WHO = {"runner": "a long one", "visitor": "another one", "stranger": "a guess"}
ROUTER = "tcp/10.77.0.2:7447"
HUB = f"zenoh://lab/bench1?via={ROUTER}"
ASKS = """
import os, sys, canwire
for user in sys.argv[2:]:
    os.environ["CANWIRE_NETWORK"] = user + ".toml"
    try:
        with canwire.connect(sys.argv[1], name=user) as hub:
            said = [len(hub.boards())]
            try:
                hub.plug("usb-to-can-fd", serial="HW9" + user[:1])
                said.append("plugged")
            except canwire.HubError as error:
                said.append(str(error))
    except canwire.CanwireError as error:
        said = [type(error).__name__]
    print(user, *said, sep="|", flush=True)
"""


@pytest.fixture
def three(tmp_path: Path) -> Iterator[list[Machine]]:
    """The bench, the router's machine and the runner, with what docs/machines.md starts on the first two."""
    (tmp_path / "lab.toml").write_text(LAB)
    (tmp_path / "lab.toml").chmod(0o600)
    for user, password in WHO.items():
        (tmp_path / f"{user}.toml").write_text(f'user = "{user}"\npassword = "{password}"\n')
    offer = f"--network --realm lab --name bench1 --via {ROUTER} --access lab.toml".split()
    with machines(3) as (found, spoiler), ExitStack() as stack:
        spoiler.ways[0, 2].cut = spoiler.ways[2, 0].cut = True
        for machine, words in (
            (found[1], ["router", "--listen", ROUTER, "--access", "lab.toml"]),
            (found[0], ["serve", "--socket", str(tmp_path / "hub.sock"), *offer]),
        ):
            program = _started(machine, tmp_path, ["-m", "canwire", *words])
            stack.enter_context(program)
            stack.callback(program.terminate)
            assert program.stdout is not None
            assert "tcp/10.77.0.2" in (line := program.stdout.readline()) or HUB in line, line
        yield list(found)


def _started(machine: Machine, folder: Path, words: list[str]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        machine.words([sys.executable, *words]),
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )


def test_rights_hold_behind_a_router_on_another_machine(three: list[Machine], tmp_path: Path) -> None:
    with _started(three[2], tmp_path, ["-c", ASKS, HUB, *WHO]) as asks:
        said, _ = asks.communicate(timeout=LONG_S)
    runner, visitor, stranger = said.splitlines()
    assert runner.startswith("runner|")
    assert runner.endswith("|plugged")
    assert "visitor may only listen" in visitor
    assert stranger.startswith("stranger|Hub")
