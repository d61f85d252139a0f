"""What happened on a bus besides frames, in words for people.

Source: SJA1000 data sheet 6.4.9 (error code capture).
"""

from __future__ import annotations

from canwire import BusEvent, ErrorKind, ErrorState, EventKind

ECC_PLACES = {
    0x02: "identifier", 0x03: "start of frame", 0x04: "SRTR bit", 0x05: "IDE bit", 0x06: "identifier",
    0x07: "identifier", 0x08: "CRC", 0x09: "reserved bit 0", 0x0A: "data", 0x0B: "length", 0x0C: "RTR bit",
    0x0D: "reserved bit 1", 0x0E: "identifier", 0x0F: "identifier", 0x11: "active error flag",
    0x12: "intermission", 0x13: "tolerated dominant bits", 0x16: "passive error flag", 0x17: "error delimiter",
    0x18: "CRC delimiter", 0x19: "acknowledge slot", 0x1A: "end of frame", 0x1B: "acknowledge delimiter",
    0x1C: "overload flag",
}  # fmt: skip
_ECC_PLACE = 0x1F
_KINDS = {
    ErrorKind.NONE: "error",
    ErrorKind.STUFF: "stuff error",
    ErrorKind.FORM: "form error",
    ErrorKind.ACK: "nobody acknowledged",
    ErrorKind.BIT: "bit error",
    ErrorKind.FAST_DATA_BIT: "bit error in the data phase",
    ErrorKind.CRC: "CRC error",
    ErrorKind.DLC: "length error",
    ErrorKind.OTHER: "error",
}
_HAPPENINGS = {
    EventKind.ARBITRATION_LOST: "lost arbitration",
    EventKind.ABORTED: "a frame to send was given up",
    EventKind.OVERRUN: "the controller lost a frame: the ones before it were not fetched in time",
    EventKind.CHANGED: "the line was set up again",
    EventKind.SLEEPING: "asleep",
    EventKind.WOKEN: "awake",
    EventKind.INFO: "the line was started, stopped or reset",
    EventKind.TIME_OVERRUN: "the time-stamp counter ran over",
}


def in_words(event: BusEvent) -> str:
    """`stuff error at bit 23 of the frame, receiving; error active, TEC 0, REC 9`"""
    return f"{_what(event)}; {state_in_words(event.state)}, TEC {event.tec}, REC {event.rec}"


def state_in_words(state: ErrorState) -> str:
    """`error passive`; `bus-off`"""
    return "bus-off" if state is ErrorState.BUS_OFF else state.name.lower().replace("_", " ")


def _what(event: BusEvent) -> str:
    if event.kind is EventKind.STATE:
        return "the controller's state"
    if event.kind is EventKind.ERROR:
        way = "sending" if event.transmitting else "receiving"
        return f"{_KINDS[event.error]}{_place(event)}, {way}"
    where = f" at bit {event.bit}" if event.bit >= 0 else ""
    return f"{_HAPPENINGS[event.kind]}{where}"


def _place(event: BusEvent) -> str:
    named = ECC_PLACES.get(event.code & _ECC_PLACE) if event.code else None
    told = [f"in the {named}"] if named else []
    if event.bit >= 0:
        told.append(f"at bit {event.bit} of the frame")
    return f" {', '.join(told)}" if told else ""
