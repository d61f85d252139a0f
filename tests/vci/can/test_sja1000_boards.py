"""A PC-I04 behind VCI: the usual calls, with an SJA1000 at work."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import pytest

from canwire import vci
from tests.vci.programs import Program, Virtual

PC, SERIAL = "pc-i04", "HW000104"
STD, EXT, ERRORS = vci.CAN_OPMODE_STANDARD, vci.CAN_OPMODE_EXTENDED, vci.CAN_OPMODE_ERRFRAME
CTRL_SJA1000 = vci.CAN_CTRL_SJA1000


@pytest.fixture
def board(hub: Any) -> Iterator[str]:
    """A PC-I04 on can0, beside the boards that are there."""
    hub.plug(PC, SERIAL, ("can0",))
    yield SERIAL
    hub.unplug(SERIAL)


def message(msg_id: int, data: bytes = b"", **bits: Any) -> vci.CanMsg2:
    return vci.CanMsg2(msg_id=msg_id, data=data, **bits)


def old_init(op_mode: int = STD | EXT) -> vci.CanInitLine:
    return vci.CanInitLine(op_mode, 0, vci.CAN_BT0_500KB, vci.CAN_BT1_500KB)


def start_old(program: Program, board: str, op_mode: int = STD | EXT) -> Any:
    """The board's line, through ICanControl."""
    control = program.control(0, board, vci.IID_ICanControl)
    control.init_line(old_init(op_mode))
    control.start_line()
    return control


def ids(messages: list[Any]) -> list[int]:
    return [one.msg_id for one in messages]


def test_it_is_found_by_its_class_and_says_what_it_is(program: Program, board: str) -> None:
    with program.manager.enum_devices() as devices:
        (info,) = [info for info in devices if info.hardware_id == board]
    assert info.description == "PC-I04/PCI (simulated)"
    capabilities = program.open(vci.IID_ICanSocket, 0, board).get_capabilities()
    assert capabilities.ctrl_type == CTRL_SJA1000
    assert not capabilities.features & vci.CAN_FEATURE_HIGHPRIOR
    assert capabilities.features & vci.CAN_FEATURE_SINGLESHOT


def test_its_bit_rates_are_register_values(program: Program, board: str) -> None:
    control = start_old(program, board)
    status = control.get_line_status()
    assert (status.bt_reg0, status.bt_reg1) == (vci.CAN_BT0_500KB, vci.CAN_BT1_500KB)


@pytest.mark.parametrize("old", [True, False])
def test_messages_go_both_ways(program: Program, board: str, old: bool) -> None:
    start_old(program, board)
    program.start(0)
    mine = program.old_port(0, board) if old else program.port(0, board)
    far = program.port(0)
    make = vci.CanMsg if old else vci.CanMsg2
    mine.send(make(msg_id=0x123, data=b"hello"), make(msg_id=0x18DAF110, data=b"\1", ext=1))
    mine.send(make(msg_id=7, rtr=1, dlc=3))
    first, second, third = far.messages(3)
    assert (first.msg_id, first.data, second.msg_id, second.msg_info.ext) == (0x123, b"hello", 0x18DAF110, 1)
    assert (third.msg_info.rtr, third.msg_info.dlc) == (1, 3)
    far.send(message(0x321, b"back"), message(0x18DAF111, ext=1), message(8, rtr=1, dlc=8))
    assert [(one.msg_id, one.data, one.msg_info.dlc) for one in mine.messages(3)] == [
        (0x321, b"back", 4), (0x18DAF111, b"", 0), (8, b"", 8),
    ]  # fmt: skip


def test_channels_of_two_programs_share_it(program: Program, other_program: Program, board: str) -> None:
    start_old(program, board)
    program.start(0)
    mine, theirs, far = program.port(0, board), other_program.port(0, board), program.port(0)
    mine.send(*[message(0x100 + k) for k in range(20)])
    theirs.send(*[message(0x200 + k) for k in range(20)])
    arrived = ids(far.messages(40))
    assert [id for id in arrived if id < 0x200] == [0x100 + k for k in range(20)]
    assert [id for id in arrived if id >= 0x200] == [0x200 + k for k in range(20)]
    far.send(message(5))
    assert (mine.message().msg_id, theirs.message().msg_id) == (5, 5)
    with pytest.raises(vci.VciAccessDenied, match="first program"):
        other_program.control(0, board)


def test_self_reception_and_filters(program: Program, board: str) -> None:
    start_old(program, board)
    program.start(0)
    far = program.port(0)
    port = program.port(0, board, filter_size=64, filter_mode=vci.CAN_FILTER_INCL, active=False)
    port.channel.set_acc_filter(vci.CAN_FILTER_STD, 0x100 << 1, 0x7FF << 1)
    port.channel.add_filter_ids(vci.CAN_FILTER_STD, 0x200 << 1, 0x7FF << 1)
    port.channel.activate()
    far.send(*[message(id) for id in (0x0FF, 0x100, 0x101, 0x200)])
    assert ids(port.messages(2)) == [0x100, 0x200]
    port.send(message(0x300, srr=1))
    own = port.message()
    assert (own.msg_id, own.msg_info.srr) == (0x300, 1)


def test_the_states_of_its_line(program: Program, board: str) -> None:
    control = program.control(0, board, vci.IID_ICanControl)
    with pytest.raises(vci.VciNotInitialized):
        control.start_line()
    control.init_line(old_init())
    assert control.get_line_status().status & vci.CAN_STATUS_ININIT
    control.start_line()
    assert not control.get_line_status().status & vci.CAN_STATUS_ININIT
    control.stop_line()
    assert control.get_line_status().status & vci.CAN_STATUS_ININIT
    control.start_line()
    control.reset_line()
    assert control.get_line_status().status & vci.CAN_STATUS_ININIT


def test_what_is_told_of_its_line(program: Program, board: str) -> None:
    port = program.port(0, board)
    control = start_old(program, board)
    control.stop_line()
    control.reset_line()
    infos = port.messages(3, vci.CAN_MSGTYPE_INFO)
    assert [info.ab_data[0] for info in infos] == [vci.CAN_INFO_START, vci.CAN_INFO_STOP, vci.CAN_INFO_RESET]


def test_it_knows_no_fd(program: Program, board: str) -> None:
    control = program.control(0, board)
    with pytest.raises(vci.VciError):
        control.init_line(program.init(ex_mode=vci.CAN_EXMODE_FASTDATA))


def test_the_cyclic_list(hub: Any, program: Program) -> None:
    """Of an INduCAN104, which has the same chip: a PC-I04 has no list."""
    board = "HW000105"
    hub.plug("inducan104", board, ("can0",))
    start_old(program, board)
    program.start(0)
    far = program.port(0)
    scheduler = program.open(vci.IID_ICanScheduler, 0, board)
    index = scheduler.add_message(
        vci.CanCyclicTxMsg(cycle_time=20, msg_id=0x10, data=b"\0", incr_mode=vci.CAN_CTXMSG_INC_8)
    )
    scheduler.start_message(index, 5)
    scheduler.resume()
    messages = far.messages(5)
    assert [one.data for one in messages] == [bytes([k]) for k in range(5)]
    times = [one.time for one in messages]
    assert all(abs(late - early - 2000) <= 8 for early, late in itertools.pairwise(times))
    hub.unplug(board)


def test_a_bus_error_is_told(virtual: Virtual) -> None:
    """Disturbing bits is for a bench, where the world is at hand."""
    virtual.hub.plug(PC, SERIAL, ("can0",))
    program = virtual.program
    start_old(program, SERIAL, STD | ERRORS)
    program.start(0)
    port, far = program.port(0, SERIAL), program.port(0)
    virtual.faults.flip(frame_id=5, bit="crc delimiter")
    far.send(message(5))
    error = port.message(vci.CAN_MSGTYPE_ERROR)
    assert error.ab_data[0] == vci.CAN_ERROR_FORM
    assert port.message().msg_id == 5


def test_pulled_out(program: Program, hub: Any) -> None:
    hub.plug(PC, SERIAL, ("can0",))
    control = start_old(program, SERIAL)
    port = program.port(0, SERIAL)
    hub.unplug(SERIAL)
    with pytest.raises(vci.VciError):
        control.get_line_status()
    with pytest.raises(vci.VciError):
        port.channel.get_status()
