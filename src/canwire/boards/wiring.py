"""Warnings about the wiring of a bus, as sentences; the bus runs in spite of all these conditions.

Source: INduCAN104 manual ("Network topology and medium").
"""

from __future__ import annotations

from collections import Counter

from canwire.boards import catalogue
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BusConfig
from canwire.bus.medium import effective_length_m, longest_m

TERMINATION_OHM = (120, 180)
MOST_NODES = 110
"""What a PCA82C250 can drive."""


def warnings(bus: BusConfig, nodes: int, bit_rate: int | None = None) -> list[str]:
    """The warnings for a CAN bus with this number of nodes at this bit rate (bit/s; None: its default)."""
    if bus.type != "can":
        return []
    found = []
    least, most = TERMINATION_OHM
    if not least <= bus.termination_ohm <= most:
        found.append(
            f"bus {bus.name}: terminated with {bus.termination_ohm:g} ohm; each end of the cable takes "
            f"{least} to {most} ohm"
        )
    if nodes > MOST_NODES:
        found.append(f"bus {bus.name}: {nodes} nodes; transceivers drive {MOST_NODES} at most")
    return found + _length_warnings(bus, bus.usual_rate if bit_rate is None else bit_rate)


def config_warnings(config: Config) -> list[str]:
    """The warnings for every bus of a configuration, with its boards."""
    there = {bus.name: bus.type for bus in config.bus}
    nodes = Counter(
        name
        for board in config.board
        for name in catalogue.kind(board.kind).bus_names(board.buses, there)
        if name
    )
    return [text for bus in config.bus for text in warnings(bus, nodes[bus.name])]


def _length_warnings(bus: BusConfig, bit_rate: int) -> list[str]:
    """The warning for a cable that is too long; none for an ideal bus, which has neither length nor delay."""
    length, longest = effective_length_m(bus.length_m, bus.node_delay_ns), longest_m(bit_rate)
    if length <= longest:
        return []
    added = length - bus.length_m
    parts = f" ({bus.length_m:g} m of cable, {added:g} m for the nodes' delay)" if added else ""
    return [
        f"bus {bus.name}: {length:g} m{parts} at {bit_rate} bit/s, where {longest:.4g} m are the longest; "
        "nodes far apart may not understand each other"
    ]
