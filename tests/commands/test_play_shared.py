"""`canwire play LOG LINE` and `canwire stop`: onto lines that programs share."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

import canwire
from canwire import BitTiming, ChannelMode, Frame, Hub, HubChannel, LineMode, find_lines
from canwire.commands import main
from tests.hubs import LONG_S, Served, serving

LOG = "(1.000000) can0 123#1122\n(1.010000) can0 7FF#R\n(1.020000) can0 12345678#33\n"
FRAMES = [(0x123, b"\x11\x22"), (0x7FF, b""), (0x12345678, b"\x33")]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving(tmp_path_factory.mktemp("hub")) as found:
        yield found


@pytest.fixture
def listener(served: Served) -> Iterator[HubChannel]:
    """Another program's channel, on another controller of can0."""
    with ExitStack() as closing:
        hub = closing.enter_context(canwire.connect(served.address, name="listener"))
        board, line = first_line(hub)
        channel = closing.enter_context(hub.open_channel(board, line))
        control = closing.enter_context(hub.open_control(board, line))
        control.initialise(LineMode(BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)))
        channel.set_up(ChannelMode(receive=1000, transmit=0))
        control.start()
        channel.activate()
        yield channel


def first_line(hub: Hub) -> tuple[int, int]:
    place = find_lines(hub, "can0")[0]
    return place.board.id, place.line


def log_of(folder: Path, text: str) -> str:
    path = folder / "in.log"
    path.write_text(text)
    return str(path)


def heard(channel: HubChannel, count: int) -> list[Frame]:
    found: list[Frame] = []
    while len(found) < count:
        more = channel.receive_many(count, LONG_S)
        assert more
        found += more
    return found


@pytest.mark.conforms("PC-06")
def test_long_pauses_are_left_out(
    served: Served, listener: HubChannel, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A log of two days would otherwise last for two days; -v shows what goes out."""
    pauses = LOG.replace("1.01", "90000.01").replace("1.02", "180000.02")
    words = ["play", log_of(tmp_path, pauses), "can0", "-s", "0.5", "-v", "--hub", served.address]
    assert main([*words, "--timeout", str(LONG_S)]) == 0
    assert [(frame.id, frame.data) for frame in heard(listener, 3)] == FRAMES
    lines = capsys.readouterr().out.splitlines()
    assert lines[:3] == ["can0 123#1122", "can0 7FF#R", "can0 12345678#33"]
    assert main([*words, "-s", "-1"]) == 2
    assert "--skip -1.0: 0 or more" in capsys.readouterr().err
    assert main([*words[:2], "-s", "1"]) == 2
    assert "--skip: that is for a shared line" in capsys.readouterr().err


@pytest.mark.parametrize("speed", ["1", "0"])
def test_others_on_the_bus_hear_the_log(
    served: Served, listener: HubChannel, tmp_path: Path, capsys: pytest.CaptureFixture[str], speed: str
) -> None:
    words = [
        "play",
        log_of(tmp_path, LOG),
        "can0",
        "--hub",
        served.address,
        "--speed",
        speed,
        "--timeout",
        "30",
    ]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["delivered"] == 3
    assert [(frame.id, frame.data) for frame in heard(listener, 3)] == FRAMES


def test_frames_that_nobody_acknowledges_are_told(
    served: Served, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        "play",
        log_of(tmp_path, LOG),
        "can0",
        "--hub",
        served.address,
        "--speed",
        "0",
        "--timeout",
        "0.2",
    ]
    assert main(words) == 1
    captured = capsys.readouterr()
    assert captured.out == "0 of 3 frames delivered\n"
    assert "3 of 3 frames not delivered: nobody acknowledges" in captured.err


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["can0", "--vcd", "x.vcd"], "--vcd: that is for a private bus"),
        (["can0", "--bus", "can1"], "--bus: that is for a private bus"),
        (["--speed", "2"], "--speed: that is for a shared line"),
        (["can0", "--speed", "-1"], "--speed -1.0: 0 or more"),
    ],
)
def test_options_of_the_other_kind_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], why: str
) -> None:
    assert main(["play", log_of(tmp_path, LOG), *words]) == 2
    assert why in capsys.readouterr().err


def test_without_a_hub_it_says_how_to_start_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert main(["play", log_of(tmp_path, LOG), "can0"]) == 2
    assert "`canwire serve` starts one" in capsys.readouterr().err


def test_stop_takes_every_line_of_a_bus_off_it(served: Served, capsys: pytest.CaptureFixture[str]) -> None:
    with ExitStack() as closing:
        hub = closing.enter_context(canwire.connect(served.address, name="tester"))
        board, line = first_line(hub)
        closing.enter_context(hub.open_channel(board, line))
        with hub.open_control(board, line) as control:
            control.initialise(LineMode(BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)))
            control.start()
        assert hub.line_status(board, line).running
        assert main(["stop", "can0", "--hub", served.address]) == 0
        assert not hub.line_status(board, line).running
    assert ":0 stopped" in capsys.readouterr().out


def test_a_line_that_is_up_goes_on_until_it_is_stopped(
    served: Served, capsys: pytest.CaptureFixture[str]
) -> None:
    with canwire.connect(served.address, name="tester") as hub:
        place = find_lines(hub, "can0")[0]
        assert main(["up", place.address, "--hub", served.address, "--bit-rate", "250000"]) == 0
        assert f"{place.address} on can0: 250000 bit/s" in capsys.readouterr().out
        assert place.status(hub).running
        assert main(["up", place.address, "--hub", served.address]) == 2
        assert "runs already at 250000 bit/s" in capsys.readouterr().err
        assert place.status(hub).running
        assert main(["stop", place.address, "--reset", "--hub", served.address]) == 0
        assert not place.status(hub).initialised
