"""`canwire devices`, `plug` and `unplug`: the tree, the object, and boards that come and go."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import (
    BitTiming,
    BoardInfo,
    ErrorState,
    LineMode,
    LineStatus,
    LinLineStatus,
    LinMode,
    LinMonitorMode,
    LinState,
)
from canwire.boards import catalogue
from canwire.boards.isa import IsaPlace
from canwire.commands import main
from canwire.commands.devices.facts import board_facts
from canwire.commands.devices.uses import LinUse, conflicts_among, lateness_among
from canwire.commands.devices.verb import tree
from tests.hubs import connected, embedded

IDLE = LineStatus(
    initialised=False,
    running=False,
    mode=None,
    state=int(ErrorState.STOPPED),
    tec=0,
    rec=0,
    last_error=0,
    load=0.0,
    transmitting=False,
    coupling_fault=False,
    frames_sent=0,
    frames_received=0,
    errors=0,
    arbitration_losses=0,
    refused=0,
    lost=0,
    control_holder="",
    scheduler_holder="",
    channels=0,
    exclusive=False,
    time_ns=0,
)
MODE = LineMode(BitTiming.for_bit_rate(500_000), BitTiming.for_bit_rate(2_000_000), note=b"\x01\xff")
BUSY = replace(
    IDLE,
    initialised=True,
    running=True,
    mode=MODE,
    state=int(ErrorState.ERROR_PASSIVE),
    tec=128,
    rec=3,
    last_error=3,
    load=42.26,
    frames_sent=10,
    frames_received=2000,
    errors=16,
    set_by="engine (4711)",
    refused=1,
    lost=7,
    control_holder="engine (4711)",
    channels=2,
    time_ns=5_000_000,
)


LIN_IDLE = LinUse(
    LinLineStatus(
        initialised=False,
        running=False,
        mode=None,
        state=LinState.STOPPED,
        status=0x10,
        bit_rate=0,
        load=0.0,
        transmitting=False,
        headers=0,
        frames_sent=0,
        frames_received=0,
        errors=(0,) * 9,
        lost=0,
        monitors=0,
        time_ns=0,
    ),
    control_holder="",
    exclusive=False,
)
LIN_BUSY = LinUse(
    replace(
        LIN_IDLE.status,
        initialised=True,
        running=True,
        mode=LinMode(master=True, bit_rate=19_200, errors=True, note=b"\x02"),
        state=LinState.OPERATIONAL,
        status=0,
        bit_rate=19_200,
        load=31.4,
        headers=12,
        frames_sent=5,
        frames_received=4,
        errors=(0, 0, 1, 0, 2, 0, 0, 0, 0),
        lost=3,
        monitors=2,
    ),
    control_holder="master (5)",
    exclusive=False,
)


def board(name: str, board_id: int, hardware_id: str, *buses: str) -> BoardInfo:
    return catalogue.kind(name).info(board_id, hardware_id, buses)


FD = board("usb-to-can-fd", 1, "HW000001", "can0", "can0", "lin0")
CLASSIC = board("usb-to-can", 2, "HW-LONGER", "body", "can0")


@pytest.mark.smoke
def test_the_tree_tells_everything_that_changes() -> None:
    one = replace(BUSY, mode=LineMode(BitTiming.for_bit_rate(1_000_000)), exclusive=True, channels=1)
    one = replace(one, coupling_fault=True, scheduler_holder="tester (5)")
    assert tree([(FD, [IDLE, BUSY, LIN_BUSY]), (CLASSIC, [one, IDLE])]) == [
        "HW000001  usb-to-can-fd  USB-to-CAN FD (simulated)",
        "  :0  CAN-1  can0  not initialised",
        "      sent 0, received 0, errors 0, lost 0, refused 0; 0 channels, control free, cyclic list free",
        "  :1  CAN-2  can0  error passive    500000 bit/s, 2000000 after BRS  TEC 128  REC 3  load 42.3 %",
        "      sent 10, received 2000, errors 16 (last ACK), lost 7, refused 1; "
        "2 channels, control engine (4711), cyclic list free, set by engine (4711)",
        "  :2  LIN-1  lin0  operational      master, 19200 bit/s                              load 31.4 %",
        "      headers 12, sent 5, received 4, errors 3 (1 CHKSUM, 2 SLNORE), lost 3; "
        "2 monitors, control master (5)",
        "HW-LONGER  usb-to-can  USB-to-CAN V2 (simulated)",
        "  :0  CAN-1  body  shorted          1000000 bit/s                    TEC 128  REC 3  load 42.3 %",
        "      sent 10, received 2000, errors 16 (last ACK), lost 7, refused 1; "
        "1 channel (exclusive), control engine (4711), cyclic list tester (5), set by engine (4711)",
        "  :1  CAN-2  can0  not initialised",
        "      sent 0, received 0, errors 0, lost 0, refused 0; 0 channels, control free, cyclic list free",
    ]


@pytest.mark.conforms("X3-01")
def test_the_object_has_every_field() -> None:
    facts = json.loads(json.dumps(board_facts(FD, [BUSY, IDLE, LIN_BUSY])))
    assert {name: facts[name] for name in facts if name != "lines"} == {
        "id": 1,
        "kind": "usb-to-can-fd",
        "hardware_id": "HW000001",
        "device_class": "B9AAAF39-B9B9-4850-9402-7D8250C7B88F",
        "description": "USB-to-CAN FD (simulated)",
        "manufacturer": "canwire (simulated)",
        "driver_version": list(FD.driver_version),
        "hardware_version": list(FD.hardware_version),
        "firmware_version": list(FD.firmware_version),
        "resources": [],
    }
    busy, idle, lin = facts["lines"]
    assert (busy["name"], busy["bus"], busy["bus_type"], busy["index"]) == ("CAN-1", "can0", "CAN", 0)
    assert busy["capabilities"]["clock_hz"] == 80_000_000
    assert "FAST_DATA" in busy["capabilities"]["features"]
    status: dict[str, Any] = busy["status"]
    assert set(status) == set(LineStatus.__dataclass_fields__)
    assert (status["state"], status["last_error"], status["lost"]) == ("ERROR_PASSIVE", "ACK", 7)
    assert (status["mode"]["timing"]["bit_rate"], status["mode"]["data_timing"]["bit_rate"]) == (
        500_000,
        2_000_000,
    )
    assert status["mode"]["note"] == "01ff"
    assert idle["status"]["mode"] is None
    assert (lin["name"], lin["bus"], lin["bus_type"], lin["index"]) == ("LIN-1", "lin0", "LIN", 2)
    assert (lin["capabilities"], busy["lin"]) == (None, None)
    assert "MASTER" in lin["lin"]["features"]
    assert set(lin["status"]) == {*LinLineStatus.__dataclass_fields__, "control_holder", "exclusive"}
    assert (lin["status"]["state"], lin["status"]["control_holder"]) == ("OPERATIONAL", "master (5)")
    assert lin["status"]["mode"] == {
        "master": True,
        "bit_rate": 19_200,
        "errors": True,
        "note": "02",
        "kin": "",
    }
    assert {kind for kind, count in lin["status"]["errors"].items() if count} == {"CHKSUM", "SLNORE"}


@pytest.mark.conforms("AC-01", "AC-03")
def test_what_a_board_takes_of_its_machine() -> None:
    place = IsaPlace(0x280, 5)
    isa = replace(board("usb-to-can", 7, "HW000007", "can0", "can0"), resources=place.resources)
    assert tree([(isa, [IDLE, IDLE])])[0] == (
        "HW000007  usb-to-can  USB-to-CAN V2 (simulated)  I/O 280h-29Fh, IRQ 5"
    )
    facts = json.loads(json.dumps(board_facts(isa, [IDLE, IDLE])))
    assert facts["resources"] == [["I/O", "280h-29Fh"], ["IRQ", "5"]]


def test_lin_lines_that_do_little() -> None:
    off = board("usb-to-can-fd", 1, "HW000001", "can0", "can0", "")
    searching = replace(LIN_BUSY.status, mode=LinMode(False, 0), bit_rate=0, monitors=1, errors=(0,) * 9)
    rows = tree([(off, [IDLE, IDLE, LIN_IDLE]), (FD, [IDLE, IDLE, LinUse(searching, "", True)])])
    assert rows[5].split() == [":2", "LIN-1", "-", "not", "initialised"]
    assert rows[6].strip() == "headers 0, sent 0, received 0, errors 0, lost 0; 0 monitors, control free"
    assert "slave, no bit rate yet" in rows[12]
    assert rows[13].endswith("errors 0, lost 3; 1 monitor (exclusive), control free")


@pytest.mark.conforms("N-03")
def test_lines_of_one_bus_at_different_rates_are_marked() -> None:
    other = replace(BUSY, mode=LineMode(BitTiming.for_bit_rate(250_000)), set_by="ACAN (7)", set_by_left=True)
    (found,) = conflicts_among([(FD, [BUSY, other, LIN_IDLE])])
    assert str(found) == (
        "can0: different bit rates on one bus: HW000001:0 at 500000 bit/s, 2000000 after BRS, set by engine (4711); "
        "HW000001:1 at 250000 bit/s, set by ACAN (7), which has left it"
    )
    assert conflicts_among([(FD, [BUSY, IDLE, LIN_IDLE])]) == []


def test_a_line_that_still_looks_for_its_rate() -> None:
    facts = board_facts(FD, [replace(BUSY, mode=LineMode(None)), IDLE, LIN_IDLE])
    assert facts["lines"][0]["status"]["mode"]["timing"] is None
    assert "no bit rate yet" in tree([(FD, [replace(BUSY, mode=LineMode(None)), IDLE, LIN_IDLE])])[1]


@pytest.mark.parametrize("kind", ["CAN", "LIN"])
def test_buses_that_cannot_keep_up_are_told_of_by_lines_of_either_kind(kind: str) -> None:
    late: dict[str, Any] = {"behind_ns": 250_000_000, "skipped_ns": 3_000_000_000}
    can = replace(IDLE, **late) if kind == "CAN" else IDLE
    lin = LIN_IDLE._replace(status=replace(LIN_IDLE.status, **late)) if kind == "LIN" else LIN_IDLE
    assert lateness_among([(FD, [IDLE, IDLE, LIN_IDLE])]) == set()
    (said,) = lateness_among([(FD, [can, IDLE, lin])])
    assert said.startswith("bus time is 0.25 s behind the clock, 3.00 s were left out since the hub began: ")


def test_a_lin_lines_status_has_the_hubs_lateness() -> None:
    with embedded("", time="virtual") as engine, connected(engine) as hub:
        engine.world.lateness = lambda: (5, 7)
        status = hub.lin_status(hub.plug("usb-to-can-fd").id, 2).status
    assert (status.behind_ns, status.skipped_ns, status.lateness) == (5, 7, "")


# with a real hub


@pytest.mark.conforms("X3-01", "X3-02")
def test_boards_come_and_go(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    def run(*words: str) -> str:
        assert main([*words, "--hub", hub_address]) == 0
        captured = capsys.readouterr()
        assert captured.err == ""
        return captured.out

    def ids() -> list[str]:
        return [line.split()[0] for line in run("devices").splitlines() if not line.startswith(" ")]

    assert ids() == [f"HW00000{number}" for number in range(1, 5)]
    plugged = run("plug", "usb-to-can", "--serial", "HW123456", "--bus", "can0", "can0")
    assert plugged == "HW123456  usb-to-can  USB-to-CAN V2 (simulated)  can0 can0\n"
    assert run("plug", "usb-to-can-fd").startswith("HW000005  usb-to-can-fd  ")
    assert ids() == [*(f"HW00000{number}" for number in range(1, 5)), "HW123456", "HW000005"]
    assert run("unplug", "HW123456") == plugged
    for hardware_id in [f"HW00000{number}" for number in range(1, 6)]:
        run("unplug", hardware_id)
    assert run("devices") == "no boards; `canwire plug usb-to-can-fd` plugs one in\n"


def test_who_uses_what(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    with canwire.connect(hub_address, name="owner") as hub:
        board = hub.board("HW000001")
        control = hub.open_control(board.id, 0)
        control.initialise(MODE)
        control.start()
        hub.open_channel(board.id, 0, exclusive=True)
        hub.open_scheduler(board.id, 1)
        lin = hub.open_lin_control(board.id, 2)
        lin.initialise(LinMode(master=True, bit_rate=9_600))
        hub.open_monitor(board.id, 2, exclusive=True).set_up(LinMonitorMode(16))
        assert main(["devices", "--json", "--hub", hub_address]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["hub"], facts["time"]) == (hub_address, "real")
    first, second, third = (line["status"] for line in facts["boards"][0]["lines"])
    me = f"owner ({os.getpid()})"
    assert (first["control_holder"], first["channels"], first["exclusive"]) == (me, 1, True)
    assert (first["state"], first["mode"]["timing"]["bit_rate"]) == ("ERROR_ACTIVE", 500_000)
    assert (second["scheduler_holder"], second["mode"]) == (me, None)
    assert (third["control_holder"], third["monitors"], third["exclusive"]) == (me, 1, True)
    assert (third["state"], third["mode"]["master"], third["bit_rate"]) == ("STOPPED", True, 9_600)


def test_without_a_hub_the_boards_are_this_programs_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    for name in ("CANWIRE_HUB", "CANWIRE_CONFIG"):
        monkeypatch.delenv(name, raising=False)
    assert main(["devices"]) == 0
    captured = capsys.readouterr()
    assert "no hub is running" in captured.err
    assert captured.out.startswith("HW000001  usb-to-can-fd  ")


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (
            ["plug", "usb-to-lin"],
            "no board kind 'usb-to-lin'; there are canbus-dongle, inducan104, ",
        ),
        (["plug", "usb-to-can", "--serial", "17"], "hardware id '17'"),
        (["plug", "usb-to-can", "--serial", "HW000001"], "HW000001 is plugged in already"),
        (["plug", "usb-to-can", "--bus", "can0"], "usb-to-can has 2 lines, not 1"),
        (["plug", "usb-to-can", "--bus", "can0", "can7"], "no bus 'can7' for CAN-2; there are can0"),
        (["unplug", "HW7"], "no board 'HW7'"),
        (["unplug", "usb-to-can"], "no board 'usb-to-can'"),
    ],
)
def test_mistakes_are_one_line(
    hub_address: str, capsys: pytest.CaptureFixture[str], words: list[str], why: str
) -> None:
    assert main([*words, "--hub", hub_address]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("canwire: ")
    assert (captured.out, captured.err.count("\n")) == ("", 1)
    assert why in captured.err


@pytest.mark.parametrize("verb", ["devices", "dump"])
def test_an_address_where_nobody_listens(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: str
) -> None:
    words = [verb] if verb == "devices" else [verb, "can0"]
    assert main([*words, "--hub", str(tmp_path / "nobody")]) == 2
    assert str(tmp_path / "nobody") in capsys.readouterr().err
