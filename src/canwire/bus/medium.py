"""The delay of a cable: how late a level arrives at the other end.

The table of the INduCAN104 manual ("Medium") gives the longest cable for a bit rate: 1 Mbit/s 25 m,
800 kbit/s 50 m, 500 kbit/s 100 m, 250 kbit/s 250 m, 125 kbit/s 500 m, and 15 m less for each opto-coupler (75 ns)
between two nodes. A level may take half the time up to the default sample point one way. At 5 ns/m the cable uses a
part of it; the rest is what the manual calls hardware delay, which the nodes here add to the cable.
"""

from __future__ import annotations

from itertools import pairwise

from canwire.bus.can.bus import CanBus
from canwire.values.checks import finite
from canwire.values.timing.bit_timing import BitTiming

PS_PER_METRE = 5_000
_LONGEST_M, _MOST_DELAY_NS = 10_000, 100_000
# bit time in ps, longest cable in m, default sample point: the rest of sample / 2 is the hardware's delay
_TABLE = (
    (1_000_000, 25, 0.75),
    (1_250_000, 50, 0.80),
    (2_000_000, 100, 0.875),
    (4_000_000, 250, 0.875),
    (8_000_000, 500, 0.875),
)
_SHARES = tuple((bit, (bit * sample / 2 - metres * PS_PER_METRE) / bit) for bit, metres, sample in _TABLE)
_SLOWEST_PS = _TABLE[-1][0]


def one_way_delay_ps(timing: BitTiming, length_m: float, node_delay_ns: float) -> int:
    """The delay from one node's output to another's input: cable, both nodes' extra delays, and the default hardware's.

    0 for an ideal bus, without length or delay. Raises BadValue beyond 10 km, or 100 us for each node.
    """
    finite("length_m", length_m, 0, _LONGEST_M)
    finite("node_delay_ns", node_delay_ns, 0, _MOST_DELAY_NS)
    if length_m == 0 and node_delay_ns == 0:
        return 0
    bit_ps = timing.bit_time_ps
    cable = length_m * PS_PER_METRE + 2 * node_delay_ns * 1000
    return round(cable + hardware_share(bit_ps) * bit_ps)


def delay_of(bus: object) -> int:
    """How late a level arrives on a bus, in ps; 0 for an ideal CAN bus, and for any other object."""
    return bus.delay_ps if isinstance(bus, CanBus) else 0


def effective_length_m(length_m: float, node_delay_ns: float) -> float:
    """The effective length of the cable: 15 m more for each opto-coupler (75 ns) between two nodes."""
    return length_m + 2 * node_delay_ns * 1000 / PS_PER_METRE


def longest_m(bit_rate: int) -> float:
    """Longest cable for a bit rate in bit/s by the manual's table, couplers included.

    Between the rows of the table it is interpolated, below 125 kbit/s it is proportional to the bit time.
    """
    bit_ps = 1_000_000_000_000 / bit_rate
    if bit_ps >= _SLOWEST_PS:
        return _TABLE[-1][1] * bit_ps / _SLOWEST_PS
    for (short, least, _), (long, most, _) in pairwise(_TABLE):
        if bit_ps <= long:
            return least + (most - least) * max(0.0, bit_ps - short) / (long - short)
    raise AssertionError("no row of the table")


def hardware_share(bit_ps: int) -> float:
    """Part of a bit time that transceivers and controllers take one way, from the manual's table."""
    if bit_ps <= _SHARES[0][0]:
        return _SHARES[0][1]
    for (short, high), (long, low) in pairwise(_SHARES):
        if bit_ps <= long:
            return high + (low - high) * (bit_ps - short) / (long - short)
    return _SHARES[-1][1]
