"""The test bench: buses and nodes in three lines, virtual time by default, faults at will."""

from canwire.lab.bench import Lab
from canwire.lab.bus import LabBus
from canwire.lab.lin import LabLinBus
from canwire.lab.lin_node import LabLinNode
from canwire.lab.node import LabNode
from canwire.lab.script import NodeScript

__all__ = ["Lab", "LabBus", "LabLinBus", "LabLinNode", "LabNode", "NodeScript"]
