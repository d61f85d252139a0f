"""The faults of a lab's LIN bus: disturbed bits, disconnected nodes, a short."""

from __future__ import annotations

from typing import Any

from canwire.boards.catalogue import plug_lin, unplug_lin
from canwire.boards.islands import Islands
from canwire.boards.lin.line import LinLine
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.lab.lin.node import LinBenchNode
from canwire.lab.time import LabTime


class LabLinFaults(LinFaults):
    """Faults of bus/lin/faults.py for nodes of the lab, and nodes that can be disconnected.

    Unlike in can/faults.py, a short has two levels, and a node that reconnects does not join again.
    """

    def __init__(self, time: LabTime, bus: LinBus) -> None:
        super().__init__(bus)
        self._time = time
        self._islands: Islands[LinLine, LinBus] = Islands(time.timeline, LinBus, plug_lin, unplug_lin)

    def disconnect(self, node: LinBenchNode[Any]) -> None:
        """Disconnect the node: it is alone on a separate stub immediately, even in the middle of a frame."""
        with self._time.touch():
            self._islands.pull(node.line, node.name)

    def reconnect(self, node: LinBenchNode[Any]) -> None:
        """Connect the node again."""
        with self._time.touch():
            self._islands.put_back(node.line, self._go_home)

    def short(self, to: str = "ground") -> None:
        """Short the wire to "ground" (dominant) or to the "supply" (recessive), until `clear_short`."""
        with self._time.touch():
            super().short(to)

    def clear_short(self) -> None:
        """Remove the short."""
        with self._time.touch():
            super().clear_short()

    def _go_home(self, line: LinLine) -> None:
        plug_lin(line, self._bus)
