"""socketcand's commands and answers as text, held against the protocol's own examples."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadText
from canwire.socketcan.bcm.message import RX_DELETE, RX_SETUP, TX_DELETE, TX_SETUP
from canwire.socketcan.constants import CAN_EFF_FLAG, CAN_RTR_FLAG
from canwire.socketcan.daemon.words import heard, request, sent_frame
from tests.cases import each

SENT = [  # doc/protocol.md's examples first
    ("send 123 0", "23010000 00 000000 0000000000000000"),
    ("send 1AAAAAAA 2 1 F1", "AAAAAA9A 02 000000 01F1000000000000"),
    ("sendrtr 123 0", "23010040 00 000000 0000000000000000"),
    ("sendrtr 1AAAAAAA 2", "AAAAAADA 02 000000 0000000000000000"),
    ("fdsend 123 1 2 11 22", "23010000 02 01 0000 1122" + "00" * 62),
]


@each(("text", "expected"), SENT)
def test_frames_to_send(text: str, expected: str) -> None:
    assert sent_frame(text.split()) == bytes.fromhex(expected)


def test_jobs() -> None:
    job = request(["add", "1", "0", "123", "8", "11", "22", "33", "44", "55", "66", "77", "88"])
    assert (job.opcode, job.interval2_s, job.can_id) == (TX_SETUP, 1.0, 0x123)
    assert job.frames[0][8:] == bytes.fromhex("1122334455667788")
    assert request(["add", "0", "20000", "123", "4", "42", "42", "42", "42"]).interval2_s == 0.02
    assert request(["update", "123", "3", "11", "22", "33"]).flags == 0
    assert request(["delete", "123"]).opcode == TX_DELETE
    throttled = request(["filter", "1", "500000", "123", "8", "FF", "00", "F8", "00", "00", "00", "00", "00"])
    assert (throttled.opcode, throttled.interval2_s) == (RX_SETUP, 1.5)
    mux = request(
        [
            "muxfilter",
            "0",
            "0",
            "123",
            "2",
            "FF",
            "00",
            "00",
            "00",
            "00",
            "00",
            "00",
            "00",
            "33",
            "FF",
            "FF",
            "FF",
            "FF",
            "FF",
            "FF",
            "FF",
        ]
    )
    assert [frame[8] for frame in mux.frames] == [0xFF, 0x33]
    assert request(["subscribe", "0", "0", "12345678"]).can_id == 0x12345678 | CAN_EFF_FLAG
    assert request(["unsubscribe", "123"]).opcode == RX_DELETE


WRONG = [
    "send", "send 123", "send 123 9 1 2 3 4 5 6 7 8 9", "send 123 2 1", "send 123 1 1 2", "send 800 0", "send xyz 0",
    "send 123456789 0", "send 123 1 100", "send 123 -1", "send 20000000 0", "sendrtr 123 9", "fdsend 123 1 65",
    "fdsend 123 100 0", "add 1 0 123", "add x 0 123 0", "add 1 1000000 123 0", "muxfilter 0 0 123 1 FF",
    "muxfilter 0 0 123 2 FF", "delete", "nonsense", "filter 0 0 123 1",
]  # fmt: skip


@each("text", WRONG)
def test_what_is_no_command(text: str) -> None:
    words = text.split()
    with pytest.raises(BadText):
        (sent_frame if words[0] in ("sendrtr", "fdsend") else request)(words)


def test_what_is_heard() -> None:
    frame = sent_frame(["send", "123", "4", "11", "22", "33", "44"])
    assert heard(frame, 23_424_242_000, apart=False) == "< frame 123 23.424242 11223344 >"
    assert heard(frame, 23_424_242_999, apart=True) == "< frame 123 23.424242 11 22 33 44  >"
    assert heard(sent_frame(["send", "1AAAAAAA", "0"]), 0, apart=False) == "< frame 1AAAAAAA 0.000000  >"
    assert (
        heard(sent_frame(["sendrtr", "123", "4"]), 23_424_242_000, apart=False) == "< rtr 123 23.424242 4 >"
    )
    assert (
        heard(sent_frame(["fdsend", "123", "1", "1", "AB"]), 0, apart=False)
        == "< fdframe 123 01 0.000000 AB >"
    )
    assert heard(bytes.fromhex("04000020" + "08" + "00" * 11), 0, apart=False) == "< error 004 0.000000 >"


@given(
    st.lists(
        st.sampled_from(["send", "fdsend", "add", "123", "0", "1", "FF", "12345678", "filter", "x"]),
        min_size=1,
        max_size=20,
    )
)
def test_any_words_are_a_request_or_bad_text(words: list[str]) -> None:
    for parse in (request, sent_frame):
        with suppress(BadText):
            assert parse(words)


@given(st.integers(0, 0x1FFFFFFF), st.booleans(), st.binary(max_size=8))
def test_what_is_sent_is_heard_so(id: int, extended: bool, data: bytes) -> None:
    name = f"{id:08X}" if extended else f"{id & 0x7FF:03X}"
    frame = sent_frame(["send", name, str(len(data)), *(f"{byte:x}" for byte in data)])
    assert heard(frame, 0, apart=False) == f"< frame {name} 0.000000 {data.hex().upper()} >"
    assert not int.from_bytes(frame[:4], "little") & CAN_RTR_FLAG
