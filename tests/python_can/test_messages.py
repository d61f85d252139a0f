"""Frames as messages and back; what is lost is nothing."""

from __future__ import annotations

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadFrame, BusEvent, ErrorKind, ErrorState, EventKind, Frame, decode_error_frame
from canwire.python_can.messages import record_of, take_messages
from canwire.values.frame import frame_of_record, record_of_frame, record_to_send
from canwire.values.record import OVERRUN, SELF_RECEPTION
from tests.cases import each

LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    kind = draw(st.sampled_from(["data", "remote", "fd", "long dlc"]))
    if kind == "remote":
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 15)))
    if kind == "long dlc":
        data = draw(st.binary(min_size=8, max_size=8))
        return Frame(id, data, extended=extended, dlc=draw(st.integers(8, 15)))
    length = draw(st.sampled_from(LENGTHS if kind == "fd" else LENGTHS[:9]))
    data = draw(st.binary(min_size=length, max_size=length))
    if kind == "data":
        return Frame(id, data, extended=extended)
    flags = {name: draw(st.booleans()) for name in ("bit_rate_switch", "error_state_indicator")}
    return Frame(id, data, extended=extended, fd=True, **flags)


def messages(record: bytes, *, errors: bool = True) -> list[can.Message]:
    found: list[can.Message] = []
    take_messages(memoryview(record), 10**18, "can0", found.append, [].append, errors=errors)
    return found


@given(frames())
def test_there_and_back(frame: Frame) -> None:
    (message,) = messages(record_of_frame(frame))
    assert frame_of_record(record_of(message)) == frame


@given(frames())
def test_a_message_is_what_python_can_would_make_of_it(frame: Frame) -> None:
    (message,) = messages(record_of_frame(frame))
    made = can.Message(
        timestamp=message.timestamp,
        arbitration_id=frame.id,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        dlc=len(frame.data) if frame.fd else frame.dlc,
        data=frame.data,
        is_fd=frame.fd,
        bitrate_switch=frame.bit_rate_switch,
        error_state_indicator=frame.error_state_indicator,
        channel="can0",
        check=frame.dlc <= 8 or frame.fd,
    )
    assert message.equals(made)
    assert set(can.Message.__slots__) - {"__weakref__"} == {
        name for name in can.Message.__slots__ if name != "__weakref__" and hasattr(message, name)
    }


def test_own_ones_and_times() -> None:
    record = bytearray(record_to_send(Frame(1), SELF_RECEPTION, 2_500_000_000))
    (message,) = messages(bytes(record))
    assert not message.is_rx
    assert message.timestamp == 1e9 + 2.5


def test_what_was_lost_is_told_before_what_came_after() -> None:
    lost, message = messages(record_to_send(Frame(1), OVERRUN, 0))
    assert (lost.is_error_frame, lost.arbitration_id, lost.data[1]) == (True, 4, 1)
    assert message.arbitration_id == 1
    assert len(messages(record_to_send(Frame(1), OVERRUN, 0), errors=False)) == 1


def test_events_are_socketcan_s_error_frames() -> None:
    event = BusEvent(EventKind.ERROR, 5, ErrorKind.STUFF, ErrorState.ERROR_PASSIVE, 3, True, 130, 7)
    (message,) = messages(event.to_record())
    assert message.is_error_frame
    assert not message.is_extended_id
    assert message.dlc == 8
    found = decode_error_frame(message.arbitration_id, bytes(message.data))
    assert (found.kind, found.error, found.state) == (
        EventKind.ERROR,
        ErrorKind.STUFF,
        ErrorState.ERROR_PASSIVE,
    )
    assert (found.tec, found.rec) == (130, 7)


def test_the_dlc_says_how_long_a_message_is() -> None:
    short = can.Message(arbitration_id=1, is_extended_id=False, data=[1, 2, 3], dlc=2)
    long = can.Message(arbitration_id=1, is_extended_id=False, data=[1, 2, 3], dlc=5)
    fd = can.Message(arbitration_id=1, is_extended_id=False, data=bytes(9), is_fd=True)
    assert frame_of_record(record_of(short)) == Frame(1, b"\1\2")
    assert frame_of_record(record_of(long)) == Frame(1, b"\1\2\3\0\0")
    assert frame_of_record(record_of(fd)) == Frame(1, bytes(12), fd=True)


@each(
    "wrong",
    [
        can.Message(arbitration_id=0x800, is_extended_id=False),
        can.Message(arbitration_id=1 << 29),
        can.Message(arbitration_id=-1),
        can.Message(is_error_frame=True),
        can.Message(is_fd=True, is_remote_frame=True),
        can.Message(is_fd=True, dlc=65),
        can.Message(dlc=16),
        can.Message(dlc=-1),
    ],
    ids=str,
)
def test_what_no_bus_could_carry(wrong: can.Message) -> None:
    with pytest.raises(BadFrame):
        record_of(wrong)


def test_an_fd_message_needs_an_fd_bus() -> None:
    with pytest.raises(BadFrame, match="fd=True"):
        record_of(can.Message(is_fd=True), fd=False)
