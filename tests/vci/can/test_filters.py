"""Message filters: acceptance filter and list, for 11 and 29 bits, at the line and at the channel."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import vci
from tests.vci.programs import Program

STD, EXT = vci.CAN_FILTER_STD, vci.CAN_FILTER_EXT
LOCK, PASS, INCL, EXCL = vci.CAN_FILTER_LOCK, vci.CAN_FILTER_PASS, vci.CAN_FILTER_INCL, vci.CAN_FILTER_EXCL
NONE = (vci.CAN_ACC_CODE_NONE, vci.CAN_ACC_MASK_NONE)
ALL = (vci.CAN_ACC_CODE_ALL, vci.CAN_ACC_MASK_ALL)
LAST = 0x7FF


def message(msg_id: int, **bits: int) -> vci.CanMsg2:
    return vci.CanMsg2(msg_id=msg_id, **bits)


def exact(msg_id: int, rtr: int = 0) -> tuple[int, int]:
    """Code and mask for one identifier."""
    return msg_id << 1 | rtr, 0xFFF if msg_id <= 0x7FF else 0x3FFF_FFFF


class Bench:
    """A line 0 that sends, and line 1 with its control and a channel, both with filters."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.sender = program.port(0, tx=500)
        program.start(0)
        self.watcher = program.port(0, "HW000002", rx=5000)
        program.start(0, "HW000002")
        self.port = program.port(1, rx=5000, filter_size=64, filter_mode=PASS, active=False)
        self.control = program.control(1)

    def through(self, *messages: Any) -> list[tuple[int, int]]:
        """Identifier and acceptance code of what passes both filters."""
        self.port.channel.activate()
        self.control.start_line()
        self.sender.send(*messages)
        self.watcher.messages(len(messages))
        self.control.stop_line()
        self.port.channel.deactivate()
        found = [one for one in self.port.waiting() if one.msg_info.type == vci.CAN_MSGTYPE_DATA]
        return [(one.msg_id, one.msg_info.afc) for one in found]


@pytest.fixture
def bench(program: Program) -> Bench:
    return Bench(program)


@pytest.fixture(params=["control", "channel"])
def filtered(bench: Bench, request: pytest.FixtureRequest) -> Any:
    """What has the inclusive filters: the control or the channel; the other lets everything pass."""
    if request.param == "control":
        bench.control.init_line(bench.program.init(sf_mode=INCL, ef_mode=INCL, sf_ids=2048, ef_ids=64))
        return bench.control
    bench.control.init_line(bench.program.init())
    for select in (STD, EXT):
        bench.port.channel.set_filter_mode(select, INCL)
    return bench.port.channel


# the two stages


@pytest.mark.conforms("X3-26")
def test_the_manuals_example_passes_four_identifiers(bench: Bench, filtered: Any) -> None:
    filtered.set_acc_filter(STD, 0b001_0000_0000_0, 0b111_1111_1100_1)
    sent = [message(0x100 + k) for k in range(-2, 6)]
    remote = [message(0x100 + k, rtr=1) for k in range(4)]
    assert bench.through(*sent, *remote) == [(0x100 + k, vci.CAN_ACCEPT_FILTER_1) for k in range(4)]


@pytest.mark.conforms("X3-26", "X3-28", "X4-33")
def test_what_the_first_stage_does_not_know_the_list_may(bench: Bench, filtered: Any) -> None:
    filtered.set_acc_filter(STD, *exact(0x10))
    filtered.add_filter_ids(STD, *exact(0x20))
    filtered.add_filter_ids(STD, *exact(0x10))
    assert bench.through(*map(message, (0x10, 0x20, 0x30))) == [
        (0x10, vci.CAN_ACCEPT_FILTER_1),
        (0x20, vci.CAN_ACCEPT_FILTER_2),
    ]


@pytest.mark.conforms("X3-28")
def test_the_first_stage_can_be_shut_or_open(bench: Bench, filtered: Any) -> None:
    filtered.add_filter_ids(STD, *exact(0x20))
    filtered.set_acc_filter(STD, *NONE)
    assert bench.through(*map(message, (0x10, 0x20))) == [(0x20, vci.CAN_ACCEPT_FILTER_2)]
    filtered.set_acc_filter(STD, *ALL)
    assert bench.through(*map(message, (0x10, 0x20))) == [
        (one, vci.CAN_ACCEPT_FILTER_1) for one in (0x10, 0x20)
    ]


@pytest.mark.conforms("X3-26")
def test_both_formats_have_filters_of_their_own(bench: Bench, filtered: Any) -> None:
    filtered.set_acc_filter(STD, *exact(0x10))
    filtered.set_acc_filter(EXT, 0x1000_0000 << 1, 0x3FFF_FFFF)
    messages = (message(0x10), message(0x11), message(0x10, ext=1), message(0x1000_0000, ext=1))
    assert bench.through(*messages) == [(0x10, 1), (0x1000_0000, 1)]


@pytest.mark.conforms("X3-26")
def test_remote_requests_are_apart(bench: Bench, filtered: Any) -> None:
    filtered.set_acc_filter(STD, *exact(0x10, rtr=1))
    filtered.add_filter_ids(STD, *exact(0x11))
    messages = (message(0x10), message(0x10, rtr=1), message(0x11), message(0x11, rtr=1))
    assert [found for found, _ in bench.through(*messages)] == [0x10, 0x11]


@pytest.mark.conforms("X3-27")
def test_groups_are_added_and_removed(bench: Bench, filtered: Any) -> None:
    filtered.set_acc_filter(STD, *NONE)
    filtered.add_filter_ids(STD, 0x100 << 1, 0x7F0 << 1)
    filtered.rem_filter_ids(STD, 0x104 << 1, 0x7FC << 1)
    messages = [message(0x100 + k, rtr=rtr) for k in range(-1, 17) for rtr in (0, 1)]
    expected = [0x100 + k for k in range(16) if not 4 <= k < 8 for _ in (0, 1)]
    assert [found for found, _ in bench.through(*messages)] == expected


@pytest.mark.conforms("X3-27", "X4-35")
def test_the_11_bit_list_has_room_for_all(bench: Bench, filtered: Any) -> None:
    filtered.set_acc_filter(STD, *NONE)
    filtered.add_filter_ids(STD, 0, 0)
    messages = [message(k, rtr=k & 1) for k in range(0, 2048, 41)]
    assert bench.through(*messages) == [(one.msg_id, vci.CAN_ACCEPT_FILTER_2) for one in messages]
    filtered.rem_filter_ids(STD, 0, 0)
    assert bench.through(*messages) == []


@pytest.mark.conforms("X3-27", "X4-35")
def test_the_29_bit_list_has_its_size(bench: Bench, filtered: Any) -> None:
    filtered.set_acc_filter(EXT, *NONE)
    filtered.add_filter_ids(EXT, 0x1000_0000 << 1, 0x1FFF_FFC0 << 1)
    with pytest.raises(vci.VciInvalidArgument):
        filtered.add_filter_ids(EXT, 0x10 << 1, 0x3FFF_FFFF)
    filtered.rem_filter_ids(EXT, 0x1000_0000 << 1, 0x3FFF_FFFE)
    filtered.add_filter_ids(EXT, 0x10 << 1, 0x3FFF_FFFF)
    messages = [
        message(one, ext=1) for one in (0x1000_0000, 0x1000_0001, 0x1000_003F, 0x1000_0040, 0x10, 0x11)
    ]
    assert [found for found, _ in bench.through(*messages)] == [0x1000_0001, 0x1000_003F, 0x10]


# modes


@pytest.mark.conforms("X4-34", "X4-33")
@pytest.mark.parametrize(
    ("mode", "passes"),
    [
        (LOCK, []),
        (PASS, [(0x10, 255), (0x20, 255), (0x30, 255)]),
        (INCL, [(0x10, vci.CAN_ACCEPT_FILTER_1), (0x20, vci.CAN_ACCEPT_FILTER_2)]),
        (EXCL, [(0x30, vci.CAN_ACCEPT_PASSEXCL)]),
    ],
)
def test_modes(bench: Bench, filtered: Any, mode: int, passes: list[tuple[int, int]]) -> None:
    filtered.set_filter_mode(STD, mode)
    filtered.set_acc_filter(STD, *exact(0x10))
    filtered.add_filter_ids(STD, *exact(0x20))
    assert bench.through(*map(message, (0x10, 0x20, 0x30))) == passes


@pytest.mark.conforms("X4-34")
def test_what_is_no_data_always_passes(bench: Bench, filtered: Any) -> None:
    for select in (STD, EXT):
        filtered.set_filter_mode(select, LOCK)
    bench.port.channel.activate()
    bench.control.start_line()
    info = bench.port.message(vci.CAN_MSGTYPE_INFO)
    assert (info.ab_data[0], info.msg_info.afc) == (vci.CAN_INFO_START, vci.CAN_ACCEPT_ALWAYS)


@pytest.mark.conforms("X4-35")
def test_changing_the_mode_tells_the_one_before(filtered: Any) -> None:
    for select in (STD, EXT):
        assert filtered.get_filter_mode(select) == INCL
        assert filtered.set_filter_mode(select, EXCL) == INCL
        assert filtered.set_filter_mode(select, LOCK) == EXCL
        assert filtered.get_filter_mode(select) == LOCK


def test_impossible_arguments(filtered: Any) -> None:
    for select in (0, 3, "1"):
        with pytest.raises(vci.VciInvalidArgument):
            filtered.get_filter_mode(select)
        with pytest.raises(vci.VciInvalidArgument):
            filtered.set_acc_filter(select, 0, 0)
    for mode in (0, 5, PASS | vci.CAN_FILTER_SRRA):
        with pytest.raises(vci.VciInvalidArgument):
            filtered.set_filter_mode(STD, mode)
    for code, mask in ((-1, 0), (0, 1 << 32)):
        with pytest.raises(vci.VciInvalidArgument):
            filtered.add_filter_ids(STD, code, mask)


# when


@pytest.mark.conforms("X3-28", "X4-35")
def test_at_work_filters_stay(bench: Bench, filtered: Any) -> None:
    bench.port.channel.activate()
    bench.control.start_line()
    changes = [
        lambda: filtered.set_filter_mode(STD, PASS),
        lambda: filtered.set_acc_filter(STD, *ALL),
        lambda: filtered.add_filter_ids(STD, *exact(1)),
        lambda: filtered.rem_filter_ids(STD, *exact(1)),
    ]
    for change in changes:
        with pytest.raises(vci.VciInvalidState):
            change()
    assert filtered.get_filter_mode(STD) == INCL


@pytest.mark.conforms("X3-28")
def test_before_init_line_there_are_no_filters(program: Program) -> None:
    for control in (program.control(0), program.control(1, iid=vci.IID_ICanControl)):
        with pytest.raises(vci.VciNotInitialized):
            control.set_acc_filter(STD, *ALL)
        with pytest.raises(vci.VciNotInitialized):
            control.add_filter_ids(STD, *exact(1))


@pytest.mark.conforms("X3-28")
def test_just_made_everything_passes(bench: Bench, filtered: Any) -> None:
    messages = (message(0x10), message(0x7FF), message(0x1FFF_FFFF, ext=1))
    assert [found for found, _ in bench.through(*messages)] == [0x10, 0x7FF, 0x1FFF_FFFF]


@pytest.mark.conforms("X4-34", "X4-35")
def test_reset_and_init_give_the_mode_of_init_back(bench: Bench) -> None:
    init = bench.program.init(sf_mode=INCL, sf_ids=10)
    bench.control.init_line(init)
    bench.control.set_filter_mode(STD, LOCK)
    bench.control.init_line(init)
    assert bench.control.get_filter_mode(STD) == INCL
    assert bench.through(message(1)) == [(1, vci.CAN_ACCEPT_FILTER_1)]


# both together


@pytest.mark.conforms("X4-34")
def test_filters_are_a_chain(bench: Bench) -> None:
    bench.control.init_line(bench.program.init(sf_mode=EXCL, ef_mode=PASS, sf_ids=10, ef_ids=10))
    bench.control.add_filter_ids(STD, *exact(0x10))
    bench.port.channel.set_filter_mode(STD, INCL)
    bench.port.channel.set_acc_filter(STD, *NONE)
    for wanted in (0x10, 0x11):
        bench.port.channel.add_filter_ids(STD, *exact(wanted))
    assert bench.through(*map(message, (0x10, 0x11, 0x12))) == [(0x11, vci.CAN_ACCEPT_FILTER_2)]


@pytest.mark.conforms("X4-34")
def test_the_lines_filter_holds_for_old_channels_too(bench: Bench) -> None:
    bench.control.init_line(bench.program.init(sf_mode=INCL, sf_ids=10))
    bench.control.set_acc_filter(STD, *exact(0x10))
    old = bench.program.old_port(1)
    bench.control.start_line()
    bench.sender.send(message(0x11), message(0x10))
    found = old.message()
    assert (found.msg_id, found.msg_info.afc) == (0x10, vci.CAN_ACCEPT_FILTER_1)


@pytest.mark.conforms("X4-35")
def test_without_room_there_is_no_list_but_an_acceptance_filter(program: Program) -> None:
    channel = program.keep(program.open(vci.IID_ICanSocket2).create_channel(False))
    channel.initialize(10, 10, 0, INCL)
    with pytest.raises(vci.VciNotInitialized, match="list"):
        channel.add_filter_ids(STD, *exact(1))
    channel.set_acc_filter(STD, *exact(1))
    assert channel.get_filter_mode(STD) == INCL


@pytest.mark.conforms("X4-35")
def test_without_room_a_line_has_no_filter(bench: Bench) -> None:
    bench.control.init_line(bench.program.init(sf_mode=LOCK, ef_mode=LOCK))
    assert bench.through(message(1), message(2, ext=1)) == [(1, 255), (2, 255)]


def test_the_old_control_sets_the_same_filters(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0)
    control = program.control(1, iid=vci.IID_ICanControl)
    control.init_line(vci.CanInitLine(vci.CAN_OPMODE_STANDARD, 0, vci.CAN_BT0_500KB, vci.CAN_BT1_500KB))
    control.set_acc_filter(STD, *NONE)
    control.add_filter_ids(STD, 0x10 << 1, 0x7F0 << 1)
    control.rem_filter_ids(STD, 0x11 << 1, 0xFFE)
    control.start_line()
    sender.send(*map(message, (0x0F, 0x10, 0x11, 0x12, 0x20)))
    assert [one.msg_id for one in receiver.messages(2)] == [0x10, 0x12]
    assert not hasattr(control, "set_filter_mode")
