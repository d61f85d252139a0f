"""Which frames may be processed whole: those in which every edge falls on a bit boundary of every node.

The proof is docs/whole-frames.md. Called once for each change of the nodes on the bus or of their settings, never for
a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from canwire.bus.can.node import CLASSIC_ONLY, Node


class InStep(NamedTuple):
    """The kinds of frames for which the bit level provably gives the same result: classic, FD, and FD with a rate
    switch.
    """

    classic: bool
    fd: bool
    switching: bool


def in_step(members: Sequence[Node], waiting: Sequence[Node], delay_ps: int) -> InStep:
    """The frames that may be processed whole:

    `members` are on the bus, `waiting` are nodes that wait for 11 recessive bits.
    """
    classic = nominal_bits_coincide(members, waiting, delay_ps) and all(map(reads_itself, members))
    # a node that ignores short dominant bits may join in the middle of an FD frame
    fd = classic and one_format(members) and not any(node.edge_filter for node in waiting)
    switching = fd and data_bits_coincide(members, waiting) and all(map(reads_its_data, members))
    return InStep(classic, fd, switching)


def nominal_bits_coincide(members: Sequence[Node], waiting: Sequence[Node], delay_ps: int) -> bool:
    """Whether one SOF synchronises all clocks, so that no later edge finds one of them off by even a picosecond."""
    nodes = [*members, *waiting]
    return len({node.bit_ps for node in nodes}) <= 1 and (delay_ps == 0 or len(nodes) == 1)


def one_format(members: Sequence[Node]) -> bool:
    """Whether all nodes know CAN FD frames, and compute the CRC of a frame in the same way."""
    formats = {node.fd for node in members}
    return len(formats) == 1 and CLASSIC_ONLY not in formats


def data_bits_coincide(members: Sequence[Node], waiting: Sequence[Node]) -> bool:
    """Whether all nodes change rates at the same instants, and no data bit outlasts a bit of a waiting node."""
    switches = {(node.sample_ps, node.data_bit_ps, node.data_sample_ps) for node in members}
    if len(switches) > 1:
        return False
    return all(node.data_bit_ps <= waiter.bit_ps for node in members for waiter in waiting)


def reads_itself(node: Node) -> bool:
    """Whether a node that samples in the nominal phase sees its own bit alone."""
    return node.loop_ps <= node.sample_ps - 2 * node.sample_gap_ps


def reads_its_data(node: Node) -> bool:
    """Whether a node sees its own bit alone in the data phase, at its second sample point if it compensates."""
    if not node.compensates:
        return node.loop_ps <= node.data_sample_ps
    at_ps = node.second_sample_ps
    if node.measures_delay:
        at_ps = max(at_ps + node.loop_ps, node.least_second_ps)
    return node.loop_ps <= at_ps < node.loop_ps + node.data_bit_ps
