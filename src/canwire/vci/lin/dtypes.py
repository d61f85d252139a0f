"""numpy dtypes of LIN messages with C's field names. numpy is loaded at the first use.

Source: reference/vci.md section 5; message.py has the same offsets, fifo/elements.py those of a FIFO's records.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from canwire.vci.arrays import load_numpy

if TYPE_CHECKING:
    import numpy

_ROOM = 8


@cache
def linmsg_dtype() -> numpy.dtype[numpy.void]:
    """LINMSG: dwTime (ticks), uMsgInfo, abData[8]; 16 bytes."""
    return load_numpy().dtype([("dwTime", "<u4"), ("uMsgInfo", "<u4"), ("abData", "u1", _ROOM)])


@cache
def linmsg_view_dtype() -> numpy.dtype[numpy.void]:
    """LINMSG's fields at their offsets in the 80-byte records of a monitor's FIFO."""
    return load_numpy().dtype(
        {
            "names": ["dwTime", "uMsgInfo", "abData"],
            "formats": ["<u4", "<u4", ("u1", _ROOM)],
            "offsets": [0, 12, 16],
            "itemsize": 80,
        }
    )
