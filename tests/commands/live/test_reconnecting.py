"""`--reconnect`: a verb goes on once its hub is back, with a line of what was missed."""

from __future__ import annotations

import argparse
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

import canwire
from canwire import Absence, BadValue, ChannelMode, Frame, HubError, HubLost, LineMode, NoSuchBoard
from canwire.commands import main, reconnecting
from canwire.commands.reconnecting import going_on
from canwire.hub import absence
from tests import warm
from tests.hub.links.network.places import RATE
from tests.hubs import served_here

pytestmark = pytest.mark.conforms("N-59")
CONFIG = '[[bus]]\nname = "can0"\n[[board]]\nkind = "usb-to-can-fd"\n[[board]]\nkind = "usb-to-can-fd"\n'


def arguments(reconnect: bool = True) -> argparse.Namespace:
    return argparse.Namespace(reconnect=reconnect)


def test_each_reason_is_told_once_and_the_time_that_was_missed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    times = iter((10.0, 22.5))
    monkeypatch.setattr(reconnecting, "Absence", lambda: Absence(lambda: next(times)))
    monkeypatch.setattr(absence, "_FIRST_S", 0.0)
    monkeypatch.setattr(absence, "_LONGEST_S", 0.0)
    ends: Iterator[Exception | None] = iter(
        (HubLost("hub gone"), HubError("no hub"), HubError("no hub"), NoSuchBoard("no can0"), None)
    )

    def work(given: argparse.Namespace) -> int:
        error = next(ends)
        if error is None or str(error) == "hub gone":
            given.watch.found()
        if error is not None:
            raise error
        return 7

    assert going_on(arguments(), work) == 7
    assert capsys.readouterr().err.splitlines() == [
        "canwire: hub gone; trying again",
        "canwire: no hub; trying again",
        "canwire: no can0; trying again",
        "canwire: connected again; the 12.5 s before were missed, and what other programs sent in them",
    ]


@pytest.mark.parametrize("reconnect", [False, True])
def test_a_hub_that_was_never_there_is_a_mistake(reconnect: bool) -> None:
    def work(given: argparse.Namespace) -> int:
        raise HubError("no hub")

    with pytest.raises(HubError):
        going_on(arguments(reconnect), work)


def test_what_is_no_matter_of_the_hub_ends_it() -> None:
    def work(given: argparse.Namespace) -> int:
        given.watch.found()
        raise BadValue("wrong")

    with pytest.raises(BadValue):
        going_on(arguments(), work)


def test_what_would_begin_anew_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dump", "can0", "--reconnect", "-n", "3"]) == 2
    assert "--reconnect: not together with -n" in capsys.readouterr().err


def test_dump_goes_on_with_a_hub_that_was_started_again(tmp_path: Path) -> None:
    address = str(tmp_path / "hub.sock")
    words = [sys.executable, "-m", "canwire", "dump", "can0", "--reconnect", "--hub", address]
    with ExitStack() as closing:
        with served_here(tmp_path, CONFIG), canwire.connect(address) as hub:
            dump = warm.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            closing.callback(dump.communicate)
            closing.callback(dump.kill)
            shown(dump, hub, 0x111)
        assert dump.stderr is not None
        while "trying again" not in dump.stderr.readline():
            pass
        with served_here(tmp_path, CONFIG), canwire.connect(address) as hub:
            while "connected again" not in dump.stderr.readline():
                pass
            shown(dump, hub, 0x222)


def shown(dump: subprocess.Popen[str], hub: canwire.Hub, identifier: int) -> None:
    """Frames of somebody else come through, from some moment on."""
    board = hub.boards()[1].id
    with hub.open_control(board, 0) as control, hub.open_channel(board, 0) as channel:
        control.initialise(LineMode(timing=RATE))
        control.start()
        channel.set_up(ChannelMode(receive=4, transmit=64))
        channel.activate()
        assert dump.stdout is not None
        line = ""
        while f"{identifier:03X}" not in line:  # the first lines may be left from an earlier call
            if select.select([dump.stdout], [], [], 0.01)[0]:
                line = dump.stdout.readline()
            elif channel.writing.ring.free():
                channel.send(Frame(identifier))


@pytest.mark.parametrize(
    ("words", "shows"),
    [
        (["view", "can0"], "222"),
        (["load", "--interval", "0.05", "can0"], "can0"),
        (["record", "can0", "drive.log"], ""),
    ],
)
def test_verbs_that_watch_go_on_by_themselves(words: list[str], shows: str, tmp_path: Path) -> None:
    address = str(tmp_path / "hub.sock")
    with ExitStack() as closing:
        with served_here(tmp_path, CONFIG), canwire.connect(address) as hub:
            verb = warm.Popen(
                [
                    sys.executable,
                    "-m",
                    "canwire",
                    *words,
                    *([] if words[0] == "record" else ["--hub", address]),
                ],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                cwd=tmp_path,
                env={**os.environ, "CANWIRE_HUB": address},
            )
            closing.callback(verb.communicate)
            closing.callback(verb.kill)
            assert verb.stderr is not None
            assert verb.stdout is not None
            if words[0] == "record":
                while "recording" not in verb.stderr.readline():
                    pass
            elif words[0] == "load":
                verb.stdout.readline()
            else:
                shown(verb, hub, 0x111)
        while "trying again" not in (line := verb.stderr.readline()):
            assert line
        with served_here(tmp_path, CONFIG), canwire.connect(address) as hub:
            while "connected again" not in (line := verb.stderr.readline()):
                assert line
            if words[0] == "record":
                while "drive-again-2.log" not in verb.stderr.readline():
                    pass
            elif words[0] == "load":
                while shows not in verb.stdout.readline():
                    pass
            else:
                shown(verb, hub, 0x222)


def test_a_board_that_is_gone_ends_what_was_not_asked_to_wait_for_it() -> None:
    def work(given: argparse.Namespace) -> int:
        given.watch.found()
        raise NoSuchBoard("no can0")

    with pytest.raises(NoSuchBoard):
        going_on(argparse.Namespace(reconnect=None), work)
