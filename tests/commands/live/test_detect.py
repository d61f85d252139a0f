"""`canwire detect`: it finds the rate of a bus at work, sends nothing, and leaves a line as it was."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import pytest

import canwire
from canwire import (
    BadTiming,
    ChannelMode,
    Control,
    Frame,
    Hub,
    InUse,
    LinePlace,
    NothingHeard,
    Unsupported,
    WantedMode,
)
from canwire.commands import main
from canwire.commands.can_line import bring_up, line_mode
from canwire.commands.live.detect import RATES, candidates_of, detected
from canwire.commands.shared_hub import find_line


class Busy:
    """Two lines that talk to each other on can0, one frame every 10 ms, in virtual time."""

    def __init__(self, hub: Hub, closing: ExitStack) -> None:
        self.hub = hub
        self._closing = closing

    def talk(self, bit_rate: int, frame: Frame, data_bit_rate: int | None = None) -> None:
        for address in ("HW000001:0", "HW000001:1"):
            place = find_line(self.hub, address)
            channel = self._closing.enter_context(self.hub.open_channel(place.board.id, place.line))
            channel.set_up(ChannelMode(receive=1, transmit=1))
            bring_up(self.hub, place, WantedMode(bit_rate, data_bit_rate))
            channel.activate()
        scheduler = self._closing.enter_context(self.hub.open_scheduler(place.board.id, place.line))
        ticks = place.info.capabilities.cyclic
        scheduler.resume()
        record = canwire.frames_to_array([frame]).tobytes()
        entry = scheduler.add(record, max(1, round(0.01 * ticks.clock_hz / ticks.divisor)))
        scheduler.start(entry)

    @property
    def sent_by_others(self) -> int:
        return sum(find_line(self.hub, name).status(self.hub).errors for name in ("HW000001:0", "HW000001:1"))


@pytest.fixture
def busy() -> Iterator[Busy]:
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        yield Busy(hub, closing)


@pytest.fixture(params=["the hub's listener", "the line itself"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Adapters whose bus is not simulated have to listen themselves, which simulated lines can as well."""
    if request.param == "the line itself":

        def refuse(*_: Any, **__: Any) -> int:
            raise Unsupported("there is no CAN bus to listen to")

        monkeypatch.setattr(Control, "detect", refuse)
    return str(request.param)


@pytest.mark.conforms("PL-20")
@pytest.mark.parametrize("bit_rate", [5_000, 125_000, 250_000, 500_000, 1_000_000])
@pytest.mark.parametrize("address", ["HW000002:0", "HW000003:0", "HW000004:0"])
def test_it_finds_the_rate_and_disturbs_nobody(busy: Busy, way: str, address: str, bit_rate: int) -> None:
    busy.talk(bit_rate, Frame(0x123, b"\x11\x22\x33"))
    place = find_line(busy.hub, address)
    before = place.status(busy.hub)
    found = detected(busy.hub, place, [], 0.5)
    assert (found.nominal.bit_rate, found.data) == (bit_rate, None)
    after = place.status(busy.hub)
    assert (after.initialised, after.running, after.channels) == (before.initialised, False, 0)
    assert busy.sent_by_others == 0


@pytest.mark.conforms("PL-20")
@pytest.mark.parametrize("data_bit_rate", [2_000_000, 5_000_000])
def test_data_rates(busy: Busy, way: str, data_bit_rate: int) -> None:
    busy.talk(500_000, Frame(1, bytes(12), fd=True, bit_rate_switch=True), data_bit_rate)
    busy.hub.plug("usb-to-can-fd", "HW000009")
    found = detected(busy.hub, find_line(busy.hub, "HW000009:0"), [], 0.5)
    assert found.nominal.bit_rate == 500_000
    assert (found.data and found.data.bit_rate) == (None if data_bit_rate == 2_000_000 else data_bit_rate)


def test_a_rate_that_is_not_usual(busy: Busy, way: str) -> None:
    busy.talk(83_333, Frame(0x123, bytes(4)))
    place = find_line(busy.hub, "HW000002:0")
    with pytest.raises(NothingHeard):
        detected(busy.hub, place, [], 0.1)
    assert detected(busy.hub, place, [83_333], 0.1).nominal.bit_rate == 83_333


def test_silence(busy: Busy, way: str) -> None:
    place = find_line(busy.hub, "HW000002:0")
    with pytest.raises(NothingHeard, match="500000, 250000"):
        detected(busy.hub, place, [], 0.1)
    assert not place.status(busy.hub).initialised


def test_a_line_that_runs_does_so_again(busy: Busy, way: str) -> None:
    busy.talk(250_000, Frame(0x123, bytes(4)))
    place = find_line(busy.hub, "HW000002:0")
    mode = replace(line_mode(place.info.capabilities, WantedMode(125_000)), listen_only=True, persistent=True)
    with busy.hub.open_control(place.board.id, place.line) as control:
        control.initialise(mode)
        control.start()
    assert detected(busy.hub, place, [], 0.5).nominal.bit_rate == 250_000
    status = place.status(busy.hub)
    assert (status.running, status.mode) == (True, mode)


def test_a_line_that_others_use_is_left_alone(busy: Busy) -> None:
    busy.talk(250_000, Frame(0x123))
    with pytest.raises(InUse, match="HW000001:0 runs, and 1 channels use it"):
        detected(busy.hub, find_line(busy.hub, "HW000001:0"), [], 0.5)


def test_candidates() -> None:
    with canwire.connect(time="virtual") as hub:
        classic, fd = (find_line(hub, name).info.capabilities for name in ("HW000002:0", "HW000001:0"))
    assert [one.nominal.bit_rate for one in candidates_of(classic, list(RATES))] == list(RATES)
    told = [one.told for one in candidates_of(fd, [500_000])]
    assert told == [False, True, True, True, True]
    with pytest.raises(BadTiming, match="none of the rates 7 can be made"):
        candidates_of(classic, [7])


@pytest.mark.smoke
def test_the_verb(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["detect", "HW000002:0", "--timeout", "0.005", "--hub", hub_address]
    assert main(words) == 1
    assert "HW000002:0 on can0: " in capsys.readouterr().err
    with canwire.connect(hub_address) as hub, ExitStack() as closing:
        for address in ("HW000001:0", "HW000001:1"):
            place: LinePlace = find_line(hub, address)
            channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
            channel.set_up(ChannelMode(receive=1, transmit=1024))
            bring_up(hub, place, WantedMode(125_000))
            channel.activate()
        for _ in range(800):
            channel.send(Frame(1, bytes(8)), timeout=1)  # a second of them
        assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["line"], found["bit_rate"], found["data_bit_rate"]) == ("HW000002:0", 125_000, None)
    assert main(["detect", "can0", "--timeout", "0", "--hub", hub_address]) == 2
    assert "--timeout 0.0: more than 0 seconds" in capsys.readouterr().err
