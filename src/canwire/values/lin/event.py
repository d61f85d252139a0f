"""What happens on a LIN line besides frames: errors, sleep and wake-up, starts and stops.

Source: VCI V4 manual 7.4.3 and 7.4.5; reference/vci.md section 4; reference/lin-protocol.md section 8.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from canwire.values.lin.record import NO_PID
from canwire.values.named import NamedInt
from canwire.values.record import RECORD_SIZE


class LinEventKind(NamedInt):
    """Message type of a record: VCI's LIN_MSGTYPE_ values."""

    INFO = 1
    ERROR = 2
    STATE = 3
    WAKEUP = 4
    SLEEP = 5
    TIME_OVERRUN = 6


class LinErrorKind(NamedInt):
    """What went wrong: VCI's LIN_ERROR_ values.

    BIT: the bus had another level than was sent. CHKSUM: neither checksum fits the data. PARITY: of the
    identifier. SLNORE: no node answered a header. SYNC: no valid sync field. NOBUS: the bus
    had no edge for seconds, or does not follow the level of the controller. OTHER: a stop bit was
    dominant, or a response was incomplete. WAKEUP: three wake-up pulses brought no header.
    """

    NONE = 0
    BIT = 1
    CHKSUM = 2
    PARITY = 3
    SLNORE = 4
    SYNC = 5
    NOBUS = 6
    OTHER = 7
    WAKEUP = 8


class LinState(NamedInt):
    """The state of a LIN controller."""

    OPERATIONAL = 0
    INITIALISING = 1
    ASLEEP = 2
    STOPPED = 4


class LinOutcome(NamedInt):
    """The outcome of a header or a wake-up pulse that a controller sent."""

    ANSWERED = 0
    SILENT = 1
    FAILED = 2


# VCI's LIN_STATUS_ bits: those of lintype.h, and the two that a public port has besides
OVERRUN_STATUS = 0x01
PENDING_STATUS = 0x02
ERROR_LIMIT_STATUS = 0x04
BUS_OFF_STATUS = 0x08
STOPPED_STATUS = 0x10

_TRANSMITTING = 0x80
# a record: time, identifier word, pid, type, dlen, flags; 8 bytes that VCI shows; state and identifier, ours
_EVENT = struct.Struct(f"<QI4B2B6xBb{RECORD_SIZE - 26}x")
# bytes of abData that mean something; in a TIME_OVERRUN VCI puts the count in their place
_VALID = {LinEventKind.INFO: 1, LinEventKind.ERROR: 2, LinEventKind.STATE: 1}


@dataclass(frozen=True, slots=True)
class LinEvent:
    """One event as a controller saw it.

    `id` is the identifier of the frame that an error is about, -1 where there is none. `transmitting`: the
    controller was sending. `status` holds VCI's LIN_STATUS_ bits after the event. `code` is an INFO's InfoCode,
    and how often the time-stamp counter has run over in a TIME_OVERRUN.
    """

    kind: LinEventKind
    timestamp_ns: int = 0
    error: LinErrorKind = LinErrorKind.NONE
    state: LinState = LinState.OPERATIONAL
    id: int = -1
    transmitting: bool = False
    status: int = 0
    code: int = 0

    def to_record(self) -> bytes:
        """The 80-byte record of values/lin/record.py."""
        valid = _VALID.get(self.kind, 0)
        if self.kind is LinEventKind.TIME_OVERRUN:
            valid = self.code & 0xFF
        first = {
            LinEventKind.INFO: self.code,
            LinEventKind.ERROR: int(self.error),
            LinEventKind.STATE: self.status,
        }
        return _EVENT.pack(
            self.timestamp_ns,
            NO_PID,
            NO_PID,
            self.kind,
            valid,
            0,
            first.get(self.kind, 0),
            self.status,
            self.state | (_TRANSMITTING if self.transmitting else 0),
            self.id,
        )

    @classmethod
    def from_record(cls, record: bytes | bytearray | memoryview) -> LinEvent:
        """The event in an 80-byte record; its kind must not be a frame's (0)."""
        time_ns, _, _, number, length, _, first, status, flags, id = _EVENT.unpack(record)
        kind = LinEventKind(number)
        codes = {LinEventKind.INFO: first, LinEventKind.TIME_OVERRUN: length}
        return cls(
            kind=kind,
            timestamp_ns=time_ns,
            error=LinErrorKind(first if kind is LinEventKind.ERROR else 0),
            state=LinState(flags & ~_TRANSMITTING),
            id=id,
            transmitting=bool(flags & _TRANSMITTING),
            status=status,
            code=codes.get(kind, 0),
        )
