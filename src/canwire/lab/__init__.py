"""The test bench: buses and nodes in three lines, virtual time by default, faults at will."""

from canwire.lab.bench import Lab
from canwire.lab.bus import LabBus
from canwire.lab.node import LabNode
from canwire.lab.script import NodeScript

__all__ = ["Lab", "LabBus", "LabNode", "NodeScript"]
