"""Events of the hub as error frames, and the state that an interface shows with them."""

from __future__ import annotations

import numpy
import pytest

import canwire
from canwire import BusEvent, ErrorKind, ErrorState, EventKind
from canwire.socketcan.error_frames import put_error_frames
from canwire.socketcan.wire import received_dtype
from canwire.values.error_frame import BUSOFF


def told_by(*events: BusEvent) -> tuple[list[int], list[ErrorState]]:
    """The identifiers of the error frames of one batch, and the states that were told."""
    records = numpy.frombuffer(b"".join(event.to_record() for event in events), canwire.record_dtype())
    rows = numpy.zeros(len(records), received_dtype())
    told: list[ErrorState] = []
    kept = put_error_frames(records, rows, numpy.ones(len(records), bool), told.append)
    return [int(number) for number in rows["can_id"][kept]], told


@pytest.mark.conforms("N-50")
def test_bus_off_is_shown_before_any_error_frame_that_says_it() -> None:
    """The event of the state may come in the next batch: a program read the error frame, and the carrier was there."""
    error = BusEvent(
        EventKind.ERROR, error=ErrorKind.BIT, state=ErrorState.BUS_OFF, transmitting=True, tec=256
    )
    [number], told = told_by(error)
    assert number & BUSOFF
    assert told == [ErrorState.BUS_OFF]
    assert told_by(error, BusEvent(EventKind.STATE, state=ErrorState.BUS_OFF))[1] == [ErrorState.BUS_OFF] * 2


@pytest.mark.parametrize("kind", [EventKind.ERROR, EventKind.INFO])
def test_other_events_change_no_state(kind: EventKind) -> None:
    """A start's event has the state before it."""
    state = ErrorState.BUS_OFF if kind is EventKind.INFO else ErrorState.ERROR_PASSIVE
    assert told_by(BusEvent(kind, error=ErrorKind.BIT, state=state))[1] == []
