"""The two LEDs. Source: CANBUS manual, 1.2 and the F command's page."""

from __future__ import annotations

from itertools import pairwise

import pytest

from canwire import BusEvent, ErrorState, EventKind, Frame
from canwire.slcan import Leds, Red, Settings
from tests.slcan.bench import Bench

MS = 1_000_000


@pytest.mark.conforms("CT-19")
def test_both_blink_three_times_a_second_after_power_up() -> None:
    leds = Leds(0)
    lit = [leds.red_lit(ms * MS) for ms in range(0, 3000, 10)]
    assert lit == [leds.green_lit(ms * MS) for ms in range(0, 3000, 10)]
    assert sum(now and not before for before, now in pairwise(lit)) == 3
    assert lit.index(True) == 100
    assert [event.led for event in leds.events] == ["both"] * 3


@pytest.mark.conforms("CT-19")
def test_green_flashes_for_each_frame(opened: Bench) -> None:
    leds = opened.dongle.leds
    at = opened.now_ns + 5_000 * MS
    opened.receive(Frame(1, timestamp_ns=at))
    assert leds.green_lit(at + MS)
    assert not leds.green_lit(at + 50 * MS)
    opened.ask(b"t1000\r")
    opened.can.frames.append(Frame(1, self_received=True, timestamp_ns=at + 100 * MS))
    opened.dongle.pump()
    assert leds.green_lit(at + 101 * MS)
    assert leds.frames == 2


@pytest.mark.conforms("CT-19", "CT-10", "N-13")
def test_red_tells_of_errors(opened: Bench) -> None:
    leds = opened.dongle.leds
    opened.now_ns += 5_000 * MS
    opened.happen(BusEvent(EventKind.ARBITRATION_LOST))
    assert leds.red is Red.OFF
    opened.happen(BusEvent(EventKind.STATE, state=ErrorState.ERROR_WARNING))
    assert leds.red is Red.BLINKING
    assert {leds.red_lit(opened.now_ns + ms * MS) for ms in range(0, 1000, 50)} == {False, True}
    opened.happen(BusEvent(EventKind.ERROR))
    assert leds.red is Red.CONSTANT
    assert all(leds.red_lit(opened.now_ns + ms * MS) for ms in range(0, 1000, 50))
    assert opened.ask(b"F\r") == b"FC4\r"
    assert leds.red is Red.OFF
    assert not leds.red_lit(opened.now_ns)
    assert [event.what for event in leds.events] == ["blink"] * 3 + ["blinking", "constant", "off"]


@pytest.mark.conforms("CT-19")
def test_a_lost_frame_makes_it_blink() -> None:
    bench = Bench(Settings(output_size=1024))
    bench.ask(b"S4\rO\r")
    bench.receive(*[Frame(1)] * 33)
    assert bench.dongle.leds.red is Red.BLINKING
