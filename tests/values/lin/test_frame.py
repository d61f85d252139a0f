"""LIN frames: what exists is legal; identifiers and checksums as the tables of the reference have them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.errors import BadFrame
from canwire.values.lin.frame import (
    LinFrame,
    checked_id,
    go_to_sleep_frame,
    is_go_to_sleep,
    lin_checksum,
    parity_holds,
    protected_id,
)
from tests.cases import each
from tests.tables import lin_vectors

ids = st.integers(0, 63)
payloads = st.binary(max_size=8)


@pytest.mark.conforms("X4-46")
def test_protected_identifiers() -> None:
    assert [protected_id(id) for id in range(64)] == lin_vectors.pids()


def test_any_single_bit_change_of_a_protected_identifier_is_noticed() -> None:
    for id in range(64):
        assert parity_holds(protected_id(id))
        assert not any(parity_holds(protected_id(id) ^ 1 << bit) for bit in range(8))


@pytest.mark.conforms("X4-46")
@each(("name", "id", "data", "classic", "enhanced"), lin_vectors.CHECKSUMS)
def test_checksums(name: str, id: int, data: str, classic: int, enhanced: int) -> None:
    payload = bytes.fromhex(data)
    assert lin_checksum(payload) == classic
    assert lin_checksum(payload, protected_id(id)) == enhanced
    assert LinFrame(id, payload).checksum == (classic if id >= 0x3C else enhanced)
    assert LinFrame(id, payload, enhanced=False).checksum == classic


@given(id=ids, data=payloads.filter(len))
def test_a_receiver_s_sum_with_carry_is_all_ones(id: int, data: bytes) -> None:
    for pid in (0, protected_id(id)):
        total = 0
        for octet in (*([pid] if pid else []), *data):
            total += octet
            total -= 255 if total > 255 else 0
        assert total + lin_checksum(data, pid) == 255


@pytest.mark.conforms("X4-46")
@pytest.mark.parametrize("id", [0x3C, 0x3D])
def test_diagnostic_frames_are_classic_always(id: int) -> None:
    assert not LinFrame(id, bytes(8)).enhanced
    with pytest.raises(BadFrame, match="diagnostic frames always have the classic checksum"):
        LinFrame(id, bytes(8), enhanced=True)


def test_the_usual_model() -> None:
    assert LinFrame(0x3B, b"\1").enhanced
    assert not LinFrame(0x3E, b"\1").enhanced
    assert LinFrame(0x3F, b"\1", enhanced=True).enhanced


@each(
    ("make", "message"),
    [
        (lambda: LinFrame(64), "identifier 0x40: a whole number from 0 to 0x3F"),
        (lambda: LinFrame(-1), "identifier -0x1"),
        (lambda: LinFrame("1"), "identifier '1'"),
        (lambda: LinFrame(1, bytes(9)), "9 bytes: a LIN frame carries at most 8"),
        (lambda: LinFrame(1, [256]), "data .256."),
        (lambda: LinFrame(1, 5), "data 5 is not bytes"),
        (lambda: LinFrame(1, b"\1", header_only=True), "a header alone has no data"),
        (lambda: LinFrame(1, header_only=True, length=9), "length 9: from 1 to 8"),
        (lambda: LinFrame(1, b"\1", length=2), "length 2, but data has 1 bytes"),
        (lambda: LinFrame(1, timestamp_ns=-1), "timestamp_ns -1"),
        (lambda: LinFrame(1, timestamp_ns=1 << 64), "timestamp_ns"),
    ],
)
def test_what_no_frame_can_be(make: object, message: str) -> None:
    with pytest.raises(BadFrame, match=message):
        make()  # type: ignore[operator]


def test_a_header_alone() -> None:
    header = LinFrame(0x10, header_only=True, length=2)
    assert (header.data, header.length, header.header_only) == (b"", 2, True)
    assert LinFrame(0x10, header_only=True).length == 0
    assert header != LinFrame(0x10)


def test_what_a_receiver_adds_takes_no_part_in_comparisons() -> None:
    heard = LinFrame(0x10, b"\1", timestamp_ns=5, sent=True, overrun=True)
    assert heard == LinFrame(0x10, b"\1")
    assert hash(heard) == hash(LinFrame(0x10, b"\1"))
    assert heard != LinFrame(0x10, b"\1", enhanced=False)
    assert heard != "10#01"


@given(id=ids, data=payloads, sent=st.booleans(), at_ns=st.integers(0, 2**64 - 1), classic=st.booleans())
def test_repr_is_a_frame_again(id: int, data: bytes, sent: bool, at_ns: int, classic: bool) -> None:
    frame = LinFrame(id, data, sent=sent, timestamp_ns=at_ns, enhanced=False if classic else None)
    again = eval(repr(frame))
    assert again == frame
    assert (again.sent, again.timestamp_ns) == (sent, at_ns)


def test_repr() -> None:
    assert (
        repr(LinFrame(0x10, b"\1\2", timestamp_ns=7))
        == 'LinFrame(0x10, bytes.fromhex("0102"), timestamp_ns=7)'
    )
    assert repr(LinFrame(1, header_only=True, length=4)) == "LinFrame(0x01, header_only=True, length=4)"


def test_frames_are_frozen() -> None:
    with pytest.raises(AttributeError):
        LinFrame(1).id = 2  # type: ignore[misc]


def test_go_to_sleep() -> None:
    frame = go_to_sleep_frame()
    assert (frame.id, frame.data.hex(), frame.checksum) == (0x3C, "00ffffffffffffff", 0)
    assert is_go_to_sleep(0x3C, bytes.fromhex("0001020304050607"))
    assert not is_go_to_sleep(0x3D, frame.data)
    assert not is_go_to_sleep(0x3C, b"\x01")


@each(("value", "id"), [(0x10, 0x10), (0x50, 0x10), (0xBF, 0x3F), (0x3C, 0x3C)])
def test_an_identifier_with_parity_or_without(value: int, id: int) -> None:
    assert checked_id(value) == id


@each("value", [0x40, 0x90, 0xFF, 0x100, 0x150])
def test_an_identifier_with_wrong_parity(value: int) -> None:
    with pytest.raises(BadFrame, match="right parity bits"):
        checked_id(value)
