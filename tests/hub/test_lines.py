"""Finding a line by name and bringing it up, as every program may: rates, who started it, who may go on."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from canwire import (
    BadTiming,
    BadValue,
    BitTiming,
    Hub,
    InUse,
    LineError,
    LineMode,
    LinePlace,
    LineStatus,
    NoSuchBoard,
    WantedMode,
    bring_up,
    connect,
    every_line,
    find_lines,
    format_rates,
    start_line,
)

WANTED = WantedMode(250_000)
CONFIG = """
[[bus]]
name = "can0"
[[bus]]
name = "can1"
[[bus]]
name = "lin0"
type = "lin"
[[board]]
kind = "usb-to-can-fd"
buses = ["can0", "can0", "lin0"]
[[board]]
kind = "usb-to-can"
buses = ["can1", "can0"]
"""


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[Hub]:
    path = tmp_path / "canwire.toml"
    path.write_text(CONFIG)
    with connect(time="virtual", config=path) as hub:
        yield hub


@pytest.fixture
def place(hub: Hub) -> LinePlace:
    return find_lines(hub, "usb-to-can-fd:0")[0]


def as_wanted(place: LinePlace) -> LineMode:
    return WANTED.mode(place.info.capabilities)


def as_it_is(status: LineStatus) -> None:
    return None


def anything(status: LineStatus) -> None:
    """Every running line suits."""


def nothing(status: LineStatus) -> None:
    raise BadValue(f"it runs at {format_rates(status.mode)}")


def lines(places: list[LinePlace]) -> list[tuple[str, int]]:
    return [(place.board.kind, place.line) for place in places]


def test_a_bus_means_every_line_on_it(hub: Hub) -> None:
    on_bus = [("usb-to-can-fd", 0), ("usb-to-can-fd", 1), ("usb-to-can", 1)]
    assert lines(find_lines(hub, "can0")) == on_bus
    assert lines(find_lines(hub, "can0", "CAN")) == on_bus
    assert lines(find_lines(hub, "lin0")) == [("usb-to-can-fd", 2)]
    assert lines(every_line(hub, "LIN")) == [("usb-to-can-fd", 2)]
    assert len(every_line(hub)) == 5


def test_an_address_means_one_line(hub: Hub) -> None:
    for place in every_line(hub):
        assert find_lines(hub, place.address) == [place]
        assert find_lines(hub, f"{place.board.kind}:{place.line}", place.info.bus_type) == [place]


@pytest.mark.parametrize(
    ("name", "bus_type", "why"),
    [
        ("can7", None, r"no line or bus 'can7'; there are HW\d+:0 \(on can0\)"),
        ("", None, "no line or bus ''"),
        ("lin0", "CAN", "no CAN line or bus 'lin0'"),
        ("usb-to-can-fd:2", "CAN", "no CAN line or bus 'usb-to-can-fd:2'"),
        ("usb-to-can-fd:3", "CAN", r"usb-to-can-fd:3: HW\d+ has the lines 0 to 2"),
        ("usb-to-flow:0", None, "usb-to-flow"),
    ],
)
def test_names_of_nothing(hub: Hub, name: str, bus_type: str | None, why: str) -> None:
    with pytest.raises(NoSuchBoard, match=why):
        find_lines(hub, name, bus_type)


def test_a_line_that_does_not_run_is_set_up_and_held(hub: Hub, place: LinePlace) -> None:
    control = bring_up(hub, place, lambda status: as_wanted(place), nothing)
    status = place.status(hub)
    assert control is not None
    assert status.running
    assert status.control_holder
    assert format_rates(status.mode) == "250000 bit/s, 2000000 after BRS"
    with pytest.raises(InUse):
        start_line(hub, place, None)
    control.close()
    assert not place.status(hub).control_holder


@pytest.mark.conforms("N-01")
def test_joining_a_running_line_takes_nothing(hub: Hub, place: LinePlace) -> None:
    with hub.open_channel(place.board.id, place.line):
        start_line(hub, place, as_wanted(place)).close()
        assert bring_up(hub, place, as_it_is, anything) is None
        assert not place.status(hub).control_holder


def test_a_running_line_that_does_not_suit_is_left_alone(hub: Hub, place: LinePlace) -> None:
    with hub.open_channel(place.board.id, place.line):
        start_line(hub, place, as_wanted(place)).close()
        with pytest.raises(BadValue, match="it runs at 250000 bit/s, 2000000 after BRS"):
            bring_up(hub, place, lambda status: as_wanted(place), nothing)
        assert not place.status(hub).control_holder


@pytest.mark.conforms("N-01")
@pytest.mark.parametrize("runs", [True, False])
def test_a_line_that_was_unused_is_left_to_who_uses_it_by_now(hub: Hub, place: LinePlace, runs: bool) -> None:
    with hub.open_channel(place.board.id, place.line):
        if runs:
            start_line(hub, place, as_wanted(place)).close()
        with pytest.raises(InUse, match=f"{place.address}: another program has begun to use this line"):
            start_line(hub, place, as_wanted(place), unused=True)
        assert place.status(hub).running == runs
        assert not place.status(hub).control_holder
    with start_line(hub, place, as_wanted(place), unused=True):
        assert place.status(hub).running


def test_what_cannot_be_set_up_is_not_held(hub: Hub, place: LinePlace) -> None:
    impossible = replace(as_wanted(place), standard=False, extended=False)
    for begin in (
        lambda: bring_up(hub, place, lambda status: impossible, nothing),
        lambda: start_line(hub, place, impossible),
    ):
        with pytest.raises(LineError, match="allow 11-bit frames"):
            begin()
        assert not place.status(hub).control_holder


def test_whoever_has_the_control_is_waited_for(hub: Hub, place: LinePlace) -> None:
    with hub.open_control(place.board.id, place.line) as control:
        with pytest.raises(InUse, match="control"):
            bring_up(hub, place, as_it_is, anything, patience_s=0.05)
        control.initialise(as_wanted(place))
        seen: list[LineStatus] = []
        starter = threading.Thread(target=control.start)
        starter.start()
        assert bring_up(hub, place, as_it_is, seen.append, patience_s=30.0) is None
        starter.join()
        assert seen[0].running


@pytest.mark.conforms("N-01")
def test_every_program_waits_for_one_that_is_just_starting_the_line(
    hub: Hub, place: LinePlace, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever begins at the same moment, and says nothing of patience: `canwire up`, the page, a Bus."""
    with hub.open_control(place.board.id, place.line) as control:
        control.initialise(as_wanted(place))
        begun_ns = hub.now_ns()
        with pytest.raises(InUse, match="control"):
            bring_up(hub, place, as_it_is, anything)
        assert hub.now_ns() - begun_ns == pytest.approx(2_000_000_000, abs=20_000_000)
        sleep = hub.sleep

        def while_it_starts(seconds: float) -> None:
            sleep(seconds)
            control.start()

        monkeypatch.setattr(hub, "sleep", while_it_starts)
        assert bring_up(hub, place, as_it_is, anything) is None


def test_what_is_left_open_is_usual(hub: Hub) -> None:
    fd, classic = (find_lines(hub, f"{kind}:0")[0] for kind in ("usb-to-can-fd", "usb-to-can"))
    assert format_rates(WantedMode().mode(fd.info.capabilities)) == "500000 bit/s, 2000000 after BRS"
    assert format_rates(WantedMode().mode(classic.info.capabilities)) == "500000 bit/s"
    searching = WantedMode(find_rate=True).mode(classic.info.capabilities)
    assert (searching.timing, format_rates(searching)) == (None, "no bit rate yet")


def test_rates_left_open_are_those_of_others(place: LinePlace) -> None:
    mode = as_wanted(place)
    assert WantedMode().at_rates_of(mode) == WantedMode(250_000, 2_000_000)
    assert WantedMode(500_000, 4_000_000).at_rates_of(mode) == WantedMode(500_000, 4_000_000)
    assert WantedMode().at_rates_of(None) == WantedMode()


@pytest.mark.parametrize(
    ("wanted", "agrees"),
    [
        (WantedMode(), True),
        (WantedMode(250_000, 2_000_000), True),
        (WantedMode(500_000), False),
        (WantedMode(None, 4_000_000), False),
        (WantedMode(timing=BitTiming.for_bit_rate(250_000, clock_hz=8_000_000)), True),
        (WantedMode(250_000, timing=BitTiming.for_bit_rate(500_000)), False),
    ],
)
def test_agreement(place: LinePlace, wanted: WantedMode, agrees: bool) -> None:
    mode = as_wanted(place)
    assert wanted.rates_agree(mode) is agrees
    assert not wanted.rates_agree(None)
    assert not wanted.rates_agree(replace(mode, timing=None, data_timing=None))


def test_a_timing_is_taken_to_the_clock_of_the_line() -> None:
    asked = WantedMode(timing=BitTiming(4, 6, 1, 1, clock_hz=16_000_000))
    taken = asked.at_clock(80_000_000).timing
    assert taken is not None
    assert (taken.prescaler, taken.tseg1, taken.tseg2, taken.bit_rate) == (20, 6, 1, 500_000)
    with pytest.raises(BadTiming, match="the clock of this line is 18000000 Hz"):
        asked.at_clock(18_000_000)


def test_a_classic_line_has_no_data_timing(hub: Hub) -> None:
    classic = find_lines(hub, "usb-to-can:0")[0].info.capabilities
    with pytest.raises(BadTiming, match="2000000 bit/s for data: this line knows classic CAN only"):
        classic.data_timing(2_000_000)
