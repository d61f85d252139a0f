"""What happens on a bus besides frames: errors, changes of state, lost arbitration.

Source: VCI V4 manual 7.3.14 (message types, error codes); ISO 11898-1 fault confinement.
"""

from __future__ import annotations

import struct

from canwire.errors import BadValue
from canwire.values.frozen import dataclass
from canwire.values.named import NamedInt
from canwire.values.record import (
    EVENT_BIT,
    EVENT_ERROR,
    EVENT_FLAGS,
    EVENT_REC,
    EVENT_STATUS,
    EVENT_TEC,
    NO_ID,
    RECORD_SIZE,
)


class EventKind(NamedInt):
    """Message type of a record; 1..6 are VCI's CAN_MSGTYPE_, the rest are ours."""

    INFO = 1
    ERROR = 2
    STATE = 3
    TIME_OVERRUN = 5
    ARBITRATION_LOST = 0x10
    ABORTED = 0x11
    OVERRUN = 0x12  # the controller lost a frame, since earlier ones were not fetched in time
    CHANGED = 0x13  # the line was set up again; with an InfoCode: stopped, started again or reset
    SLEEPING = 0x14
    WOKEN = 0x15


class InfoCode(NamedInt):
    """What happened to a line; the numbers are VCI's CAN_INFO_ values."""

    STARTED = 1
    STOPPED = 2
    RESET = 3


class ErrorKind(NamedInt):
    """What was wrong with a frame; the numbers are VCI's CAN_ERROR_ values."""

    NONE = 0
    STUFF = 1
    FORM = 2
    ACK = 3
    BIT = 4
    FAST_DATA_BIT = 5
    CRC = 6
    DLC = 7
    OTHER = 8


class ErrorState(NamedInt):
    """The state of a controller in fault confinement."""

    ERROR_ACTIVE = 0
    ERROR_WARNING = 1
    ERROR_PASSIVE = 2
    BUS_OFF = 3
    STOPPED = 4


PENDING_STATUS, COUPLING_STATUS = 0x01, 0x20  # VCI's CAN_STATUS_TXPEND and _BUSCERR
STATUS_OF_STATE = {  # VCI's CAN_STATUS_: ERRLIM 4, BUSOFF 8, ININIT 16
    ErrorState.ERROR_ACTIVE: 0,
    ErrorState.ERROR_WARNING: 4,
    ErrorState.ERROR_PASSIVE: 4,
    ErrorState.BUS_OFF: 4 | 8,
    ErrorState.STOPPED: 16,
}
_TRANSMITTING = 0x80
_NO_FRAME = (
    0xFF << 24 | 8 << 16
)  # VCI's acceptance code of whatever is no data frame; eight bytes say something
_EVENT = struct.Struct(f"<QIIBBBBHhB{RECORD_SIZE - 25}x")
assert (EVENT_ERROR, EVENT_STATUS, EVENT_FLAGS, EVENT_REC, EVENT_TEC, EVENT_BIT) == (0, 1, 2, 3, 4, 6)


@dataclass(frozen=True, slots=True)
class BusEvent:
    """One event as a controller saw it.

    `bit` is where it happened: for an error the bit of the frame counted from SOF (stuff bits
    included), for a lost arbitration the deciding bit in SJA1000's order (0 first identifier
    bit, 11 RTR or SRR, 12 IDE, 13..30 identifier extension, 31 its RTR); -1 where it means
    nothing. `transmitting` is True for events of a sender. `tec` and `rec` are the
    counters after the event; TEC is held at 256 in bus-off. `code` is the InfoCode of an INFO or CHANGED, how often the
    time-stamp counter has run over in a TIME_OVERRUN, and an ERROR's code in the chip's own words (SJA1000: ECC;
    0 where it has none). `pending`: a frame of this controller's waits or is being sent; `coupling_fault`: its
    fault-tolerant transceiver reports a fault of the wires.
    """

    kind: EventKind
    timestamp_ns: int = 0
    error: ErrorKind = ErrorKind.NONE
    state: ErrorState = ErrorState.ERROR_ACTIVE
    bit: int = -1
    transmitting: bool = False
    tec: int = 0
    rec: int = 0
    code: int = 0
    pending: bool = False
    coupling_fault: bool = False

    @property
    def status(self) -> int:
        """VCI's CAN_STATUS_ bits after the event."""
        return (
            STATUS_OF_STATE[self.state]
            | PENDING_STATUS * self.pending
            | COUPLING_STATUS * self.coupling_fault
        )

    def to_record(self) -> bytes:
        """The 80-byte record of values/record.py."""
        flags = self.state | (_TRANSMITTING if self.transmitting else 0)
        status = self.status
        number = self.code if self.kind is EventKind.TIME_OVERRUN else NO_ID
        first = {
            EventKind.INFO: self.code,
            EventKind.CHANGED: self.code,
            EventKind.ERROR: int(self.error),
            EventKind.STATE: status,
        }
        return _EVENT.pack(
            self.timestamp_ns,
            number,
            self.kind | _NO_FRAME,
            first.get(self.kind, 0),
            status,
            flags,
            min(self.rec, 255),
            self.tec,
            self.bit,
            self.code if self.kind is EventKind.ERROR else 0,
        )

    @classmethod
    def from_record(cls, record: bytes | bytearray | memoryview) -> BusEvent:
        """The event in an 80-byte record; raises BadValue for other sizes and for values that no event has."""
        if len(record) != RECORD_SIZE:
            raise BadValue(f"a record has {RECORD_SIZE} bytes, not {len(record)}")
        time_ns, number, info, first, status, flags, rec, tec, bit, code = _EVENT.unpack(record)
        kind = EventKind(info & 0xFF)
        codes = {
            EventKind.INFO: first,
            EventKind.CHANGED: first,
            EventKind.TIME_OVERRUN: number,
            EventKind.ERROR: code,
        }
        return cls(
            kind=kind,
            timestamp_ns=time_ns,
            error=ErrorKind(first if kind is EventKind.ERROR else 0),
            state=ErrorState(flags & 0x7F),
            bit=bit,
            transmitting=bool(flags & _TRANSMITTING),
            tec=tec,
            rec=rec,
            code=codes.get(kind, 0),
            pending=bool(status & PENDING_STATUS),
            coupling_fault=bool(status & COUPLING_STATUS),
        )
