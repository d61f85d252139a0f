"""The test bench: buses and nodes in three lines, virtual time by default, faults at will."""

from canwire.lab.bench import Lab
from canwire.lab.can.bus import LabBus, LabNode
from canwire.lab.can.script import NodeScript
from canwire.lab.lin.bus import LabLinBus, LabLinNode

__all__ = ["Lab", "LabBus", "LabLinBus", "LabLinNode", "LabNode", "NodeScript"]
