"""CAN_RAW's filters (linux/can/raw.h; networking/can.rst 4.1.1) and whose frames come back."""

from __future__ import annotations

import struct

import pytest

from canwire import Frame, frames_to_array
from canwire.socketcan.constants import CAN_EFF_FLAG, CAN_ERR_FLAG, CAN_INV_FILTER, CAN_RTR_FLAG
from canwire.socketcan.echoes import NOBODY, Echoes
from canwire.socketcan.filters import Filters
from canwire.socketcan.wire import SELF_RECEPTION, numpy_module
from tests.cases import each

IDS = [0x123, 0x124, 0x123 | CAN_RTR_FLAG, 0x123 | CAN_EFF_FLAG, 0x1FFF_F123 | CAN_EFF_FLAG]


def passing(*words: tuple[int, int], joined: bool = False) -> list[int]:
    data = b"".join(struct.pack("<II", *pair) for pair in words)
    ids = numpy_module().array(IDS, "u4")
    mask = Filters.parse(data, joined).passing(ids)
    return IDS if mask is None else ids[mask].tolist()


@pytest.mark.conforms("PC-03", "N-22")
@each(
    ("words", "joined", "wanted"),
    [
        ([(0, 0)], False, IDS),
        ([], False, []),
        ([(0x123, 0x7FF)], False, [IDS[0], IDS[2], IDS[3], IDS[4]]),
        ([(0x123, 0x7FF | CAN_EFF_FLAG | CAN_RTR_FLAG)], False, [IDS[0]]),
        ([(0x123, 0x1FFF_FFFF | CAN_EFF_FLAG)], False, [IDS[0], IDS[2]]),  # a long mask on a short identifier
        ([(0x123 | CAN_EFF_FLAG, 0x1FFF_FFFF | CAN_EFF_FLAG)], False, [IDS[3]]),
        ([(0x123 | CAN_INV_FILTER, 0x7FF)], False, [IDS[1]]),
        ([(0x120, 0x7F0), (0x123 | CAN_INV_FILTER, 0x7FF)], True, [IDS[1]]),
        ([(0, 0), (0x123 | CAN_INV_FILTER, 0x7FF)], True, [IDS[1]]),
        ([(0, 0), (0x123 | CAN_INV_FILTER, 0x7FF)], False, IDS),
        ([(0 | CAN_INV_FILTER, 0)], False, []),
        ([(0, CAN_ERR_FLAG | 0xFF)], False, []),  # about error frames alone
    ],
)
def test_what_passes(words: list[tuple[int, int]], joined: bool, wanted: list[int]) -> None:
    assert passing(*words, joined=joined) == wanted


def test_a_filter_for_errors_is_part_of_the_error_mask() -> None:
    filters = Filters.parse(struct.pack("<IIII", 0, 0, 0, CAN_ERR_FLAG | 0x44), joined=False)
    assert filters.error_mask() == 0x44


def test_half_a_filter() -> None:
    with pytest.raises(ValueError, match="12 bytes"):
        Filters.parse(bytes(12), joined=False)


def records(*ids: int, own: bool = False) -> object:
    found = frames_to_array([Frame(id, b"\x01") for id in ids])
    if own:
        found["info"] |= SELF_RECEPTION
    return found


def test_frames_that_come_back_are_their_senders() -> None:
    echoes = Echoes()
    echoes.sent(3, records(1, 2))
    echoes.sent(4, records(3))
    assert echoes.owners(records(9)).tolist() == [NOBODY]  # from elsewhere on the bus
    assert echoes.owners(records(1, own=True)).tolist() == [3]
    assert echoes.owners(records(2, 3, own=True)).tolist() == [3, 4]
    assert echoes.outstanding == 0


def test_a_frame_that_was_given_up_does_not_keep_the_others_from_their_senders() -> None:
    echoes = Echoes()
    echoes.sent(3, records(1, 2))
    echoes.sent(4, records(5))
    assert echoes.owners(records(7, 5, own=True)).tolist() == [
        NOBODY,
        4,
    ]  # 7: of another program on this line
    assert echoes.outstanding == 0
