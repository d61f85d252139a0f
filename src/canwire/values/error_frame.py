"""Events as SocketCAN's error frames, both directions: an identifier of error classes, 8 data bytes.

    ERROR              PROT | BUSERROR, data[2] the type, data[3] the place; ACK | BUSERROR for ACK
    STATE              BUSOFF, or CRTL with data[1] (warning, passive, active)
    ARBITRATION_LOST   LOSTARB, data[0] the bit
    OVERRUN            CRTL with data[1] bit 0 (receive overflow)
    INFO               RESTARTED; stopped: no class
    ABORTED, CHANGED, SLEEPING, WOKEN, STATE stopped: no class; data[0] is our EventKind, data[1] our ErrorState
    always             data[2] bit 7 transmitting; CNT with TEC in data[6] and REC in data[7]

Not kept: the bit and code of an error; FAST_DATA_BIT (becomes BIT); NONE as an error (OTHER); counters above
255 (256 in bus-off comes back); STOPPED beside an error or a lost arbitration; an unknown bit of a
lost arbitration (0). A missing acknowledge and a lost arbitration come back as transmitting. Of
foreign error frames, what SocketCAN adds (transceiver, transmit overflows, timeouts) becomes ERROR OTHER.

Source: linux/can/error.h.
"""

from __future__ import annotations

from canwire.errors import BadText
from canwire.values.checks import instance, octets, whole
from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind

ERROR_FLAG = 0x2000_0000

LOSTARB = 0x002
CRTL = 0x004
PROT = 0x008
ACK = 0x020
BUSOFF = 0x040
BUSERROR = 0x080
RESTARTED = 0x100
CNT = 0x200

_CRTL_RX_OVERFLOW = 0x01
_CRTL_WARNING = 0x0C
_CRTL_PASSIVE = 0x30
_CRTL_ACTIVE = 0x40
_CRTL_OF_STATE = {ErrorState.ERROR_WARNING: _CRTL_WARNING, ErrorState.ERROR_PASSIVE: _CRTL_PASSIVE}
_RECEIVER_SIDE = 0x14  # of the four bits above, those about REC
_TRANSMITTING = 0x80
_OURS = (EventKind.ABORTED, EventKind.CHANGED, EventKind.SLEEPING, EventKind.WOKEN)

# ErrorKind -> (type in data[2], place in data[3])
_PROTOCOL = {
    ErrorKind.NONE: (0, 0),
    ErrorKind.STUFF: (0x04, 0),
    ErrorKind.FORM: (0x02, 0),
    ErrorKind.ACK: (0, 0x19),
    ErrorKind.BIT: (0x01, 0),
    ErrorKind.FAST_DATA_BIT: (0x01, 0x0A),
    ErrorKind.CRC: (0, 0x08),
    ErrorKind.DLC: (0, 0x0B),
    ErrorKind.OTHER: (0, 0),
}
_KIND_OF_TYPE = ((0x04, ErrorKind.STUFF), (0x02, ErrorKind.FORM), (0x19, ErrorKind.BIT))
_KIND_OF_PLACE = {0x19: ErrorKind.ACK, 0x08: ErrorKind.CRC, 0x0B: ErrorKind.DLC}


def encode_error_frame(event: BusEvent) -> tuple[int, bytes]:
    """(identifier with ERROR_FLAG, 8 data bytes) of an event."""
    instance("event", event, BusEvent)
    data = bytearray(8)
    stopped = event.state is ErrorState.STOPPED and event.kind in (EventKind.INFO, EventKind.STATE)
    if stopped or event.kind in _OURS:
        classes = 0
        data[0], data[1] = event.kind, event.state
    else:
        classes = _encode_kind(event, data) | _encode_state(event, data)
    if event.transmitting:
        data[2] |= _TRANSMITTING
    if event.tec or event.rec:
        classes |= CNT
        data[6], data[7] = min(event.tec, 255), min(event.rec, 255)
    return ERROR_FLAG | classes, bytes(data)


def _encode_kind(event: BusEvent, data: bytearray) -> int:
    """The error classes for the kind of the event; fills in their data."""
    if event.kind is EventKind.ERROR:
        data[2], data[3] = _PROTOCOL[event.error]
        return BUSERROR | (ACK if event.error is ErrorKind.ACK else PROT)
    if event.kind is EventKind.ARBITRATION_LOST:
        data[0] = max(event.bit, 0) & 0xFF
        return LOSTARB
    if event.kind is EventKind.OVERRUN:
        data[1] = _CRTL_RX_OVERFLOW
        return CRTL
    if event.kind is EventKind.INFO:
        return RESTARTED
    if event.state is ErrorState.ERROR_ACTIVE:
        data[1] = _CRTL_ACTIVE
        return CRTL
    return 0


def _encode_state(event: BusEvent, data: bytearray) -> int:
    """The error classes for the state of the controller; fills in their data."""
    if event.state is ErrorState.BUS_OFF:
        return BUSOFF
    if event.state not in _CRTL_OF_STATE:
        return 0
    both = _CRTL_OF_STATE[event.state]
    data[1] |= both & _RECEIVER_SIDE if event.rec > event.tec else both & ~_RECEIVER_SIDE
    return CRTL


def decode_error_frame(id: int, data: bytes, timestamp_ns: int = 0) -> BusEvent:
    """The event in an error frame; data shorter than 8 bytes counts as zeros. Raises BadText."""
    whole("id", id, 0, (1 << 32) - 1)
    whole("timestamp_ns", timestamp_ns, 0, (1 << 64) - 1)
    data = octets("data", data)
    if len(data) > 8:
        raise BadText(f"{len(data)} bytes: an error frame carries at most 8")
    data = data.ljust(8, b"\0")
    classes = id & 0x1FFF_FFFF & ~CNT
    if not classes:
        return _decode_ours(data, timestamp_ns)
    kind, error, bit = EventKind.ERROR, ErrorKind.OTHER, -1
    state = _state(classes, data)
    transmitting = bool(data[2] & _TRANSMITTING)
    if classes & (PROT | ACK | BUSERROR):
        error = _error(classes, data)
        transmitting = transmitting or error is ErrorKind.ACK
    elif classes & LOSTARB:
        kind, error, bit, transmitting = EventKind.ARBITRATION_LOST, ErrorKind.NONE, data[0], True
    elif classes & RESTARTED:
        kind, error = EventKind.INFO, ErrorKind.NONE
    elif classes & CRTL and data[1] & _CRTL_RX_OVERFLOW:
        kind, error = EventKind.OVERRUN, ErrorKind.NONE
    elif classes & BUSOFF or (classes & CRTL and data[1] & (_CRTL_WARNING | _CRTL_PASSIVE | _CRTL_ACTIVE)):
        kind, error = EventKind.STATE, ErrorKind.NONE
    return BusEvent(kind, timestamp_ns, error, state, bit, transmitting, _tec(state, data[6]), data[7])


def _state(classes: int, data: bytes) -> ErrorState:
    if classes & BUSOFF:
        return ErrorState.BUS_OFF
    if classes & CRTL and data[1] & _CRTL_PASSIVE:
        return ErrorState.ERROR_PASSIVE
    if classes & CRTL and data[1] & _CRTL_WARNING:
        return ErrorState.ERROR_WARNING
    return ErrorState.ERROR_ACTIVE


def _error(classes: int, data: bytes) -> ErrorKind:
    if classes & ACK:
        return ErrorKind.ACK
    for types, kind in _KIND_OF_TYPE:
        if data[2] & types:
            return kind
    return _KIND_OF_PLACE.get(data[3], ErrorKind.OTHER)


def _decode_ours(data: bytes, timestamp_ns: int) -> BusEvent:
    try:
        kind, state = EventKind(data[0]), ErrorState(data[1])
    except ValueError:
        raise BadText("an error frame without an error class") from None
    return BusEvent(
        kind,
        timestamp_ns,
        state=state,
        transmitting=bool(data[2] & _TRANSMITTING),
        tec=_tec(state, data[6]),
        rec=data[7],
    )


def _tec(state: ErrorState, byte: int) -> int:
    """Limit a counter to one byte: in bus-off, TEC stays at 256."""
    return 256 if state is ErrorState.BUS_OFF and byte == 255 else byte
