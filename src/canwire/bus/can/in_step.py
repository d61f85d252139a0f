"""Which frames may be taken whole: those in which every edge falls on a bit boundary of every node.

The proof is docs/whole-frames.md. Called once for each change of the nodes on the bus or of their settings, never for
a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from canwire.bus.can.node import CLASSIC_ONLY, Node


class InStep(NamedTuple):
    """The kinds of frames for which the bit level provably gives the same: classic, FD, and those that switch rates."""

    classic: bool
    fd: bool
    switching: bool


def in_step(members: Sequence[Node], waiting: Sequence[Node], delay_ps: int) -> InStep:
    """The frames that may be taken whole: `members` are on the bus, `waiting` look for 11 recessive bits."""
    classic = nominal_bits_coincide(members, waiting, delay_ps) and all(map(reads_itself, members))
    # a node that ignores short dominant bits may join in the middle of an FD frame
    fd = classic and one_format(members) and not any(node.edge_filter for node in waiting)
    switching = fd and data_bits_coincide(members, waiting) and all(map(reads_its_data, members))
    return InStep(classic, fd, switching)


def nominal_bits_coincide(members: Sequence[Node], waiting: Sequence[Node], delay_ps: int) -> bool:
    """One SOF sets all clocks, and no later edge finds one of them off by even a picosecond."""
    nodes = [*members, *waiting]
    return len({node.bit_ps for node in nodes}) <= 1 and (delay_ps == 0 or len(nodes) == 1)


def one_format(members: Sequence[Node]) -> bool:
    """All nodes know CAN FD frames, and compute their CRC in the same way."""
    formats = {node.fd for node in members}
    return len(formats) == 1 and CLASSIC_ONLY not in formats


def data_bits_coincide(members: Sequence[Node], waiting: Sequence[Node]) -> bool:
    """All nodes change the rate at the same instants, and no bit is so long that a waiting node takes it for an idle
    bus.
    """
    switches = {(node.sample_ps, node.data_bit_ps, node.data_sample_ps) for node in members}
    if len(switches) > 1:
        return False
    return all(node.data_bit_ps <= waiter.bit_ps for node in members for waiter in waiting)


def reads_itself(node: Node) -> bool:
    """Whether a node that samples in the nominal phase sees its own bit alone."""
    return node.loop_ps <= node.sample_ps - 2 * node.sample_gap_ps


def reads_its_data(node: Node) -> bool:
    """The same in the data phase, where a second sample point may take the place of the first."""
    if not node.compensates:
        return node.loop_ps <= node.data_sample_ps
    at_ps = node.second_sample_ps
    if node.measures_delay:
        at_ps = max(at_ps + node.loop_ps, node.least_second_ps)
    return node.loop_ps <= at_ps < node.loop_ps + node.data_bit_ps
