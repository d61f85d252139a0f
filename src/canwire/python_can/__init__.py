"""python-can on shared boards: `can.Bus(interface="canwire", channel="can0")`, found by an entry point.

    with can.Bus(interface="canwire", channel="can0", bitrate=500_000) as bus:
        bus.send(can.Message(arbitration_id=0x123, data=[1, 2, 3], is_extended_id=False))
        print(bus.recv(1.0))

Needs python-can. bus.py has every parameter.
"""

from importlib.util import find_spec

from canwire import ExtraMissing

if find_spec("can") is None:
    raise ExtraMissing("python-can", "can")

from canwire.python_can.bus import CanwireBus

__all__ = ["CanwireBus"]
