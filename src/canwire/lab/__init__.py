"""The lab, a test bench in a program: buses, nodes and faults, in virtual time by default."""

from canwire.lab.bench import Lab
from canwire.lab.can.bus import LabBus, LabNode
from canwire.lab.can.script import NodeScript
from canwire.lab.lin.bus import LabLinBus, LabLinNode

__all__ = ["Lab", "LabBus", "LabLinBus", "LabLinNode", "LabNode", "NodeScript"]
