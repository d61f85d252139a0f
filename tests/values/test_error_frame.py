"""Events as SocketCAN error frames: bits of linux/can/error.h, round trips, other people's frames."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from canwire.errors import BadText
from canwire.values.error_frame import decode_error_frame, encode_error_frame
from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind
from canwire.values.screen_text import format_candump_line, parse_candump_line
from canwire.values.text import LogLine, format_content, format_log_line, parse_content, parse_log_line
from tests.cases import each


@st.composite
def events(draw: st.DrawFn) -> BusEvent:
    """Events of which an error frame keeps everything."""
    kind = draw(st.sampled_from([kind for kind in EventKind if kind is not EventKind.TIME_OVERRUN]))
    states = [
        state
        for state in ErrorState
        if kind not in (EventKind.ERROR, EventKind.ARBITRATION_LOST, EventKind.OVERRUN)
        or state is not ErrorState.STOPPED
    ]
    error = ErrorKind.NONE
    if kind is EventKind.ERROR:
        error = draw(
            st.sampled_from([e for e in ErrorKind if e not in (ErrorKind.NONE, ErrorKind.FAST_DATA_BIT)])
        )
    sends = error is ErrorKind.ACK or kind is EventKind.ARBITRATION_LOST
    state = draw(st.sampled_from(states))
    return BusEvent(
        kind,
        timestamp_ns=draw(st.integers(0, 2**63 // 1000)) * 1000,
        error=error,
        state=state,
        bit=draw(st.integers(0, 31)) if kind is EventKind.ARBITRATION_LOST else -1,
        transmitting=sends or draw(st.booleans()),
        tec=256 if state is ErrorState.BUS_OFF else draw(st.integers(0, 255)),
        rec=draw(st.integers(0, 255)),
    )


@given(events())
@example(BusEvent(EventKind.ABORTED, state=ErrorState.BUS_OFF, tec=256))
@example(BusEvent(EventKind.STATE, state=ErrorState.STOPPED))
def test_events_come_back(event: BusEvent) -> None:
    line = LogLine(event.timestamp_ns, "can0", event)
    assert parse_log_line(format_log_line(line)) == line
    assert parse_content(format_content(event), event.timestamp_ns) == event
    assert parse_candump_line(format_candump_line(line, timestamp=True)) == line


@given(st.integers(0, 0x3FF), st.binary(max_size=8))
def test_foreign_error_frames_settle(classes: int, data: bytes) -> None:
    """What is read of any error frame is written and read again unchanged."""
    try:
        event = decode_error_frame(0x20000000 | classes, data)
    except BadText:
        assert not classes & ~0x200
        return
    assert decode_error_frame(*encode_error_frame(event)) == event


@each(
    ("event", "text"),
    [  # classes and bits of linux/can/error.h, written out by hand
        (BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, rec=1), "20000288#0000040000000001"),
        (BusEvent(EventKind.ERROR, error=ErrorKind.FORM), "20000088#0000020000000000"),
        (
            BusEvent(EventKind.ERROR, error=ErrorKind.BIT, transmitting=True, tec=8),
            "20000288#0000810000000800",
        ),
        (BusEvent(EventKind.ERROR, error=ErrorKind.CRC), "20000088#0000000800000000"),
        (BusEvent(EventKind.ERROR, error=ErrorKind.ACK, transmitting=True), "200000A0#0000801900000000"),
        (
            BusEvent(EventKind.STATE, state=ErrorState.ERROR_WARNING, tec=96),
            "20000204#0008000000006000",
        ),
        (
            BusEvent(EventKind.STATE, state=ErrorState.ERROR_PASSIVE, tec=1, rec=128),
            "20000204#0010000000000180",
        ),
        (BusEvent(EventKind.STATE), "20000004#0040000000000000"),
        (BusEvent(EventKind.STATE, state=ErrorState.BUS_OFF, tec=256), "20000240#000000000000FF00"),
        (BusEvent(EventKind.ARBITRATION_LOST, bit=11, transmitting=True), "20000002#0B00800000000000"),
        (BusEvent(EventKind.INFO), "20000100#0000000000000000"),
        (BusEvent(EventKind.OVERRUN), "20000004#0001000000000000"),
    ],
)
def test_error_frames_use_socketcans_classes(event: BusEvent, text: str) -> None:
    assert format_content(event) == text
    assert parse_content(text) == event


def test_error_frames_of_others() -> None:
    assert parse_content("20000080#") == BusEvent(EventKind.ERROR, error=ErrorKind.OTHER)  # python-can's
    sja1000 = parse_content(
        "2000008C#000804030000601F"
    )  # Linux's sja1000 driver: warning and stuff error at once
    assert isinstance(sja1000, BusEvent)
    assert (sja1000.error, sja1000.state) == (ErrorKind.STUFF, ErrorState.ERROR_WARNING)
    overflow = parse_content("20000004#0002000000000000")  # of a transmit queue
    assert isinstance(overflow, BusEvent)
    assert (overflow.kind, overflow.error) == (EventKind.ERROR, ErrorKind.OTHER)
