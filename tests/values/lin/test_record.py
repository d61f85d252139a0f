"""LIN frames and events as 80 bytes and as LINMSG: layout and round trips."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadFrame
from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind, LinState
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.record import (
    lin_frame_of_record,
    linmsg_of_record,
    message_type,
    record_of_lin_frame,
    record_of_linmsg,
)
from tests.cases import each


@st.composite
def frames(draw: st.DrawFn) -> LinFrame:
    id = draw(st.integers(0, 63))
    header_only = draw(st.booleans())
    model = None if id in (0x3C, 0x3D) else draw(st.sampled_from([None, True, False]))
    return LinFrame(
        id,
        b"" if header_only else draw(st.binary(max_size=8)),
        enhanced=model,
        header_only=header_only,
        length=draw(st.integers(0, 8)) if header_only else None,
        timestamp_ns=draw(st.integers(0, 2**64 - 1)),
        sent=draw(st.booleans()),
        overrun=draw(st.booleans()),
    )


@given(frames())
def test_a_frame_comes_back(frame: LinFrame) -> None:
    record = record_of_lin_frame(frame)
    assert len(record) == 80
    again = lin_frame_of_record(record)
    assert again == frame
    assert (again.timestamp_ns, again.sent, again.overrun) == (frame.timestamp_ns, frame.sent, frame.overrun)
    assert message_type(record) == 0


@pytest.mark.conforms("X4-46")
def test_layout_of_a_frame() -> None:
    record = record_of_lin_frame(LinFrame(0x10, b"\x4a\x55", timestamp_ns=0x1_0000_0002, sent=True))
    time_ns, pid, info = struct.unpack_from("<QII", record)
    assert (time_ns, pid) == (0x1_0000_0002, 0x50)
    assert info == 0x50 | 2 << 16 | 1 << 24 | 1 << 25  # pid, dlen, ecs, sor
    assert record[16:24] == b"\x4a\x55".ljust(8, b"\0")
    assert record[24] == LinFrame(0x10, b"\x4a\x55").checksum
    assert record[25:] == bytes(55)


@pytest.mark.conforms("X4-46")
def test_flags_of_a_header_alone_and_of_an_overrun() -> None:
    record = record_of_lin_frame(LinFrame(0x3D, header_only=True, length=8, overrun=True))
    assert struct.unpack_from("<I", record, 12) == (0x7D | 8 << 16 | 1 << 26 | 1 << 27,)


def test_linmsg() -> None:
    record = record_of_lin_frame(LinFrame(0x10, b"\1\2\3", timestamp_ns=0x1_0000_0005))
    message = linmsg_of_record(record)
    assert message == struct.pack("<II8s", 5, 0x50 | 3 << 16 | 1 << 24, b"\1\2\3")
    assert lin_frame_of_record(record_of_linmsg(message)) == LinFrame(0x10, b"\1\2\3")


@pytest.mark.parametrize("pid", [0x10, 0x50])
def test_a_message_may_leave_the_parity_out(pid: int) -> None:
    record = record_of_linmsg(struct.pack("<II8s", 0, pid | 1 << 16, b"\7"))
    assert lin_frame_of_record(record) == LinFrame(0x10, b"\7", enhanced=False)


@each(
    ("info", "message"),
    [
        (0x90 | 1 << 16, "right parity bits"),
        (0x10 | 9 << 16, "9 bytes"),
        (0x10 | 1 << 8, "message type 1"),
        (0x3C | 8 << 16 | 1 << 24, "classic checksum"),
        (0x10 | 9 << 16 | 1 << 27, "9 bytes"),
    ],
)
def test_bad_messages(info: int, message: str) -> None:
    with pytest.raises(BadFrame, match=message):
        lin_frame_of_record(record_of_linmsg(struct.pack("<II8s", 0, info, bytes(8))))


def test_bad_sizes() -> None:
    with pytest.raises(BadFrame, match="80 bytes, not 79"):
        lin_frame_of_record(bytes(79))
    with pytest.raises(BadFrame, match="16 bytes, not 20"):
        record_of_linmsg(bytes(20))


@given(st.binary(min_size=80, max_size=80))
def test_any_80_bytes_are_a_frame_or_refused(record: bytes) -> None:
    try:
        frame = lin_frame_of_record(record)
    except BadFrame:
        return
    assert lin_frame_of_record(record_of_lin_frame(frame)) == frame


events = st.builds(
    LinEvent,
    kind=st.sampled_from([LinEventKind.ERROR]),
    timestamp_ns=st.integers(0, 2**64 - 1),
    error=st.sampled_from(LinErrorKind),
    state=st.sampled_from(LinState),
    id=st.integers(-1, 63),
    transmitting=st.booleans(),
    status=st.integers(0, 255),
) | st.builds(
    LinEvent,
    kind=st.sampled_from([LinEventKind.INFO, LinEventKind.TIME_OVERRUN]),
    timestamp_ns=st.integers(0, 2**64 - 1),
    state=st.sampled_from(LinState),
    status=st.integers(0, 255),
    code=st.integers(0, 255),
)


@given(events)
def test_an_event_comes_back(event: LinEvent) -> None:
    record = event.to_record()
    assert len(record) == 80
    assert LinEvent.from_record(record) == event
    assert message_type(record) == event.kind


@pytest.mark.conforms("X4-45")
@each(
    ("kind", "number"),
    [
        (LinErrorKind.BIT, 1),
        (LinErrorKind.CHKSUM, 2),
        (LinErrorKind.PARITY, 3),
        (LinErrorKind.SLNORE, 4),
        (LinErrorKind.SYNC, 5),
        (LinErrorKind.NOBUS, 6),
        (LinErrorKind.OTHER, 7),
        (LinErrorKind.WAKEUP, 8),
    ],
)
def test_an_error_message_has_pid_ff_its_number_and_the_status(kind: LinErrorKind, number: int) -> None:
    event = LinEvent(LinEventKind.ERROR, 9, kind, id=0x10, status=0x04)
    time, info, data = struct.unpack("<II8s", linmsg_of_record(event.to_record()))
    assert (time, info & 0xFF, info >> 8 & 0xFF) == (9, 0xFF, 2)
    assert data[:2] == bytes([number, 0x04])


@pytest.mark.conforms("X4-45")
@each("kind", LinEventKind)
def test_every_event_has_pid_ff_and_its_type(kind: LinEventKind) -> None:
    record = LinEvent(kind, code=1).to_record()
    assert (record[8], record[12], record[13]) == (0xFF, 0xFF, int(kind))


def test_a_timer_overrun_tells_its_count_as_length() -> None:
    message = linmsg_of_record(LinEvent(LinEventKind.TIME_OVERRUN, code=3).to_record())
    assert message[6] == 3
