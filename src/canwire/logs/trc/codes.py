"""The letters and numbers of TRC files for error frames and states."""

from __future__ import annotations

from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind

FD_TYPES = {"FD": (False, False), "FB": (True, False), "FE": (False, True), "BI": (True, True)}  # BRS, ESI
TYPE_OF_FD = {bits: name for name, bits in FD_TYPES.items()}
_ERROR_TYPES = {ErrorKind.BIT: 1, ErrorKind.FAST_DATA_BIT: 1, ErrorKind.FORM: 2, ErrorKind.STUFF: 4}
_KIND_OF_TYPE = {1: ErrorKind.BIT, 2: ErrorKind.FORM, 4: ErrorKind.STUFF}
_OTHER = 8
_CRC_PLACE, _ACK_PLACE = 0x08, 0x19  # of SJA1000's error code capture
_PLACES = {ErrorKind.CRC: _CRC_PLACE, ErrorKind.ACK: _ACK_PLACE}
_KIND_OF_PLACE = {place: kind for kind, place in _PLACES.items()}
_LIGHT, _HEAVY, _OFF, _PASSIVE = 0x04, 0x08, 0x10, 0x4_0000
_STATUS = {ErrorState.ERROR_ACTIVE: 0, ErrorState.ERROR_WARNING: _HEAVY, ErrorState.ERROR_PASSIVE: _PASSIVE,
           ErrorState.BUS_OFF: _OFF}  # fmt: skip


def error_columns(event: BusEvent) -> tuple[int, bytes]:
    """Return an error frame's type, and the bytes of direction, place and both counters."""
    kind = _ERROR_TYPES.get(event.error, _OTHER)
    place = _PLACES.get(event.error, 0)
    return kind, bytes((not event.transmitting, place, min(event.rec, 255), min(event.tec, 255)))


def error_of_columns(kind: int, data: bytes, time_ns: int) -> BusEvent:
    """Return the error frame of these columns."""
    data = data.ljust(4, b"\0")
    error = _KIND_OF_TYPE.get(kind) or _KIND_OF_PLACE.get(data[1], ErrorKind.OTHER)
    return BusEvent(EventKind.ERROR, time_ns, error=error, transmitting=not data[0], rec=data[2], tec=data[3])


def status_of(event: BusEvent) -> bytes | None:
    """Return a change of state as the four bytes of PCAN's status; None for a state that the status cannot express."""
    word = _STATUS.get(event.state)
    return None if word is None else word.to_bytes(4, "big")


def event_of_status(data: bytes, time_ns: int) -> BusEvent:
    """Return the change of state that PCAN's status expresses."""
    word = int.from_bytes(data, "big")
    if word & _OFF:
        state = ErrorState.BUS_OFF
    elif word & _PASSIVE:
        state = ErrorState.ERROR_PASSIVE
    elif word & (_HEAVY | _LIGHT):
        state = ErrorState.ERROR_WARNING
    else:
        state = ErrorState.ERROR_ACTIVE
    return BusEvent(EventKind.STATE, time_ns, state=state)
