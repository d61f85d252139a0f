"""The ideal CAN FD controller starts and stops."""

from __future__ import annotations

import pytest

from canwire import BitTiming, ErrorState
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
