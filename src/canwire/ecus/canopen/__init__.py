"""CANopen, based on the library canopen: an ECU for the lab and shared boards, and canopen's Network in the lab's time.

`ecu.py` is the ECU, `services.py` its NMT, SDO and emergency ends, `pdos.py` its process data, `small.eds` what it is
when nobody gives it a dictionary; `dictionary.py` reads others. `network.py` is canopen's Network
on a lab's node, `remote.py` its clients' waits.
"""

from canwire.ecus.canopen.dictionary import load_eds
from canwire.ecus.canopen.ecu import CanopenEcu
from canwire.ecus.canopen.network import LabCanopen

__all__ = ["CanopenEcu", "LabCanopen", "load_eds"]
