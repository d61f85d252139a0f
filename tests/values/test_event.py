"""Events and their records."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.values import record
from canwire.values.event import STATUS_OF_STATE, BusEvent, ErrorKind, ErrorState, EventKind

events = st.builds(
    BusEvent,
    kind=st.sampled_from(EventKind),
    timestamp_ns=st.integers(0, 2**64 - 1),
    error=st.sampled_from(ErrorKind),
    state=st.sampled_from(ErrorState),
    bit=st.integers(-1, 1000),
    transmitting=st.booleans(),
    tec=st.integers(0, 256),
    rec=st.integers(0, 255),
)


@given(events)
def test_record_round_trip(event: BusEvent) -> None:
    block = event.to_record()
    assert len(block) == record.RECORD_SIZE
    for form in (block, bytearray(block), memoryview(block)):
        assert BusEvent.from_record(form) == event


@given(events)
def test_record_reads_as_vci_wants_it(event: BusEvent) -> None:
    """VCI V4 manual (seed 004) 7.3.14: type in info, error code and CAN_STATUS_ bits first in the data."""
    block = event.to_record()
    data = block[16:]
    assert int.from_bytes(block[:8], "little") == event.timestamp_ns
    assert int.from_bytes(block[8:12], "little") == record.NO_ID
    assert int.from_bytes(block[12:16], "little") == event.kind
    assert data[record.EVENT_ERROR] == event.error
    assert data[record.EVENT_STATUS] == STATUS_OF_STATE[event.state]
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
