"""CANopen, based on the library canopen: an ECU for the lab and shared boards, and canopen's Network in the lab's time.

`ecu.py` is the ECU, `services.py` its NMT, SDO and emergency services, `pdos.py` its process data, and `small.eds` its
default dictionary; `dictionary.py` reads other dictionaries. `network.py` is canopen's Network on a lab's node, and
`remote.py` makes the waits of its clients use the lab's time.
"""

from canwire.ecus.canopen.dictionary import load_eds
from canwire.ecus.canopen.ecu import CanopenEcu
from canwire.ecus.canopen.network import LabCanopen

__all__ = ["CanopenEcu", "LabCanopen", "load_eds"]
