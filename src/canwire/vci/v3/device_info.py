"""The versions and connectors in IVciDevice.

Source: VCI V3 .NET manual 2.2; reference/vci.md section 7a.
"""

from __future__ import annotations

from typing import NamedTuple

from canwire.vci.controller_types import vci_bus_type, vci_ctl_type
from canwire.vci.v3.bus_type import VciBusType
from canwire.vci.v3.can.enums import CanCtrlType


class Version(NamedTuple):
    """.NET's System.Version; numbers that are not given are -1. Versions are compared number by number.

    The third and fourth numbers are release and build for a driver, branch and build for a board.
    """

    major: int
    minor: int
    build: int = -1
    revision: int = -1

    def __str__(self) -> str:
        return ".".join(str(number) for number in self if number >= 0)


class VciCtrlInfo(NamedTuple):
    """One connector: its kind of bus, and its controller, a CanCtrlType for CAN, else a number."""

    bus_type: VciBusType
    controller_type: CanCtrlType | int

    @classmethod
    def of(cls, word: int) -> VciCtrlInfo:
        """The connector for a word of controller_types.py."""
        bus_type, number = VciBusType(vci_bus_type(word)), vci_ctl_type(word)
        return cls(bus_type, CanCtrlType(number) if bus_type is VciBusType.CAN else number)
