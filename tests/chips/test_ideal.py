"""The ideal CAN FD controller starts, stops, and gives up what waits in it."""

from __future__ import annotations

import pytest

from canwire import BitTiming, ErrorState, Frame
from canwire.boards.can.channel import Channel
from canwire.boards.catalogue import ideal_line, plug
from canwire.bus.can.bus import CanBus
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline

pytestmark = pytest.mark.core


def test_a_stopped_controller_is_off_the_bus_and_says_so() -> None:
    timeline = Timeline()
    line = ideal_line("line", timeline)
    plug(line, CanBus(timeline))
    assert line.driver is not None
    line.driver.configure(LineSettings(BitTiming.for_bit_rate(500_000, clock_hz=80_000_000), None))
    controller = line.controller
    line.driver.start(0, integrated=True)
    assert (controller.running, controller.on_bus, controller.state()) == (
        True,
        True,
        ErrorState.ERROR_ACTIVE,
    )
    line.driver.stop(0)
    assert (controller.running, controller.on_bus, controller.state()) == (False, False, ErrorState.STOPPED)
    line.driver.start(0, integrated=True)
    assert (controller.running, controller.on_bus, controller.state()) == (
        True,
        True,
        ErrorState.ERROR_ACTIVE,
    )


def test_a_frame_that_waits_is_given_up_once() -> None:
    timeline = Timeline()
    line = ideal_line("line", timeline)
    plug(line, CanBus(timeline))
    line.driver.configure(LineSettings(BitTiming.for_bit_rate(500_000, clock_hz=80_000_000), None))
    line.driver.start(0, integrated=True)
    controller = line.controller
    line.send(line.open(Channel(16, 16)), Frame(1))
    assert (controller.normal.occupied, controller.offer is controller.normal) == (True, True)
    assert controller.abort(controller.normal, 0)
    assert (controller.normal.occupied, controller.offer) == (False, None)
    assert not controller.abort(controller.normal, 0)
