"""VciBusType: kinds of bus, in V3's order.

Source: VCI V3 .NET manual 4.1; reference/vci.md section 2.
"""

from __future__ import annotations

from enum import IntEnum

from canwire.vci import controller_types as t


class VciBusType(IntEnum):
    """The kind of bus of a connector."""

    UNKNOWN = t.VCI_BUS_RES
    CAN = t.VCI_BUS_CAN
    LIN = t.VCI_BUS_LIN
    FLEX_RAY = 3  # V4 has the numbers of these two exchanged
    K_LINE = 4

    @classmethod
    def _missing_(cls, value: object) -> VciBusType:
        return cls.UNKNOWN
