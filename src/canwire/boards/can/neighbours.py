"""The other nodes of a bus, with their timings: those besides the known lines, such as attached chips."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable
from dataclasses import replace

from canwire.bus.can.node import Node
from canwire.values.timing.check import NodeTiming


def neighbours(nodes: Iterable[Node], known: Container[Node]) -> list[NodeTiming]:
    """The timings of those of the nodes that are not known; a node without a name is named by its kind and a number.

    A node that takes no part in its bus (stopped, in reset or configuration mode, bus-off) is left out.
    """
    numbers: Counter[str] = Counter()
    found = []
    for node in nodes:
        made = node.timing
        if made is None or node in known or not (node.on_bus or node.waiting or node.asleep):
            continue
        numbers[made.name] += 1
        found.append(replace(made, name=node.name or f"{made.name} no. {numbers[made.name]}"))
    return found
