"""`canwire doctor`: what it makes of a machine, and that it finds out what this one is like."""

from __future__ import annotations

import json
import os
import socket
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest

import canwire
from canwire import ChannelMode, Frame, WantedMode
from canwire.commands import main
from canwire.commands.can_line import bring_up
from canwire.commands.doctor import verb
from canwire.commands.doctor.checks import NOTE, OK, PROBLEM, Finding, examined
from canwire.commands.doctor.facts import Facts, HubFacts, Interface, Port
from canwire.commands.doctor.gathering import gathered
from canwire.commands.doctor.verb import format_finding
from canwire.commands.shared_hub import find_line
from tests.cases import each

WELL = Facts(
    system="Linux 6",
    python="3.11",
    version="1.0",
    compiled=True,
    shim="",
    extras=(("arrays", ()), ("tools", ())),
    ports=(Port("/dev/ttyUSB0", "CANable", True, "dialout"),),
    interfaces=(Interface("can0", "up"),),
    backends=("pcan", "slcan"),
    user_groups=("users",),
    hubs=(HubFacts("/run/canwire.sock", True, boards=4),),
    runtime_trouble="",
    descriptors=(1024, 4096),
    shm_free=1 << 30,
    tick_s=1e-9,
    pause_s=0.0011,
)
USB = Port("/dev/ttyUSB0", "CANable", False, "dialout")


def test_a_sound_machine_has_nothing_to_mend() -> None:
    found = examined(WELL)
    assert {finding.level for finding in found} == {OK}
    assert all(finding.remedy == "" for finding in found)
    assert {finding.subject for finding in found} == {
        "core", "extras", "serial ports", "adapters", "SocketCAN", "hub", "limits", "clock",
    }  # fmt: skip


@pytest.mark.conforms("PC-12")
@each(
    ("wrong", "level", "subject", "text", "mend"),
    [
        ({"compiled": False}, NOTE, "core", "uncompiled", "install a wheel"),
        ({"extras": (("tools", ("textual",)),)}, NOTE, "extras", "tools: textual missing", 'install "canwire[tools]"'),
        ({"extras": None}, NOTE, "extras", "runs from a folder", "pip install -e ."),
        ({"ports": None}, NOTE, "serial ports", "pyserial is missing", "canwire[hardware]"),
        ({"ports": (USB,)}, PROBLEM, "serial ports", "may not open it", "usermod -aG dialout"),
        ({"ports": (USB,), "user_groups": ("dialout",)}, PROBLEM, "serial ports", "may not", "log out and in"),
        ({"ports": (replace(USB, group="root"),)}, PROBLEM, "serial ports", "may not", "udev rule"),
        ({"interfaces": (Interface("can1", "down"),)}, NOTE, "adapters", "can1 is down", "ip link set can1 up"),
        ({"backends": None}, NOTE, "adapters", "python-can is missing", "canwire[hardware]"),
        ({"shim": "it was not built"}, NOTE, "SocketCAN", "it was not built", "C compiler"),
        ({"hubs": (HubFacts("/run/a.sock", False),)}, NOTE, "hub", "nobody listens at, left by", "rm /run/a.sock"),
        ({"hubs": (HubFacts("/x", False, named=True, why="no hub"),)}, PROBLEM, "hub", "/x: no hub",
         "canwire serve --socket /x"),
        ({"hubs": (HubFacts("/x", True, conflicts=("can0: different bit rates",)),)}, PROBLEM, "hub",
         "different bit rates", "canwire stop"),
        ({"hubs": (HubFacts("/x", True, late="bus time is late"),)}, PROBLEM, "hub", "bus time is late", "--time fast"),
        ({"hubs": (HubFacts("/x", True, troubled=("HW1:0 is bus-off\nrecover it",)),)}, PROBLEM, "lines",
         "HW1:0 is bus-off", "recover it"),
        ({"runtime_trouble": "not yours"}, PROBLEM, "hub", "not yours", "XDG_RUNTIME_DIR"),
        ({"descriptors": (64, 4096)}, PROBLEM, "limits", "64 descriptors", "ulimit -n 1024"),
        ({"shm_free": 1 << 20}, NOTE, "limits", "1 MB left", "--shm-size"),
        ({"pause_s": 0.05}, NOTE, "clock", "50.0 ms", "--time fast"),
        ({"tick_s": 0.015}, NOTE, "clock", "15000000 ns", "--time fast"),
    ],
)  # fmt: skip
def test_what_is_wrong_and_how_to_mend_it(
    wrong: dict[str, object], level: str, subject: str, text: str, mend: str
) -> None:
    found = examined(replace(WELL, **wrong))  # type: ignore[arg-type]
    (one,) = [finding for finding in found if finding.level != OK]
    assert (one.level, one.subject) == (level, subject)
    assert text in one.text
    assert mend in one.remedy


def test_nothing_is_plugged_in_and_nothing_runs() -> None:
    found = examined(replace(WELL, ports=(), hubs=(), interfaces=(), descriptors=None, shm_free=None))
    assert {finding.level for finding in found} == {OK}
    assert any("`canwire serve` starts one" in finding.text for finding in found)


@pytest.mark.conforms("PC-11", "PC-12")
def test_the_status_tells(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(verb, "gathered", lambda hub: WELL)
    assert main(["doctor"]) == 0
    assert capsys.readouterr().out.endswith("no problems\n")
    monkeypatch.setattr(verb, "gathered", lambda hub: replace(WELL, ports=(USB,)))
    assert main(["doctor"]) == 1
    shown = capsys.readouterr().out
    assert "PROBLEM  serial ports  /dev/ttyUSB0 (CANable): this user may not open it\n" in shown
    assert "-> sudo usermod -aG dialout" in shown
    assert shown.endswith("1 problem\n")
    assert main(["doctor", "--json", "--problems"]) == 1
    (one,) = map(json.loads, capsys.readouterr().out.splitlines())
    assert (one["level"], one["subject"]) == ("problem", "serial ports")


def test_a_finding_in_words() -> None:
    assert format_finding(Finding(OK, "core", "there")) == "ok       core          there"
    assert format_finding(Finding(NOTE, "hub", "x", "y")).splitlines() == [
        "note     hub           x",
        f"{'':<23}-> y",
    ]


# this machine


@pytest.mark.smoke
def test_it_looks_at_this_machine(hub_address: str) -> None:
    facts = gathered(hub_address)
    assert (facts.version, facts.compiled) == (canwire.__version__, canwire.core_mode() == "compiled")
    (hub,) = [hub for hub in facts.hubs if hub.address == hub_address]
    assert (hub.answers, hub.named, hub.boards, hub.conflicts, hub.troubled) == (True, True, 4, (), ())
    assert 0 < facts.tick_s < 1
    assert facts.pause_s >= 0.001
    assert facts.extras is None or dict(facts.extras)["arrays"] == ()


@pytest.mark.skipif(sys.platform == "win32", reason="no Unix sockets")
def test_a_socket_that_was_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(tmp_path / "canwire.sock"))
    (hub,) = gathered(None).hubs
    assert (hub.address, hub.answers, hub.named) == (str(tmp_path / "canwire.sock"), False, False)
    named = gathered(str(tmp_path / "nowhere.sock")).hubs[0]
    assert (named.answers, named.named) == (False, True)
    assert "nowhere.sock" in named.why


def test_lines_that_disagree_and_one_that_is_bus_off(hub_address: str) -> None:
    with canwire.connect(hub_address) as hub, ExitStack() as closing:
        for address, rate in (("HW000001:0", 500_000), ("HW000002:0", 250_000)):
            place = find_line(hub, address)
            channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
            channel.set_up(ChannelMode(receive=1, transmit=4))
            bring_up(hub, place, WantedMode(rate))
            channel.activate()
        channel.send(Frame(0x123))
        closing.enter_context(
            hub.bus("can0").faults.flip(bit=2, times=None)
        )  # dominant: no arbitration is lost by it
        deadline = canwire.Event()
        while place.status(hub).tec < 128:
            deadline.wait(0.01)
        (found,) = [one for one in gathered(hub_address).hubs if one.address == hub_address]
    assert found.conflicts
    assert "different bit rates" in found.conflicts[0]
    assert any("HW000002:0 on can0 is " in line for line in found.troubled)
    findings = examined(replace(WELL, hubs=(found,)))
    assert {finding.subject for finding in findings if finding.level == PROBLEM} >= {"hub", "lines"}
    assert os.path.exists(hub_address)
