"""What is known beforehand of an adapter that python-can drives."""

from __future__ import annotations

from canwire.boards.description import NO_CAN, Feature, Ticks
from canwire.boards.figures import ADAPTER, FD_ADAPTER
from canwire.boards.outside import capabilities_of
from tests.cases import each


@each(
    ("interface", "fd", "listens"),
    [("pcan", True, True), ("socketcan", True, False), ("cantact", False, True), ("serial", False, False)],
)
def test_capabilities_are_those_of_the_interface(interface: str, fd: bool, listens: bool) -> None:
    found = capabilities_of(f"{interface}/channel")
    assert found.can(Feature.LISTEN_ONLY) is listens
    assert (found.data is not None) is fd
    assert (
        found.features & ~Feature.LISTEN_ONLY
        == (FD_ADAPTER if fd else ADAPTER).features & ~Feature.LISTEN_ONLY
    )


def test_a_line_that_is_no_can_line_can_do_nothing() -> None:
    assert (NO_CAN.controller_type, NO_CAN.bus_coupling, NO_CAN.features, NO_CAN.clock_hz) == (0, 0, 0, 0)
    limits = (NO_CAN.nominal.prescaler, NO_CAN.nominal.tseg1, NO_CAN.nominal.tseg2, NO_CAN.nominal.sjw)
    assert limits == ((0, 0),) * 4
    assert NO_CAN.data is None
    assert (NO_CAN.stamps, NO_CAN.cyclic, NO_CAN.delay) == (Ticks(), Ticks(), Ticks())
    assert (Ticks().clock_hz, Ticks().divisor, Ticks().maximum, Ticks().tick_ns) == (0, 0, 0, 0)
