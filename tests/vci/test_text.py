"""LUID and GUID texts: VCI V4 manual 6.1.5 to 6.1.8."""

from __future__ import annotations

from uuid import UUID

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.vci.structures.devices import VciId
from canwire.vci.structures.errors import VciBufferOverflow, VciFail, VciInvalidArgument
from canwire.vci.structures.guids import IID_ICanChannel2
from canwire.vci.text import char_to_guid, char_to_luid, guid_to_char, luid_to_char
from tests.cases import each

CHANNEL = "{F2528F90-3A10-46D0-8F82-0871C1E7DBB9}"


@pytest.mark.conforms("X4-03")
@given(st.integers(-(2**63), 2**63 - 1))
def test_luid_round_trip(number: int) -> None:
    text = luid_to_char(VciId(number))
    assert len(text) == 16
    assert char_to_luid(text) == char_to_luid(text.lower()) == VciId(number)


@pytest.mark.conforms("X4-03")
@given(st.uuids())
def test_guid_round_trip(value: UUID) -> None:
    text = guid_to_char(value)
    assert len(text) == 38
    assert char_to_guid(text) == char_to_guid(text.lower()) == value


def test_known_texts() -> None:
    number = VciId()
    number.low_part, number.high_part = 0xDEADBEEF, 0x12
    assert luid_to_char(number) == "00000012DEADBEEF"
    assert luid_to_char(VciId(-1)) == "FFFFFFFFFFFFFFFF"
    assert guid_to_char(IID_ICanChannel2) == CHANNEL
    assert char_to_guid(CHANNEL) == IID_ICanChannel2


@pytest.mark.conforms("X4-03")
def test_short_buffers_are_refused() -> None:
    """At least 17 and 39 characters, the final NUL included."""
    assert luid_to_char(VciId(), 17) == "0" * 16
    assert guid_to_char(IID_ICanChannel2, 39) == CHANNEL
    for size in (16, 0, -1):
        with pytest.raises(VciBufferOverflow):
            luid_to_char(VciId(), size)
    for size in (38, 17, 0):
        with pytest.raises(VciBufferOverflow):
            guid_to_char(IID_ICanChannel2, size)


@pytest.mark.conforms("X4-03")
@each(
    "text", ["", "0", "0" * 15, "0" * 17, "000000000000000G", "0x00000000000000", " 000000000000000", "0" * 16 + "\n",
             "+000000000000001", "0_00000000000001", "０" * 16]
)  # fmt: skip
def test_malformed_luids_are_refused(text: str) -> None:
    with pytest.raises(VciFail):
        char_to_luid(text)


@pytest.mark.conforms("X4-03")
@each(
    "text", ["", CHANNEL[1:-1], CHANNEL[:-1], CHANNEL[1:], CHANNEL.replace("-", ""), CHANNEL.replace("F", "G"),
             CHANNEL + " ", f"({CHANNEL[1:-1]})", CHANNEL.replace("2528F90-", "2528-F90"), CHANNEL + "\n"]
)  # fmt: skip
def test_malformed_guids_are_refused(text: str) -> None:
    with pytest.raises(VciFail):
        char_to_guid(text)


@given(st.text(max_size=40).filter(lambda text: "{" not in text and len(text) != 16))
def test_any_other_text_is_refused_in_few_words(text: str) -> None:
    for read in (char_to_luid, char_to_guid):
        with pytest.raises(VciFail) as caught:
            read(text)
        assert len(str(caught.value)) < 256


def test_a_nul_ends_the_text_as_in_c() -> None:
    assert char_to_luid("0000000000000001\0rest") == VciId(1)
    assert char_to_guid(CHANNEL + "\0") == IID_ICanChannel2


@pytest.mark.conforms("X4-03")
@each("wrong", [None, 1, b"0000000000000001", 1.5])
def test_wrong_types_are_invalid_arguments(wrong: object) -> None:
    for call in (char_to_luid, char_to_guid, luid_to_char, guid_to_char):
        with pytest.raises(VciInvalidArgument):
            call(wrong)  # type: ignore[arg-type]
    with pytest.raises(VciInvalidArgument):
        luid_to_char(VciId(), "17")  # type: ignore[arg-type]
