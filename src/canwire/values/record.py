"""The record that travels through every ring: 80 bytes, laid out like VCI's CANMSG2.

Words are little-endian. `dwTime` and the reserved word after it hold one 64-bit time in
nanoseconds; a dialect that uses ticks converts them.

    offset  size  field
    0       8     time_ns   received: end of frame; to send: delay after the frame sent before
    8       4     id        right-aligned, 11 or 29 bits; 0xFFFFFFFF for events
    12      4     info      the bits below
    16      64    data      events: see EVENT_* below

Source: VCI V4 manual 7.3.14-7.3.16, reference/vci.md sections 3 and 5.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from canwire.errors import ExtraMissing

if TYPE_CHECKING:
    import numpy

RECORD_SIZE = 80
RECORD_WORDS = 10
NO_ID = 0xFFFF_FFFF

# info: message type in bits 0..7, then CANMSGINFO's bits
TYPE_MASK = 0xFF  # of the message type: 0 is a frame
SINGLE_SHOT = 1 << 8  # sent once: not repeated after an error or a lost arbitration
HIGH_PRIORITY = 1 << 9  # sent from the mailbox of high priority, before other frames of the line
EXTENDED_DATA_LENGTH = 1 << 10  # a CAN FD frame
FAST_DATA_RATE = 1 << 11  # a CAN FD frame that switches its bit rate (BRS)
ERROR_STATE_INDICATOR = 1 << 12  # the sender of a CAN FD frame was error passive (ESI)
CONFIRM = (
    1 << 13
)  # canwire's, in a bit that VCI reserves: the sender gets its frame returned with the outcome
ABORT_ON_ERROR = 1 << 14  # canwire's: discarded at its first bus error, but not after a lost arbitration
LOOP_BACK = 1 << 15  # canwire's: each receiving channel of the line immediately gets a copy, as if received
CONFIRM_LOAD = (
    1 << 24
)  # canwire's, of a record to send: returned to its channel when the controller has taken it
DLC_SHIFT = 16  # where the data length code begins
DLC_MASK = 0xF << DLC_SHIFT  # of the data length code
OVERRUN = 1 << 20  # frames before this one were lost because the receive queue was full
SELF_RECEPTION = 1 << 21  # to send: receive the frame, too; received: this line has sent it
REMOTE = 1 << 22  # a remote frame
EXTENDED = 1 << 23  # an identifier of 29 bits
ACCEPT_SHIFT = 24

# event records: offsets into the data field
EVENT_ERROR = 0
EVENT_STATUS = 1
EVENT_FLAGS = 2
EVENT_REC = 3
EVENT_TEC = 4
EVENT_BIT = 6
EVENT_CODE = 8

STRUCT_CANMSG = "<3I8s"
STRUCT_CANMSG2 = "<4I64s"
STRUCT_LINMSG = "<2I8s"


@cache
def record_dtype() -> numpy.dtype[numpy.void]:
    """numpy dtype of a record: time_ns, id, info, data[64]; 80 bytes.

    `time_ns` is the end of a received frame, or a delay in a frame to send. The bits of `info`, by their names in
    canwire: TYPE_MASK 0 for a frame, else an EventKind; DLC_MASK, DLC_SHIFT the data length code; EXTENDED a 29-bit
    identifier; REMOTE; EXTENDED_DATA_LENGTH an FD frame, FAST_DATA_RATE its BRS, ERROR_STATE_INDICATOR its ESI;
    SELF_RECEPTION the node's own frame; OVERRUN frames were lost before this one.

    >>> records = frames_to_array([Frame(0x123, bytes(3)), Frame(0x18DAF110, extended=True)])
    >>> ((records["info"] & DLC_MASK) >> DLC_SHIFT).tolist(), (records["info"] & EXTENDED != 0).tolist()
    ([3, 0], [False, True])
    """
    return load_numpy().dtype([("time_ns", "<u8"), ("id", "<u4"), ("info", "<u4"), ("data", "u1", 64)])


@cache
def canmsg_dtype() -> numpy.dtype[numpy.void]:
    """numpy dtype of VCI's CANMSG: dwTime (ticks), dwMsgId, uMsgInfo, abData[8]; 20 bytes."""
    return load_numpy().dtype(
        [("dwTime", "<u4"), ("dwMsgId", "<u4"), ("uMsgInfo", "<u4"), ("abData", "u1", 8)]
    )


@cache
def linmsg_dtype() -> numpy.dtype[numpy.void]:
    """numpy dtype of VCI's LINMSG: dwTime (ticks), uMsgInfo, abData[8]; 16 bytes."""
    return load_numpy().dtype([("dwTime", "<u4"), ("uMsgInfo", "<u4"), ("abData", "u1", 8)])


def load_numpy() -> Any:
    """Import numpy, or raise ExtraMissing with the name of the extra."""
    try:
        import numpy
    except ModuleNotFoundError:
        raise ExtraMissing("numpy", "arrays") from None
    return numpy
