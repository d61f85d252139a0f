"""What goes wrong on a bench's LIN bus: faults, plugs that can be pulled, a short."""

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
    """bus/lin/faults.py, with nodes of the bench and with plugs that can be pulled.

    It looks like can/faults.py, whose wires short one way only, and whose nodes join anew.
    """

    def __init__(self, time: LabTime, bus: LinBus) -> None:
        super().__init__(bus)
        self._time = time
        self._islands: Islands[LinLine, LinBus] = Islands(time.timeline, LinBus, plug_lin, unplug_lin)

    def disconnect(self, node: LinBenchNode[Any]) -> None:
        """Pull the node's plug: it is alone on its own stub, at once, in the middle of a frame if need be."""
        with self._time.touch():
            self._islands.pull(node.line, node.name)

    def reconnect(self, node: LinBenchNode[Any]) -> None:
        """Put the plug back."""
        with self._time.touch():
            self._islands.put_back(node.line, self._go_home)

    def short(self, to: str = "ground") -> None:
        """Short the wire to "ground" (dominant) or to the "supply" (recessive), until `clear_short`."""
        with self._time.touch():
            super().short(to)

    def clear_short(self) -> None:
        """Take the short away."""
        with self._time.touch():
            super().clear_short()

    def _go_home(self, line: LinLine) -> None:
        plug_lin(line, self._bus)
