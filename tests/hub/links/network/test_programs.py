"""Whole programs over the network: five dialects in five processes, and a record here that is watched elsewhere."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

import canwire
from canwire import Frame
from canwire.commands.network import beside as offers
from canwire.commands.network.options import add_offer_arguments
from tests.docs.test_five_programs import COMMAND, GUIDE, LONG, PROGRAM, SHOWN, Terminals, line
from tests.hub.links.network.places import channel, elsewhere, running
from tests.hubs import Served, offering, serving, status_of, until

pytestmark = pytest.mark.realtime


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


@pytest.mark.conforms("PL-11", "PL-13", "N-29")
def test_five_programs_of_five_dialects(
    stack: ExitStack, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """docs/five-programs.md, with the programs on another machine."""
    page = GUIDE.read_text(encoding="utf-8")
    serve, go = COMMAND.findall(page)
    expected = SHOWN.findall(page)[0].splitlines()
    beside = Terminals(tmp_path)
    stack.callback(beside.close)
    hub = beside.command(f"{serve} --socket {tmp_path / 'hub.sock'}")
    assert "canwire hub on" in line(hub)
    assert "ttyCANBUS0" in line(hub)
    address = stack.enter_context(offering(str(tmp_path / "hub.sock"))).address
    (tmp_path / "elsewhere").mkdir()
    away = Terminals(tmp_path / "elsewhere")
    away._environment["CANWIRE_HUB"] = address
    away._folder = tmp_path  # a program of theirs opens the dongle that is plugged in here
    stack.callback(away.close)
    programs = {number: away.start("-c", text) for _, number, text in PROGRAM.findall(page)}
    for process in programs.values():
        assert line(process) == "ready"
    assert away.command(go).wait(LONG) == 0
    for number, process in programs.items():
        heard = [line(process) for _ in range(4)]
        assert heard == [other for other in expected if not other.startswith(number)]


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    with serving(tmp_path) as made:
        yield made


def dump(stack: ExitStack, hub: str, *words: str) -> subprocess.Popen[str]:
    """It has begun to listen."""
    process = stack.enter_context(
        subprocess.Popen(
            [sys.executable, "-m", "canwire", "dump", "HW000002:0", "--hub", hub, *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    )
    stack.callback(process.kill)
    assert process.stderr is not None
    assert "listening" in process.stderr.readline()
    return process


@pytest.mark.smoke
@pytest.mark.conforms("PL-25")
def test_what_is_recorded_here_is_seen_elsewhere_live(stack: ExitStack, served: Served) -> None:
    with offering(served.address) as (address, _), elsewhere(address) as hub:
        running(hub)
        here = dump(stack, served.address, "-l", "-n", "100")
        there = dump(stack, address, "-l", "-n", "100")
        sender = channel(hub, 0)
        for number in range(100):
            sender.send(Frame(number, bytes([number])))
        record, seen = (process.communicate(timeout=LONG)[0] for process in (here, there))
        assert record == seen
        assert [int(found, 16) for found in re.findall(r" (\w+)#", record)] == list(range(100))


@pytest.mark.conforms("PL-11")
def test_hubs_on_the_network_are_listed(served: Served) -> None:
    with offering(served.address) as (address, _):
        endpoint = address.partition("?via=")[2]
        words = [sys.executable, "-m", "canwire", "devices", "--network", endpoint]
        found = subprocess.run(words, capture_output=True, text=True, timeout=LONG, check=True).stdout
        assert re.fullmatch(r"zenoh://tests/bench  fast time, version \d+, \w+\n", found)
        (offer,) = canwire.offered_hubs(endpoint)
        assert (offer.realm, offer.name, offer.time) == ("tests", "bench", "fast")


def test_serve_ends_its_offer_with_itself(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "canwire",
        "serve",
        "--socket",
        str(tmp_path / "s"),
        "--network",
        "--listen",
    ]
    with subprocess.Popen(
        [*command, "tcp/127.0.0.1:0"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as hub:
        assert hub.stdout is not None
        assert ", offered as zenoh://canwire/127.0.0.1" in hub.stdout.readline()
        hub.terminate()
        assert hub.communicate(timeout=LONG) == ("", "")
        assert hub.returncode == 0


@pytest.mark.parametrize("hub_ends", [True, False])
def test_that_an_offer_has_ended_is_said_unless_its_hub_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], hub_ends: bool
) -> None:
    """It may notice that the hub has gone before the hub's process ends it."""
    fifo, program = tmp_path / "fifo", tmp_path / "offer"
    os.mkfifo(fifo)
    program.write_text(f"#!/bin/sh\necho offered\nread word < {fifo}\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    parser = argparse.ArgumentParser()
    add_offer_arguments(parser)
    with (
        closing(canwire.Event(manual_reset=True)) as stop,
        offers.offering(parser.parse_args([]), "hub", stop) as said,
    ):
        assert said == "offered"
        if hub_ends:
            stop.set()
        fifo.write_text("end\n")
        until(lambda: offers.WATCHING not in {one.name for one in threading.enumerate()})
    assert ("not offered to other machines any more" in capfd.readouterr().err) != hub_ends


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--realm", "lab"], "give --network, too"),
        (["--network", "--listen", "tcp/0.0.0.0:0"], "give --access FILE with users, or --insecure"),
        (["--network", "--listen", "here"], "PROTOCOL/ADDRESS:PORT"),
        (["--network", "--realm", "a/b"], "letters, digits"),
    ],
)
def test_what_cannot_be_offered_is_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], words: list[str], complaint: str
) -> None:
    assert status_of("serve", "--socket", str(tmp_path / "s"), *words) == 2
    assert complaint in capfd.readouterr().err
