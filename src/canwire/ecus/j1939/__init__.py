"""J1939 by can-j1939: an ECU for the lab and shared boards, and can-j1939's ElectronicControlUnit in the lab's time.

`ecu.py` is the ECU, `unit.py` the ElectronicControlUnit on a node of the lab.
"""

from canwire.ecus.j1939.ecu import J1939Ecu
from canwire.ecus.j1939.unit import LabJ1939

__all__ = ["J1939Ecu", "LabJ1939"]
