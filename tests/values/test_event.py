"""Events and their records."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.values import record
from canwire.values.event import STATUS_OF_STATE, BusEvent, ErrorKind, ErrorState, EventKind, InfoCode

CODES = {
    EventKind.INFO: st.sampled_from(InfoCode),
    EventKind.TIME_OVERRUN: st.integers(0, 2**32 - 1),
    EventKind.ERROR: st.integers(0, 255),
}


@st.composite
def bus_events(draw: st.DrawFn) -> BusEvent:
    kind = draw(st.sampled_from(EventKind))
    return BusEvent(
        kind=kind,
        timestamp_ns=draw(st.integers(0, 2**64 - 1)),
        error=draw(st.sampled_from(ErrorKind)) if kind is EventKind.ERROR else ErrorKind.NONE,
        state=draw(st.sampled_from(ErrorState)),
        bit=draw(st.integers(-1, 1000)),
        transmitting=draw(st.booleans()),
        tec=draw(st.integers(0, 256)),
        rec=draw(st.integers(0, 255)),
        code=draw(CODES.get(kind, st.just(0))),
    )


events = bus_events()


@given(events)
def test_record_round_trip(event: BusEvent) -> None:
    block = event.to_record()
    assert len(block) == record.RECORD_SIZE
    for form in (block, bytearray(block), memoryview(block)):
        assert BusEvent.from_record(form) == event


@given(events)
def test_record_reads_as_vci_wants_it(event: BusEvent) -> None:
    """VCI V4 manual 7.3.14: type and acceptance code (always) in info; what counts first in the data."""
    block = event.to_record()
    data = block[16:]
    assert int.from_bytes(block[:8], "little") == event.timestamp_ns
    overrun = event.kind is EventKind.TIME_OVERRUN
    status = STATUS_OF_STATE[event.state]
    first = {EventKind.INFO: event.code, EventKind.ERROR: event.error, EventKind.STATE: status}
    assert int.from_bytes(block[8:12], "little") == (event.code if overrun else record.NO_ID)
    assert int.from_bytes(block[12:16], "little") == event.kind | 0xFF << 24 | 8 << 16
    assert data[record.EVENT_ERROR] == first.get(event.kind, 0)
    assert data[record.EVENT_STATUS] == status
    assert data[record.EVENT_REC] == event.rec
    assert data[record.EVENT_TEC] + 256 * data[record.EVENT_TEC + 1] == event.tec


def test_rec_is_held_at_255() -> None:
    event = BusEvent(EventKind.ERROR, rec=263)
    assert BusEvent.from_record(event.to_record()).rec == 255


def test_no_event_looks_like_a_frame() -> None:
    assert 0 not in set(EventKind)
    with pytest.raises(ValueError, match="0 is not a valid EventKind"):
        BusEvent.from_record(bytes(80))


def test_frozen() -> None:
    event = BusEvent(EventKind.STATE)
    with pytest.raises(dataclasses.FrozenInstanceError):
        event.tec = 1  # type: ignore[misc]
    assert len({event, BusEvent(EventKind.STATE)}) == 1


def test_every_state_has_a_status() -> None:
    assert set(STATUS_OF_STATE) == set(ErrorState)
