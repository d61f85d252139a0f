"""Whether two nodes' clocks are so alike that their bits need not be looked at one by one.

Source: reference/can-protocol.md section 8, conditions I to III.
"""

from __future__ import annotations

from canwire.bus.can.node import Node


def follows(node: Node, other: Node, delay_ps: int) -> bool:
    """True when `node` surely stays in step with the bits of `other`: drift within conditions 1 and 2, in reach.

    Conditions: reference/can-protocol.md section 8, I and II, with the real drift between the two in
    place of twice the tolerance. Where this is False the bit level shows what comes of it.
    """
    drift = abs(node.bit_ps - other.bit_ps)
    phase2 = node.bit_ps - node.sample_ps
    kept = 10 * drift <= node.jump_ps
    kept = kept and drift * (13 * node.bit_ps - phase2) <= min(node.phase1_ps, phase2) * node.bit_ps
    return kept and 2 * delay_ps <= node.sample_ps


def follows_data(node: Node, other: Node) -> bool:
    """The same for the data phase: condition III."""
    return 10 * abs(node.data_bit_ps - other.data_bit_ps) <= node.data_jump_ps


def reads_itself(node: Node) -> bool:
    """Nothing but its own bit is there when a node looks at one, in the nominal phase."""
    return node.loop_ps <= node.sample_ps


def reads_its_data(node: Node) -> bool:
    """The same in the data phase, where a second sample point may take the place of the first."""
    if not node.compensates:
        return node.loop_ps <= node.data_sample_ps
    at_ps = node.second_sample_ps
    if node.measures_delay:
        at_ps = max(at_ps + node.loop_ps, node.least_second_ps)
    return node.loop_ps <= at_ps < node.loop_ps + node.data_bit_ps


def all_follow(members: list[Node], delay_ps: int) -> tuple[bool, bool]:
    """Whether all these nodes can follow each other's bits and read their own, and those of FD frames too."""
    nodes = list({node.timing(): node for node in members}.values())
    alike = all(follows(node, other, delay_ps) for node in nodes for other in nodes)
    alike = alike and all(reads_itself(node) for node in members)
    modes = {node.fd for node in members}
    alike_fd = len(modes) == 1 and 0 not in modes
    alike_fd = alike_fd and all(follows_data(node, other) for node in nodes for other in nodes)
    alike_fd = alike_fd and all(reads_its_data(node) for node in members)
    return alike, alike and alike_fd
