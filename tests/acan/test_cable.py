"""What a cable's hardware delays, whatever ACAN programs. Source: docs/porting-acan.md, "length of the cable"."""

from __future__ import annotations

import pytest

from canwire.acan.driver import open_driver
from canwire.acan.hard_config import HardConfig
from canwire.bus.can.bus import CanBus
from tests.acan.conftest import CONFIG
from tests.hubs import connected, embedded


def delays(cable: str, *rates_kbps: int) -> set[int]:
    """The bus's delay before and after ACAN has programmed these rates."""
    config = CONFIG.replace('name = "can0"', f'name = "can0"\n{cable}', 1)
    with embedded(config, time="virtual") as engine, connected(engine) as hub, open_driver(hub) as driver:
        bus = engine.world.buses["can0"]
        assert isinstance(bus, CanBus)
        found = {bus.delay_ps}
        for rate in rates_kbps:
            driver.configure(HardConfig(rate_kbps=rate))
            driver.bus_on()
            found.add(bus.delay_ps)
        return found


@pytest.mark.finding("acan A14")
def test_a_cables_delay_is_that_of_the_bus_s_rate_and_length() -> None:
    [quick] = delays("length_m = 10\nbit_rate = 1_000_000", 125, 500)
    [slow] = delays("length_m = 10\nbit_rate = 125_000", 500, 125)
    [coupled] = delays("length_m = 10\nbit_rate = 1_000_000\nnode_delay_ns = 75", 125)
    assert 0 < quick < slow
    assert quick < coupled
