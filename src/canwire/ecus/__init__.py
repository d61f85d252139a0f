"""Small ECUs for the lab and shared boards, on common protocol libraries.

    ecu = canwire.ecus.UdsEcu(identifiers={0xF190: b"CANWIRE0123456789"})
    bus.node("ecu", ecu)
    with Client(canwire.ecus.UdsConnection(bus.node("tester"))) as client:      # udsoncan's
        client.read_data_by_identifier(0xF190)

ISO-TP uses can-isotp (`transport.py` runs it in the lab's time), UDS uses udsoncan (`uds.py`, `connection.py`),
CANopen uses canopen (canopen/), and J1939 uses can-j1939 (j1939/). `bench.py` provides the services of a lab node that
these libraries need. A library is imported only when a name that needs it is used; canwire[protocols] installs all.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from canwire import ExtraMissing

if TYPE_CHECKING:
    from canwire.ecus.canopen import CanopenEcu as CanopenEcu
    from canwire.ecus.canopen import LabCanopen as LabCanopen
    from canwire.ecus.canopen import load_eds as load_eds
    from canwire.ecus.connection import UdsConnection as UdsConnection
    from canwire.ecus.j1939 import J1939Ecu as J1939Ecu
    from canwire.ecus.j1939 import LabJ1939 as LabJ1939
    from canwire.ecus.transport import LabIsoTp as LabIsoTp
    from canwire.ecus.uds import UdsEcu as UdsEcu

_HOMES = {  # a name, where it is, and the libraries it needs
    "CanopenEcu": ("canopen", ("canopen",)),
    "J1939Ecu": ("j1939", ("j1939",)),
    "LabCanopen": ("canopen", ("canopen",)),
    "LabIsoTp": ("transport", ("isotp",)),
    "LabJ1939": ("j1939", ("j1939",)),
    "load_eds": ("canopen", ("canopen",)),
    "UdsConnection": ("connection", ("isotp", "udsoncan")),
    "UdsEcu": ("uds", ("isotp", "udsoncan")),
}
_PACKAGES = {"isotp": "can-isotp", "j1939": "can-j1939"}  # whose name is not that of their module

__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'canwire.ecus' has no attribute {name!r}")
    home, libraries = _HOMES[name]
    for library in libraries:
        if find_spec(library) is None:
            raise ExtraMissing(_PACKAGES.get(library, library), "protocols")
    return getattr(import_module(f"canwire.ecus.{home}"), name)


def __dir__() -> list[str]:
    return sorted(_HOMES)
