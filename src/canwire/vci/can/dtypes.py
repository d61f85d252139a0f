"""numpy dtypes of CAN messages with C's field names. numpy is loaded at the first use.

Source: reference/vci.md section 5; offsets as in message.py.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from canwire.vci.arrays import load_numpy

if TYPE_CHECKING:
    import numpy

_WORD = "<u4"


@cache
def canmsg_dtype() -> numpy.dtype[numpy.void]:
    """CANMSG: dwTime (ticks), dwMsgId, uMsgInfo, abData[8]; 20 bytes."""
    fields = [("dwTime", _WORD), ("dwMsgId", _WORD), ("uMsgInfo", _WORD), ("abData", "u1", 8)]
    return load_numpy().dtype(fields)


@cache
def canmsg2_dtype() -> numpy.dtype[numpy.void]:
    """CANMSG2: dwTime (ticks), _rsvd_, dwMsgId, uMsgInfo, abData[64]; 80 bytes."""
    words = [(name, _WORD) for name in ("dwTime", "_rsvd_", "dwMsgId", "uMsgInfo")]
    return load_numpy().dtype([*words, ("abData", "u1", 64)])


@cache
def canmsg_view_dtype() -> numpy.dtype[numpy.void]:
    """CANMSG's fields at the offsets of CANMSG2: a view of 80-byte records with 8 bytes of data."""
    return load_numpy().dtype(
        {
            "names": ["dwTime", "dwMsgId", "uMsgInfo", "abData"],
            "formats": [_WORD, _WORD, _WORD, ("u1", 8)],
            "offsets": [0, 8, 12, 16],
            "itemsize": 80,
        }
    )
