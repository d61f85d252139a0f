"""The two-stage message filter of the control unit."""

from __future__ import annotations

from typing import Any

import pytest

from canwire.vci import v3
from tests.vci.v3.programs import NetProgram

STD, EXT = v3.CanFilter.STD, v3.CanFilter.EXT
NONE, ALL = v3.CanAccCode.NONE, v3.CanAccCode.ALL
NO_MASK, ALL_MASK = v3.CanAccMask.NONE, v3.CanAccMask.ALL
ONE_STD, ONE_EXT = 0xFFF, 0x3FFFFFFF
END = 0x7FF  # a data message with this 29-bit identifier comes through in every test


@pytest.fixture
def filtered(net: NetProgram, message: Any) -> Any:
    """Sets filters by calls, then tells which messages come through."""
    control = net.control(1)
    net.start(0)
    sender, receiver = net.port(0, tx=400), net.port(1, rx=400)

    def through(*sent: v3.CanMessage) -> list[tuple[int, bool, int]]:
        control.add_filter_ids(EXT, END << 1, ONE_EXT)
        control.start_line()
        sender.send(*sent, message(END, extended_frame_format=True))
        found = []
        while True:
            (one,) = receiver.receive()
            if one.extended_frame_format and one.identifier == END:
                control.stop_line()
                return found
            found.append((one.identifier, one.remote_transmission_request, int(one.accept_reason)))

    through.control = control  # type: ignore[attr-defined]
    return through


def both_kinds(message: Any, *identifiers: int) -> list[v3.CanMessage]:
    return [
        message(one, remote_transmission_request=remote) for one in identifiers for remote in (False, True)
    ]


@pytest.mark.conforms("X3-26")
def test_the_manual_s_example_passes_four_identifiers(filtered: Any, message: Any) -> None:
    code, mask = 0b001_0000_0000_0, 0b111_1111_1100_1
    filtered.control.set_acc_filter(STD, code << 0, mask)
    sent = both_kinds(message, 0x0FF, 0x100, 0x101, 0x102, 0x103, 0x104, 0x500)
    assert filtered(*sent) == [(one, False, 1) for one in range(0x100, 0x104)]


@pytest.mark.conforms("X3-26")
def test_the_second_stage_takes_what_the_first_left(filtered: Any, message: Any) -> None:
    filtered.control.set_acc_filter(STD, 0x100 << 1, ONE_STD)
    filtered.control.add_filter_ids(STD, 0x200 << 1 | 1, ONE_STD)
    assert filtered(*both_kinds(message, 0x100, 0x200, 0x300)) == [(0x100, False, 1), (0x200, True, 2)]


@pytest.mark.conforms("X3-26")
def test_11_and_29_bits_are_filtered_apart(filtered: Any, message: Any) -> None:
    filtered.control.set_acc_filter(EXT, NONE, NO_MASK)
    filtered.control.add_filter_ids(EXT, 0x1FFFFFFF << 1, ONE_EXT)
    extended = [message(one, extended_frame_format=True) for one in (0x100, 0x1FFFFFFE, 0x1FFFFFFF)]
    assert filtered(message(0x100), *extended) == [(0x100, False, 1), (0x1FFFFFFF, False, 2)]


@pytest.mark.conforms("X3-27")
def test_groups_go_on_the_list_and_off_it(filtered: Any, message: Any) -> None:
    filtered.control.set_acc_filter(STD, NONE, NO_MASK)
    filtered.control.add_filter_ids(STD, 0x100 << 1, 0b111_1111_1100_1)
    filtered.control.rem_filter_ids(STD, 0x102 << 1, 0b111_1111_1111_0)
    sent = both_kinds(message, *range(0xFE, 0x106))
    assert filtered(*sent) == [(one, False, 2) for one in (0x100, 0x101, 0x103)]


@pytest.mark.conforms("X3-27")
def test_a_list_holds_all_11_bit_identifiers_with_and_without_rtr(filtered: Any, message: Any) -> None:
    filtered.control.set_acc_filter(STD, NONE, NO_MASK)
    filtered.control.add_filter_ids(STD, ALL, ALL_MASK)
    sent = both_kinds(message, 0, 1, 0x3FF, 0x7FF)
    assert filtered(*sent) == [(one.identifier, one.remote_transmission_request, 2) for one in sent]


@pytest.mark.conforms("X3-27")
def test_a_list_of_29_bits_holds_4096_entries(filtered: Any) -> None:
    low_12_free = ONE_EXT & ~0xFFF
    filtered.control.add_filter_ids(EXT, 0x5000, low_12_free)
    with pytest.raises(v3.VciException):
        filtered.control.add_filter_ids(EXT, 0x10000, ONE_EXT)
    filtered.control.rem_filter_ids(EXT, 0x5000, ONE_EXT)
    filtered.control.add_filter_ids(EXT, 0x10000, ONE_EXT)
    filtered.control.rem_filter_ids(EXT, ALL, ALL_MASK)


@pytest.mark.conforms("X3-28")
def test_filters_change_offline_only(net: NetProgram) -> None:
    control = net.open(v3.CanControl)
    calls = [control.set_acc_filter, control.add_filter_ids, control.rem_filter_ids]
    for call in calls:
        with pytest.raises(v3.VciException):
            call(STD, 0, ONE_STD)
    control.init_line(v3.CanOperatingModes.STANDARD, v3.CanBitrate.CIA_500_KBIT)
    for call in calls:
        call(STD, 0, ONE_STD)
    control.start_line()
    for call in calls:
        with pytest.raises(v3.VciException):
            call(STD, 0, ONE_STD)
    control.stop_line()
    for call in calls:
        call(STD, 0, ONE_STD)


@pytest.mark.conforms("X3-28")
@pytest.mark.parametrize("how", ["reset", "init"])
def test_after_reset_or_init_everything_passes(filtered: Any, message: Any, how: str) -> None:
    control = filtered.control
    control.set_acc_filter(STD, NONE, NO_MASK)
    assert filtered(message(0x100)) == []
    if how == "reset":
        control.reset_line()
    else:
        control.init_line(3, v3.CanBitrate.CIA_500_KBIT)
    assert filtered(message(0x100)) == [(0x100, False, 1)]


@pytest.mark.conforms("X3-28")
def test_none_shuts_the_first_stage_and_all_opens_it(filtered: Any, message: Any) -> None:
    control = filtered.control
    sent = both_kinds(message, 0x100, 0x200)
    control.add_filter_ids(STD, 0x200 << 1, ONE_STD)
    control.set_acc_filter(STD, NONE, NO_MASK)
    assert filtered(*sent) == [(0x200, False, 2)]
    control.set_acc_filter(STD, ALL, ALL_MASK)
    assert [accepted[2] for accepted in filtered(*sent)] == [1] * 4


@pytest.mark.parametrize("arguments", [(0, 0, 0), (3, 0, 0), (1, -1, 0), (1, 0, 1 << 32)])
def test_filter_arguments_that_are_none(net: NetProgram, arguments: tuple[int, int, int]) -> None:
    with pytest.raises(v3.ArgumentException):
        net.control().set_acc_filter(*arguments)
