"""`canwire demo`: the story runs as told, and its nodes see what the CANDRV manual says they see."""

from __future__ import annotations

import json
from typing import Any

import pytest

from canwire import Frame, Lab, LogLine, parse_candump_line
from canwire.commands import main
from canwire.commands.demo import meaning
from canwire.commands.lab.fan_network import CodedIds, Coding, Controller, Fan, Machine, PlainIds, Sensor

PLAIN, CODED = PlainIds(), CodedIds()
BIT_NS = 8000


def story(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    assert main(["demo", "--json", *words]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def trace(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    assert main(["demo", *words]) == 0
    return capsys.readouterr().out.splitlines()


def frames_in(lines: list[str]) -> list[LogLine]:
    return [parse_candump_line(line.split(";")[0].rstrip()) for line in lines if "; " in line]


@pytest.mark.conforms("G-11")
@pytest.mark.parametrize("words", [[], ["--coded-ids"]])
def test_fan_2_fails_and_comes_back(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    told = {entry["what"]: entry["time_ns"] for entry in story(capsys, *words)["story"]}
    assert list(told) == [
        "the transceiver of fan 2 breaks: fan 2 reads its own frames wrong",
        "fan 2 is ERROR_WARNING, TEC 96, REC 0",
        "fan 2 is ERROR_PASSIVE, TEC 128, REC 0",
        "fan 2 is BUS_OFF, TEC 256, REC 0",
        "controller: fan 2 is silent",
        "fan 2 is repaired and restarted: it waits for 128 times 11 recessive bits",
        "fan 2 is ERROR_ACTIVE, TEC 0, REC 0",
        "controller: fan 2 is back",
    ]
    times_ns = list(told.values())
    assert times_ns == sorted(times_ns)
    recovery_ns = times_ns[6] - times_ns[5]
    # at that moment fan 1 begins to report: 56 bits, whose last 8 (ACK delimiter, EOF) are recessive
    assert recovery_ns == (56 - 8 + 128 * 11) * BIT_NS


def test_trace_reads_back_as_candump(capsys: pytest.CaptureFixture[str]) -> None:
    lines = trace(capsys)
    frames = frames_in(lines)
    assert len(frames) == 100
    assert lines[lines.index("") + 1] == "frames        100"
    stamps = [line.timestamp_ns for line in frames]
    assert stamps == sorted(stamps)
    assert lines[0] == " (0000000000.100520)  can0  100   [2]  01 46        ; sensor 1: 70 degrees"


def test_bus_off_is_silence_and_nobody_else_suffers(capsys: pytest.CaptureFixture[str]) -> None:
    during = [line for line in frames_in(trace(capsys)) if 12 <= line.timestamp_ns // 10**9 < 20]
    ids = [line.content.id for line in during if isinstance(line.content, Frame)]
    assert 0x302 not in ids
    assert ids.count(0x301) == 5  # every two seconds, and once more when it is switched on
    assert ids.count(0x100) == 16


def test_everything_is_cooled(capsys: pytest.CaptureFixture[str]) -> None:
    hottest = {1: 0, 2: 0}
    for line in frames_in(trace(capsys, "--seconds", "60")):
        reading = PLAIN.read_temperature(line.content) if isinstance(line.content, Frame) else None
        if reading is not None:
            hottest[reading[0]] = max(hottest[reading[0]], reading[1])
    assert hottest[1] < 85
    assert 85 < hottest[2] < 95  # its fan was away for eight seconds


@pytest.mark.conforms("G-17")
def test_twice_gives_the_same_trace(capsys: pytest.CaptureFixture[str]) -> None:
    first, second = (
        [line for line in trace(capsys, "--seconds", "25") if not line.startswith(("wall time", "speed"))]
        for _ in range(2)
    )
    assert first == second


def test_summary(capsys: pytest.CaptureFixture[str]) -> None:
    found = story(capsys, "--seconds", "10")
    assert (found["frames"], found["lost"], found["error_frames"], found["bus_time_s"]) == (30, 0, 0, 10.0)
    assert found["story"] == []
    assert found["bus_load"] > 0


@pytest.mark.conforms("FS-12")
@pytest.mark.parametrize("fan", [1, 2])
def test_a_fan_sees_commands_for_itself_only(fan: int) -> None:
    seen = PLAIN.switches(fan)
    for id in range(0x800):
        for number in range(5):
            assert seen.accepts(Frame(id, bytes([number, 1]))) == (id == 0x200 and number == fan)
    assert not seen.accepts(Frame(0x200))
    assert not seen.accepts(Frame(0x200, bytes([fan, 1]), extended=True))


@pytest.mark.conforms("FS-12")
def test_coded_identifiers_are_the_manuals() -> None:
    assert CODED.temperature(2, 0x50) == Frame(0b1_10_01010000)
    assert CODED.switch(1, False) == Frame(0b011_11111_01_0)
    every = range(0x800)
    sensors, fan_1 = CODED.temperatures(), CODED.switches(1)
    assert [id for id in every if sensors.accepts(Frame(id))] == list(range(0x400, 0x800))
    assert [id for id in every if fan_1.accepts(Frame(id))] == [0b011_11111_01_0, 0b011_11111_01_1]
    other_device = Frame(0b001_00101_100)
    assert CODED.read_temperature(other_device) is CODED.read_switch(other_device) is None


@pytest.mark.conforms("FS-12")
@pytest.mark.conforms("PL-26")
@pytest.mark.parametrize("coding", [PLAIN, CODED], ids=["plain", "coded"])
def test_on_the_bus_each_node_accepts_its_own(coding: Coding) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=125_000)
        machine = Machine()
        bus.node("controller", Controller(coding, (1,), lambda what: None), filters=coding.temperatures())
        fan = bus.node("fan 1", Fan(machine, coding, 1, lambda what: None), filters=coding.switches(1))
        bus.node("sensor 1", Sensor(machine, coding, 1), filters=[])
        stranger = bus.node("stranger")
        stranger.send_many([coding.switch(2, True), coding.switch(1, True), coding.switch(3, False)])
        lab.run_for(0.05)
        assert (fan.accepted, fan.sent) == (1, 1)  # it took one command of three, and answered
        answer = stranger.receive()
        assert answer is not None
        assert meaning(coding, answer) == "fan 1: turning"
        lab.run_for(0.1)
        report = stranger.receive()
        assert report is not None
        assert meaning(coding, report) == "sensor 1: 69 degrees"  # turning for a tenth of a second


@pytest.mark.realtime
def test_real_time(capsys: pytest.CaptureFixture[str]) -> None:
    found = story(capsys, "--seconds", "0.5", "--time", "real")
    assert found["frames"] == 2  # one of each sensor
    assert found["wall_time_s"] >= 0.5


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "inf"])
def test_seconds_must_pass(capsys: pytest.CaptureFixture[str], seconds: str) -> None:
    assert main(["demo", "--seconds", seconds]) == 2
    assert "--seconds" in capsys.readouterr().err
