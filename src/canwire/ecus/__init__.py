"""Small ECUs for the lab, on the protocol libraries that people use: ISO-TP by can-isotp, UDS by udsoncan.

    ecu = canwire.ecus.UdsEcu(identifiers={0xF190: b"CANWIRE0123456789"})
    bus.node("ecu", ecu)
    with Client(canwire.ecus.UdsConnection(bus.node("tester"))) as client:      # udsoncan's
        client.read_data_by_identifier(0xF190)

`transport.py` has can-isotp run in the lab's time, `uds.py` is the ECU, `connection.py` what udsoncan's client talks
through. Needs canwire[protocols].
"""

from importlib.util import find_spec

from canwire import ExtraMissing

if find_spec("isotp") is None:
    raise ExtraMissing("can-isotp", "protocols")
if find_spec("udsoncan") is None:
    raise ExtraMissing("udsoncan", "protocols")

from canwire.ecus.connection import UdsConnection
from canwire.ecus.transport import LabIsoTp
from canwire.ecus.uds import UdsEcu

__all__ = ["LabIsoTp", "UdsConnection", "UdsEcu"]
