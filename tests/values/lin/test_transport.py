"""LIN's transport layer: frames by hand, whole messages there and back, and what breaks off."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadValue
from canwire.values.lin.transport import (
    FUNCTIONAL_NAD,
    TIMEOUT_NS,
    LinMessage,
    LinReassembly,
    LinTransmission,
    segments,
)
from tests.cases import each

pytestmark = pytest.mark.conforms("N-47")


def test_frames_by_hand() -> None:
    assert segments(0x7F, bytes.fromhex("B200FF7FFFFF")) == [bytes.fromhex("7F06B200FF7FFFFF")]  # V16
    assert segments(0x01, b"\xf0") == [bytes.fromhex("0101F0FFFFFFFFFF")]  # V23
    assert segments(0x02, bytes(range(12))) == [
        bytes.fromhex("02100C0001020304"),
        bytes.fromhex("022105060708090A"),
        bytes.fromhex("02220BFFFFFFFFFF"),
    ]


@given(st.integers(1, 0x7D), st.binary(min_size=1, max_size=4095))
def test_messages_come_out_as_they_went_in(nad: int, payload: bytes) -> None:
    reassembly = LinReassembly()
    found = [reassembly.frame(data, k) for k, data in enumerate(segments(nad, payload))]
    assert found == [None] * (len(found) - 1) + [LinMessage(nad, payload)]
    assert (reassembly.dropped, reassembly.receiving) == (0, False)


def fed(frames: list[bytes], step_ns: int = 10_000_000) -> tuple[list[LinMessage], int]:
    """The messages that came out, and how many broke off."""
    reassembly = LinReassembly()
    found = [reassembly.frame(data, k * step_ns) for k, data in enumerate(frames)]
    return [message for message in found if message is not None], reassembly.dropped


LONG = segments(0x02, bytes(20))  # four frames


def test_what_breaks_a_message_off() -> None:
    assert fed([LONG[0], LONG[2], LONG[3]]) == ([], 1)  # one frame is missing
    assert fed([LONG[0], LONG[1], LONG[1]]) == ([], 1)  # one comes twice
    assert fed(LONG[1:]) == ([], 0)  # there was no first frame
    assert fed([*LONG[:2], *LONG]) == ([LinMessage(0x02, bytes(20))], 1)  # it began anew
    assert fed([bytes.fromhex("0200FFFFFFFFFFFF"), bytes.fromhex("0207FFFFFFFFFFFF")]) == ([], 0)
    assert fed([bytes.fromhex("021005FFFFFFFFFF")]) == ([], 1)  # five bytes would be a single frame


def test_consecutive_frames_come_in_time() -> None:
    assert fed(LONG, TIMEOUT_NS) == ([LinMessage(0x02, bytes(20))], 0)
    assert fed(LONG, TIMEOUT_NS + 1) == ([], 1)


def test_a_functional_request_leaves_a_message_alone() -> None:
    (between,) = segments(FUNCTIONAL_NAD, b"\x3e\x80")
    assert fed([LONG[0], between, *LONG[1:]]) == (
        [LinMessage(FUNCTIONAL_NAD, b"\x3e\x80"), LinMessage(0x02, bytes(20))],
        0,
    )


def test_a_transmission_waits_and_gives_up() -> None:
    sending = LinTransmission(LinMessage(0x02, bytes(10)), ready_ns=100, timeout_ns=1_000)
    assert sending.waiting(99) is None
    assert sending.waiting(100) == sending.waiting(1_100) == bytes.fromhex("02100A0000000000")
    assert sending.waiting(1_101) is None  # N_As
    sending.fetched(1_000)
    assert sending.waiting(2_000) == bytes.fromhex("02210000000000FF")
    sending.fetched(2_000)
    assert sending.waiting(2_000) is None


@each(
    ("nad", "payload", "why"),
    [
        (0x100, b"1", "NAD 256"),
        (1, b"", "0 bytes"),
        (1, bytes(4096), "4096 bytes"),
        (0x7E, bytes(7), "single frame"),
    ],
)
def test_what_is_no_message(nad: int, payload: bytes, why: str) -> None:
    with pytest.raises(BadValue, match=why):
        segments(nad, payload)
