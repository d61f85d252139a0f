"""What a hub has to say about its copper (INduCAN104 manual, "Network topology and medium")."""

from __future__ import annotations

import pytest

from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig
from canwire.boards.wiring import config_warnings, warnings
from canwire.bus.medium import effective_length_m, longest_m, one_way_delay_ps
from canwire.values.timing.bit_timing import BitTiming
from tests.cases import each

COUPLER_DELAY_NS = 75.0
"""One 6N137 of the opto-isolated form, of which a level passes one on its way out, and one on its way in."""
TABLE = [(1_000_000, 25), (800_000, 50), (500_000, 100), (250_000, 250), (125_000, 500)]


@pytest.mark.conforms("AC-08")
@each(("bit_rate", "longest"), TABLE)
def test_the_manuals_lengths(bit_rate: int, longest: float) -> None:
    assert longest_m(bit_rate) == longest
    assert warnings(BusConfig(name="a", length_m=longest), 2, bit_rate) == []
    assert warnings(BusConfig(name="a", length_m=longest + 1), 2, bit_rate) == [
        f"bus a: {longest + 1} m at {bit_rate} bit/s, where {longest} m are the longest; "
        "nodes far apart may not understand each other"
    ]


@pytest.mark.conforms("AC-08")
@each(("bit_rate", "longest"), TABLE)
def test_opto_couplers_are_30_m(bit_rate: int, longest: float) -> None:
    assert effective_length_m(longest, COUPLER_DELAY_NS) == longest + 30
    isolated = BusConfig(name="a", length_m=max(0, longest - 29), node_delay_ns=COUPLER_DELAY_NS)
    [told] = warnings(isolated, 2, bit_rate)
    assert told == (
        f"bus a: {max(30, longest + 1)} m ({isolated.length_m:g} m of cable, 30 m for the nodes' delay) "
        f"at {bit_rate} bit/s, where {longest} m are the longest; nodes far apart may not understand each other"
    )
    if longest > 30:
        fits = BusConfig(name="a", length_m=longest - 30, node_delay_ns=COUPLER_DELAY_NS)
        assert warnings(fits, 2, bit_rate) == []


@pytest.mark.conforms("AC-08")
@each(("bit_rate", "longest"), TABLE)
def test_the_virtual_bus_has_them_too(bit_rate: int, longest: float) -> None:
    """A level takes as long over 30 m as through two couplers."""
    timing = BitTiming.for_bit_rate(bit_rate)
    cable = one_way_delay_ps(timing, longest + 30, 0)
    assert one_way_delay_ps(timing, longest, COUPLER_DELAY_NS) == cable


def test_rates_between_the_rows() -> None:
    rates = [
        1_000_000,
        900_000,
        800_000,
        666_667,
        500_000,
        333_333,
        250_000,
        200_000,
        125_000,
        50_000,
        10_000,
    ]
    lengths = [longest_m(rate) for rate in rates]
    assert lengths == sorted(set(lengths))
    assert longest_m(50_000) == 1_250
    assert longest_m(375_000) == pytest.approx(150)


@pytest.mark.conforms("AC-08")
@each(("ohm", "fits"), [(119, False), (120, True), (150, True), (180, True), (180.5, False)])
def test_termination(ohm: float, fits: bool) -> None:
    told = warnings(BusConfig(name="body", termination_ohm=ohm), 2)
    expected = [f"bus body: terminated with {ohm:g} ohm; each end of the cable takes 120 to 180 ohm"]
    assert told == ([] if fits else expected)


@pytest.mark.conforms("AC-08")
def test_number_of_nodes() -> None:
    bus = BusConfig(name="body")
    assert warnings(bus, 110) == []
    assert warnings(bus, 111) == ["bus body: 111 nodes; transceivers drive 110 at most"]


@pytest.mark.conforms("AC-08")
def test_a_whole_configuration() -> None:
    assert config_warnings(Config.default()) == []
    boards = tuple(BoardConfig(kind="usb-to-can-fd", serial=f"HW{number}") for number in range(56))
    buses = (
        BusConfig(name="can0", termination_ohm=60, length_m=200),
        BusConfig(name="lin0", type="lin", termination_ohm=60, length_m=2_000),
        BusConfig(name="quiet", bit_rate=125_000, length_m=200),
    )
    assert config_warnings(Config(bus=buses, board=boards)) == [
        "bus can0: terminated with 60 ohm; each end of the cable takes 120 to 180 ohm",
        "bus can0: 112 nodes; transceivers drive 110 at most",
        "bus can0: 200 m at 500000 bit/s, where 100 m are the longest; "
        "nodes far apart may not understand each other",
    ]
