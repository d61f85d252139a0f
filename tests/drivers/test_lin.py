"""What a LIN driver sets in its controller."""

from __future__ import annotations

from typing import Any

from canwire.drivers.lin import LinControllerDriver
from canwire.drivers.lin_driver import LinSettings
from canwire.values.lin.timing import LOWEST_RATE, bit_time_ps
from tests.cases import each


class Controller:
    """One that keeps what is set."""

    def configure(self, bit_ps: int, **others: Any) -> None:
        self.bit_ps, self.searching = bit_ps, others["searching"]


@each(
    ("settings", "rate", "searches"),
    [
        (LinSettings(master=True, bit_rate=19_200), 19_200, False),
        (LinSettings(master=False, bit_rate=9_600), 9_600, False),
        (LinSettings(master=False, bit_rate=0), LOWEST_RATE, True),  # until it has found the rate
    ],
)
def test_bit_rate(settings: LinSettings, rate: int, searches: bool) -> None:
    controller = Controller()
    LinControllerDriver(controller).configure(settings)  # type: ignore[arg-type]
    assert (controller.bit_ps, controller.searching) == (bit_time_ps(rate, 0.0), searches)
