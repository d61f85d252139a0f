"""`canwire bridge` between buses of a hub: as typed, in a process of its own, with its account at the end."""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from canwire import BadValue, Frame, connect
from canwire.commands.gateway.rules import add_rule_arguments, rules_by
from canwire.gateway.rules import Passage
from tests import warm
from tests.cases import each
from tests.gateway.test_gateway import CONFIG, got, program
from tests.hubs import LONG_S, serving


def typed(*words: str) -> tuple[Passage, Passage | None]:
    parser = argparse.ArgumentParser()
    add_rule_arguments(parser)
    there, back = rules_by(parser.parse_args(words))
    return Passage(there), None if back is None else Passage(back)


def test_rules_as_they_are_typed() -> None:
    there, back = typed("--filter", "100:700", "--map", "100=18FEF100", "--change", "18FEF100:1=80/81")
    assert there.through(Frame(0x300)) is None
    assert there.through(Frame(0x101, b"\x00")) == Frame(0x101, b"\x00")
    assert there.through(Frame(0x100, b"\x00\x01")) == Frame(0x18FEF100, b"\x00\x80", extended=True)
    assert back is not None
    assert typed("--map", "100=200")[1].through(Frame(0x200)) == Frame(0x100)  # type: ignore[union-attr]
    assert typed("--one-way")[1] is None


@each(
    "words",
    [("--map", "100"), ("--map", "100=200", "--map", "101=200"), ("--change", "100:1"), ("--filter", "xyz")],
)
def test_rules_that_cannot_be_read(words: tuple[str, ...]) -> None:
    with pytest.raises(BadValue):
        typed(*words)


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    with serving(tmp_path, CONFIG) as served:
        yield served.address


@pytest.mark.conforms("PL-07", "N-34")
def test_between_two_buses(address: str) -> None:
    with ExitStack() as closing:
        hub = closing.enter_context(connect(address))
        here, there = program(hub, "can0", closing), program(hub, "can1", closing)
        words = ["bridge", "can0", "can1", "--map", "100=200", "--change", "200:0=FF", "--filter", "100:700"]
        bridge = warm.Popen(
            [sys.executable, "-m", "canwire", *words, "--hub", address], stderr=subprocess.PIPE, text=True
        )
        closing.callback(bridge.kill)
        assert bridge.stderr is not None
        assert "HW000001:1 on can0 and HW000003:1 on can1" in bridge.stderr.readline()
        here.send(Frame(0x300))
        here.send(Frame(0x100, b"\x00"))
        assert got(there) == Frame(0x200, b"\xff")
        refused = warm.run(
            [sys.executable, "-m", "canwire", "bridge", "can1", "can0", "--hub", address],
            capture_output=True, text=True, timeout=LONG_S,
        )  # fmt: skip
        assert refused.returncode == 2
        assert "round and round: can1 > can0 > can1" in refused.stderr
        bridge.send_signal(signal.SIGINT)
        said = bridge.communicate(timeout=LONG_S)[1]
        assert said == "canwire: there: 1 passed, 1 filtered; back: 0 passed\n"
        assert bridge.returncode == 130
