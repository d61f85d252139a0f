"""Records packed for the network: any of them come back, frames take few bytes, and nothing hostile gets through."""

from __future__ import annotations

import random
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadMessage, Frame, frames_to_array
from canwire.values.packed_records import pack, unpack
from canwire.values.record import RECORD_SIZE
from tests.cases import each
from tests.effort import examples

pytestmark = [pytest.mark.core, pytest.mark.finding("machines 10")]
NUMBERS = {
    bits: st.one_of(st.integers(0, 300), st.integers(0, 2**bits - 1), st.integers(2**bits - 300, 2**bits - 1))
    for bits in (32, 64)
}
RECORDS = st.lists(
    st.builds(
        lambda stamp, identifier, info, data: struct.pack("<QII64s", stamp, identifier, info, data),
        NUMBERS[64],
        NUMBERS[32],
        NUMBERS[32],
        st.one_of(st.binary(max_size=8), st.binary(max_size=64)),
    ),
    max_size=12,
)


@examples(200)
@given(RECORDS)
def test_any_records_come_out_as_they_went_in(records: list[bytes]) -> None:
    whole = bytearray(b"".join(records))
    assert unpack(pack(whole)) == whole


@examples(200)
@given(
    st.one_of(st.binary(max_size=120), st.binary(max_size=100).map(lambda rest: b"\2\0\1" + bytes(8) + rest))
)
def test_what_nobody_packed_is_refused_or_is_records(packed: bytes) -> None:
    try:
        records = unpack(packed)
    except BadMessage:
        return
    assert len(records) <= RECORD_SIZE * len(packed) // 4
    assert unpack(pack(records)) == records


def test_each_end_that_is_missing_and_each_byte_too_many_is_refused() -> None:
    packed = pack(
        bytearray(frames_to_array([Frame(1, b"\1\2\3"), Frame(1 << 20, b"", extended=True)]).tobytes())
    )
    for length in range(len(packed)):
        with pytest.raises(BadMessage, match="bytes of packed records"):
            unpack(packed[:length])
    with pytest.raises(BadMessage, match="1 bytes too many behind 2 packed records"):
        unpack(packed + b"\0")


@each(("fd", "extended", "most"), [(False, False, 15), (False, True, 17), (True, True, 73)])
def test_frames_of_a_batch_take_few_bytes(fd: bool, extended: bool, most: int) -> None:
    chance = random.Random(1)
    frames = [
        Frame(
            chance.getrandbits(28 if extended else 11),
            chance.randbytes(64 if fd else 8),
            extended=extended,
            fd=fd,
        )
        for _ in range(64)
    ]
    array = frames_to_array(frames)
    array["time_ns"] = [10**18 + 230_000 * number + 2_000 * chance.randrange(20) for number in range(64)]
    packed = pack(bytearray(array.tobytes()))
    assert len(packed) / 64 <= most
    assert unpack(packed) == array.tobytes()
