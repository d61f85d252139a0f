"""The control unit: who may have it, the states of a line, and what its settings do."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import vci
from tests.vci.programs import Program, Virtual

STD, EXT = vci.CAN_OPMODE_STANDARD, vci.CAN_OPMODE_EXTENDED
BOTH = STD | EXT
CLASSIC_BOARD = "HW000002"
RATES = [10, 20, 50, 100, 125, 250, 500, 800, 1000]


def message(msg_id: int, data: bytes = b"", **bits: int) -> vci.CanMsg2:
    return vci.CanMsg2(msg_id=msg_id, data=data, **bits)


def ids(messages: list[Any]) -> list[int]:
    return [one.msg_id for one in messages]


def old_init(op_mode: int = BOTH, kbit: int = 500) -> vci.CanInitLine:
    return vci.CanInitLine(op_mode, 0, getattr(vci, f"CAN_BT0_{kbit}KB"), getattr(vci, f"CAN_BT1_{kbit}KB"))


# one at a time


@pytest.mark.conforms("X3-08")
@pytest.mark.parametrize("first", [vci.IID_ICanControl, vci.IID_ICanControl2])
@pytest.mark.parametrize("second", [vci.IID_ICanControl, vci.IID_ICanControl2])
def test_one_program_has_the_control(
    program: Program, other_program: Program, first: Any, second: Any
) -> None:
    with program.bal().open_socket(0, first):
        for somebody in (program, other_program):
            with pytest.raises(vci.VciAccessDenied, match="first program"):
                somebody.bal().open_socket(0, second)
        with other_program.bal().open_socket(1, second):
            pass
    with other_program.bal().open_socket(0, second):
        pass


@pytest.mark.conforms("X3-08", "X4-40")
@pytest.mark.parametrize("stays", ["channel", "scheduler"])
def test_a_line_runs_on_while_somebody_uses_it(program: Program, other_program: Program, stays: str) -> None:
    if stays == "channel":
        kept = other_program.port(0).channel
    else:
        kept = other_program.open(vci.IID_ICanScheduler)
    socket = program.open(vci.IID_ICanSocket2)
    with program.bal().open_socket(0, vci.IID_ICanControl2) as control:
        control.init_line(program.init())
        control.start_line()
    assert socket.get_line_status().status & vci.CAN_STATUS_ININIT == 0
    assert socket.get_line_status().op_mode == BOTH
    kept.release()
    status = socket.get_line_status()
    assert status == vci.CanLineStatus2(status=vci.CAN_STATUS_ININIT, bus_load=status.bus_load)


@pytest.mark.conforms("X4-40")
def test_the_next_control_finds_the_line_as_it_is(program: Program, other_program: Program) -> None:
    port, far = program.port(0), program.port(1)
    program.start(1)
    with program.bal().open_socket(0, vci.IID_ICanControl2) as control:
        control.init_line(program.init())
        control.start_line()
    theirs = other_program.control(0)
    assert theirs.get_line_status().op_mode == BOTH
    port.send(message(5))
    assert far.message().msg_id == 5
    theirs.stop_line()
    theirs.start_line()


# states


@pytest.mark.conforms("X3-09")
@pytest.mark.parametrize("iid", [vci.IID_ICanControl, vci.IID_ICanControl2])
def test_states(program: Program, iid: Any) -> None:
    control = program.control(0, iid=iid)
    init = old_init() if iid == vci.IID_ICanControl else program.init()

    def is_stopped() -> bool:
        return bool(control.get_line_status().status & vci.CAN_STATUS_ININIT)

    with pytest.raises(vci.VciNotInitialized):
        control.start_line()
    control.stop_line()
    control.reset_line()
    assert (control.get_line_status().op_mode, is_stopped()) == (vci.CAN_OPMODE_UNDEFINED, True)
    control.init_line(init)
    assert (control.get_line_status().op_mode, is_stopped()) == (BOTH, True)
    for _ in range(2):
        control.start_line()
        assert not is_stopped()
    for _ in range(2):
        control.stop_line()
        assert is_stopped()
    control.start_line()
    control.init_line(init)
    assert is_stopped()
    control.start_line()
    control.reset_line()
    assert (control.get_line_status().op_mode, is_stopped()) == (vci.CAN_OPMODE_UNDEFINED, True)
    with pytest.raises(vci.VciNotInitialized):
        control.start_line()


def test_init_line_wants_its_own_structure(program: Program) -> None:
    with pytest.raises(vci.VciInvalidArgument, match="a CanInitLine2 belongs here"):
        program.control(0).init_line(old_init())
    with pytest.raises(vci.VciInvalidArgument, match="a CanInitLine belongs here"):
        program.control(1, iid=vci.IID_ICanControl).init_line(program.init())


@pytest.mark.conforms("X4-15", "X4-18")
def test_what_the_board_cannot_do_is_refused(program: Program) -> None:
    control = program.control(0, CLASSIC_BOARD)
    with pytest.raises(vci.VciNotSupported, match="CAN_FEATURE_EXTDATA"):
        control.init_line(program.init(ex_mode=vci.CAN_EXMODE_EXTDATA))
    with pytest.raises(vci.VciError, match="nearest") as raised:
        control.init_line(program.init(btp_sdr=vci.CanBtp(0, 777_777, 8, 2, 1)))
    assert raised.value.code == vci.VCI_E_INVALID_TIMING
    with pytest.raises(vci.VciNotInitialized):
        control.start_line()


# modes and rates


@pytest.mark.conforms("X3-10", "X3-11")
@pytest.mark.parametrize("kbit", RATES)
def test_rates(program: Program, kbit: int) -> None:
    sender, receiver = program.old_port(0), program.old_port(1)
    sender.send(vci.CanMsg(msg_id=0x555, data=b"\x55" * 8), vci.CanMsg(msg_id=0x555, data=b"\x55" * 8))
    for line in (1, 0):
        control = program.control(line, iid=vci.IID_ICanControl)
        control.init_line(old_init(kbit=kbit))
        control.start_line()
    first, second = receiver.messages(2)
    assert first.data == b"\x55" * 8
    bits = (second.time - first.time) * kbit / 1000
    assert 111 <= bits <= 135


@pytest.mark.conforms("X3-10")
def test_who_listens_only_does_not_answer(program: Program) -> None:
    sender, silent = program.port(0), program.port(1)
    program.start(0, op_mode=BOTH | vci.CAN_OPMODE_ERRFRAME)
    program.start(1, op_mode=BOTH | vci.CAN_OPMODE_LISTONLY)
    sender.send(message(1, ssm=1))
    assert sender.message(vci.CAN_MSGTYPE_ERROR).ab_data[0] == vci.CAN_ERROR_ACK
    other = program.port(0, CLASSIC_BOARD)
    program.start(0, CLASSIC_BOARD)
    sender.send(message(2))
    assert other.message().msg_id == silent.message().msg_id == 2


@pytest.mark.conforms("X3-10")
@pytest.mark.parametrize(("op_mode", "arrives"), [(STD, [1]), (EXT, [2]), (BOTH, [1, 2])])
def test_frame_formats(program: Program, op_mode: int, arrives: list[int]) -> None:
    sender, receiver, watcher = program.port(0), program.port(1), program.port(0, CLASSIC_BOARD)
    program.start(0)
    program.start(1, op_mode=op_mode)
    program.start(0, CLASSIC_BOARD)
    sender.send(message(1), message(2, ext=1))
    watcher.messages(2)
    assert ids(receiver.messages(len(arrives))) == arrives
    assert [one for one in receiver.waiting() if not one.msg_info.type] == []


@pytest.mark.conforms("X3-10")
def test_frame_formats_hold_for_sending_too(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0, op_mode=STD)
    program.start(1)
    sender.send(message(1, ext=1), message(2))
    assert receiver.message().msg_id == 2
    assert sender.counts().refused == 1


@pytest.mark.conforms("X4-18")
def test_raw_timing_and_ratios_speak_to_each_other(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    raw = vci.CanBtp(vci.CAN_BTMODE_RAW, 2, 69, 10, 5)
    fast = vci.CanBtp(vci.CAN_BTMODE_RAW, 2, 15, 4, 4, 32)
    ex_mode = vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA
    program.start(0, btp_sdr=raw, btp_fdr=fast, ex_mode=ex_mode)
    program.start(1, ex_mode=ex_mode)
    sender.send(message(7, bytes(64), edl=1, fdr=1))
    assert receiver.message().msg_info.fdr == 1


@pytest.mark.conforms("X4-17")
def test_non_iso_frames_are_another_language(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    ex_mode = vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA
    errors = BOTH | vci.CAN_OPMODE_ERRFRAME
    program.start(0, ex_mode=ex_mode | vci.CAN_EXMODE_NONISO)
    control = program.start(1, ex_mode=ex_mode, op_mode=errors)
    sender.send(message(7, bytes(20), edl=1, fdr=1, ssm=1))
    assert receiver.message(vci.CAN_MSGTYPE_ERROR).ab_data[0] in (
        vci.CAN_ERROR_CRC,
        vci.CAN_ERROR_FORM,
        vci.CAN_ERROR_STUFF,
    )
    control.init_line(program.init(ex_mode=ex_mode | vci.CAN_EXMODE_NONISO, op_mode=errors))
    control.start_line()
    sender.send(message(8, bytes(20), edl=1, fdr=1))
    assert receiver.message().msg_id == 8


# stopping


@pytest.mark.conforms("X3-13")
def test_stop_waits_for_the_frame_on_the_wire(virtual: Virtual) -> None:
    program = virtual.program
    sender, receiver = program.port(0), program.port(1)
    control = program.start(0)
    program.start(1, op_mode=BOTH | vci.CAN_OPMODE_ERRFRAME)
    sender.send(message(1, bytes(8)), message(2))
    virtual.hub.run_for(100e-6)
    assert receiver.reader.get_fill_count() == len(receiver.waiting())
    control.stop_line()
    found = receiver.waiting()
    assert [one.msg_id for one in found if one.msg_info.type == vci.CAN_MSGTYPE_DATA] == [1]
    assert all(one.msg_info.type != vci.CAN_MSGTYPE_ERROR for one in found)
    virtual.hub.run_for(0.01)
    assert receiver.waiting() == []
    control.start_line()
    assert receiver.message().msg_id == 2


@pytest.mark.conforms("X3-14")
def test_reset_breaks_the_frame_on_the_wire(virtual: Virtual) -> None:
    program = virtual.program
    sender, receiver = program.port(0), program.port(1)
    control = program.start(0)
    program.start(1, op_mode=BOTH | vci.CAN_OPMODE_ERRFRAME)
    sender.send(message(0x555, b"\x55" * 8))
    virtual.hub.run_for(100e-6)
    control.reset_line()
    error = receiver.message(vci.CAN_MSGTYPE_ERROR)
    assert error.ab_data[0] in (vci.CAN_ERROR_STUFF, vci.CAN_ERROR_FORM)
    assert not any(one.msg_info.type == vci.CAN_MSGTYPE_DATA for one in receiver.waiting())


@pytest.mark.conforms("X3-13")
def test_stop_keeps_filters(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0)
    control = program.control(1)
    init = program.init(sf_mode=vci.CAN_FILTER_INCL, sf_ids=10)
    control.init_line(init)
    control.set_acc_filter(vci.CAN_FILTER_STD, vci.CAN_ACC_CODE_NONE, vci.CAN_ACC_MASK_NONE)
    control.add_filter_ids(vci.CAN_FILTER_STD, 5 << 1, 0xFFF)
    control.start_line()
    control.stop_line()
    control.start_line()
    sender.send(message(4), message(5))
    assert receiver.message().msg_id == 5


@pytest.mark.conforms("X3-14", "X3-28")
@pytest.mark.parametrize("iid", [vci.IID_ICanControl, vci.IID_ICanControl2])
def test_reset_clears_filters(program: Program, iid: Any) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0)
    control = program.control(1, iid=iid)
    init = old_init() if iid == vci.IID_ICanControl else program.init(sf_mode=vci.CAN_FILTER_INCL, sf_ids=10)
    control.init_line(init)
    control.set_acc_filter(vci.CAN_FILTER_STD, vci.CAN_ACC_CODE_NONE, vci.CAN_ACC_MASK_NONE)
    control.reset_line()
    with pytest.raises(vci.VciNotInitialized):
        control.set_acc_filter(vci.CAN_FILTER_STD, 0, 0)
    control.init_line(init)
    control.start_line()
    sender.send(message(4))
    assert receiver.message().msg_id == 4


@pytest.mark.conforms("X3-15")
@pytest.mark.parametrize("end", ["stop_line", "reset_line"])
def test_fifos_keep_what_is_in_them(program: Program, end: str) -> None:
    sender, receiver, watcher = program.port(0), program.port(1), program.port(1)
    program.start(0)
    control = program.start(1)
    sender.send(message(1), message(2))
    watcher.messages(2)
    getattr(control, end)()
    receiver.send(message(0x701), message(0x702))
    waiting = receiver.writer.get_fill_count()
    assert waiting == 2
    assert ids(receiver.messages(2)) == [1, 2]
    control.init_line(program.init())
    control.start_line()
    assert ids(sender.messages(2)) == [0x701, 0x702]


# status


@pytest.mark.conforms("X4-36")
def test_status_of_a_line_that_nobody_answers(program: Program) -> None:
    port = program.port(0)
    control = program.start(0, op_mode=BOTH | vci.CAN_OPMODE_ERRFRAME)
    assert control.get_line_status().status == 0
    port.send(message(1))
    while not port.message(vci.CAN_MSGTYPE_STATUS).ab_data[0] & vci.CAN_STATUS_ERRLIM:
        pass
    assert control.get_line_status().status == vci.CAN_STATUS_TXPEND | vci.CAN_STATUS_ERRLIM
    assert control.get_line_status().bus_load <= 100


@pytest.mark.conforms("X4-36")
def test_bus_off(virtual: Virtual) -> None:
    program = virtual.program
    port, other = program.port(0), program.port(1)
    control = program.start(0)
    program.start(1)
    port.send(message(1))
    other.message()
    virtual.hub.short("can0")
    port.send(message(2))
    while not port.message(vci.CAN_MSGTYPE_STATUS).ab_data[0] & vci.CAN_STATUS_BUSOFF:
        pass
    flags = control.get_line_status().status
    assert flags & vci.CAN_STATUS_BUSOFF
    assert flags & vci.CAN_STATUS_ERRLIM
    virtual.hub.short("can0", False)


@pytest.mark.conforms("X4-36")
def test_bus_load(virtual: Virtual) -> None:
    program = virtual.program
    sender, receiver = program.port(0, tx=1000), program.port(1, rx=1000)
    control = program.start(0)
    program.start(1)
    assert control.get_line_status().bus_load == 0
    sender.send(*(message(0x155, bytes(range(8))) for _ in range(900)))
    virtual.hub.run_for(1.0)
    frame_bits = 8 * 8 + 47
    load = control.get_line_status().bus_load
    assert abs(load - 100 * 900 * frame_bits / 500_000) < 4
    assert program.open(vci.IID_ICanSocket).get_line_status().bus_load == load
    assert len(receiver.messages(900)) == 900


@pytest.mark.conforms("X4-35")
@pytest.mark.finding("vci F9")
def test_reset_line_puts_the_filter_modes_back(program: Program) -> None:
    control = program.control(0)
    with pytest.raises(vci.VciNotInitialized):
        control.get_filter_mode(vci.CAN_FILTER_STD)
    control.init_line(
        program.init(sf_mode=vci.CAN_FILTER_INCL, sf_ids=10, ef_mode=vci.CAN_FILTER_EXCL, ef_ids=5)
    )
    control.set_filter_mode(vci.CAN_FILTER_STD, vci.CAN_FILTER_LOCK)
    control.reset_line()
    assert control.get_filter_mode(vci.CAN_FILTER_STD) == vci.CAN_FILTER_INCL
    assert control.get_filter_mode(vci.CAN_FILTER_EXT) == vci.CAN_FILTER_EXCL


@pytest.mark.conforms("X4-30")
@pytest.mark.finding("vci F10")
def test_init_line_resets_what_others_see(program: Program, other_program: Program) -> None:
    port = other_program.port(0)
    control = program.start(0)
    control.init_line(program.init())
    control.start_line()
    told = [one.ab_data[0] for one in port.messages(3, vci.CAN_MSGTYPE_INFO)]
    assert told == [vci.CAN_INFO_START, vci.CAN_INFO_RESET, vci.CAN_INFO_START]


@pytest.mark.conforms("X4-43")
def test_low_speed_coupling(virtual: Virtual) -> None:
    program = virtual.program
    sender, receiver = program.port(0, CLASSIC_BOARD), program.port(1, CLASSIC_BOARD)
    low = BOTH | vci.CAN_OPMODE_LOWSPEED
    controls = [program.start(line, CLASSIC_BOARD, op_mode=low, btp_sdr=vci.CAN_BTP_125KB) for line in (0, 1)]
    sender.send(message(1))
    assert receiver.message().msg_id == 1
    assert not controls[0].get_line_status().status & vci.CAN_STATUS_BUSCERR
    virtual.hub.short("can0")
    assert controls[0].get_line_status().status & vci.CAN_STATUS_BUSCERR
    virtual.hub.short("can0", False)
    assert not controls[0].get_line_status().status & vci.CAN_STATUS_BUSCERR
    assert controls[0].get_line_status().op_mode == low


@pytest.mark.conforms("X4-43")
def test_low_speed_is_for_boards_that_have_it_and_for_low_rates(program: Program) -> None:
    low = BOTH | vci.CAN_OPMODE_LOWSPEED
    with pytest.raises(vci.VciNotSupported, match="CAN_BUSC_LOWSPEED"):
        program.control(0).init_line(program.init(op_mode=low, btp_sdr=vci.CAN_BTP_125KB))
    with pytest.raises(vci.VciError, match="125000") as raised:
        program.control(0, CLASSIC_BOARD).init_line(program.init(op_mode=low))
    assert raised.value.code == vci.VCI_E_INVALID_TIMING
