"""The cyclic transmit list: messages that a line sends by itself."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest

from canwire import vci
from tests.vci.programs import CLASSIC_BOARD, FD_BOARD, Program, Virtual

PASSIVE_BOARD = "HW000104"
TICK_US = 100
SLACK_US = 2  # stamps are cut to whole microseconds


class Bench:
    """Line 0 with a cyclic list, line 1 that receives."""

    def __init__(self, program: Program, iid: Any = vci.IID_ICanScheduler2, **members: Any) -> None:
        self.port = program.port(1, rx=2000)
        self.control = program.start(0, **members)
        program.start(1, **members)
        self.scheduler = program.open(iid)
        self.add = self.scheduler.add_message

    def started(self, *messages: Any, count: int = 0) -> list[int]:
        indices = [self.add(message) for message in messages]
        for index in indices:
            self.scheduler.start_message(index, count)
        return indices


@pytest.fixture
def bench(program: Program) -> Bench:
    return Bench(program)


def cyclic(msg_id: int, cycle: int, data: bytes = b"", **more: Any) -> vci.CanCyclicTxMsg2:
    return vci.CanCyclicTxMsg2(cycle_time=cycle, msg_id=msg_id, data=data, **more)


def slots(messages: list[Any], first: int) -> list[int]:
    """The tick of each message, when the first one had this one."""
    return [first + round((one.time - messages[0].time) / TICK_US) for one in messages]


@pytest.mark.conforms("X3-29")
def test_one_program_has_the_list(program: Program, other_program: Program) -> None:
    with program.bal().open_socket(0, vci.IID_ICanScheduler2):
        for somebody in (program, other_program):
            for iid in (vci.IID_ICanScheduler, vci.IID_ICanScheduler2):
                with pytest.raises(vci.VciAccessDenied, match="first program"):
                    somebody.bal().open_socket(0, iid)
    with other_program.bal().open_socket(0, vci.IID_ICanScheduler):
        pass


@pytest.mark.conforms("X3-29", "X4-15")
@pytest.mark.finding("vci F8")
@pytest.mark.parametrize("iid", [vci.IID_ICanScheduler, vci.IID_ICanScheduler2])
def test_a_passive_board_has_no_list(program: Program, iid: Any) -> None:
    program.hub.plug("pc-i04", PASSIVE_BOARD)
    try:
        with pytest.raises(vci.VciNotImplemented, match="no cyclic transmit list"):
            program.bal(PASSIVE_BOARD).open_socket(0, iid)
        for socket in (vci.IID_ICanSocket, vci.IID_ICanSocket2):
            capabilities = program.open(socket, board=PASSIVE_BOARD).get_capabilities()
            assert not capabilities.features & vci.CAN_FEATURE_SCHEDULER
            assert (capabilities.cms_divisor, capabilities.cms_max_ticks) == (0, 0)
            assert capabilities.dtx_divisor
    finally:
        program.hub.unplug(PASSIVE_BOARD)


@pytest.mark.conforms("X3-19")
@pytest.mark.finding("vci F5")
@pytest.mark.parametrize("board", [FD_BOARD, CLASSIC_BOARD])
def test_what_a_stopped_line_did_not_send_never_comes(virtual: Virtual, board: str) -> None:
    program = virtual.program
    port = program.port(1)
    program.start(1)
    control = program.start(0, board)
    scheduler = program.open(vci.IID_ICanScheduler2, 0, board)
    growing = vci.CanCyclicTxMsg2(cycle_time=100, incr_mode=vci.CAN_CTXMSG_INC_8, msg_id=1, data=b"\0")
    scheduler.start_message(scheduler.add_message(growing), 0)
    counted = scheduler.add_message(vci.CanCyclicTxMsg2(cycle_time=100, msg_id=2))
    scheduler.start_message(counted, 3)
    control.stop_line()
    scheduler.resume()
    virtual.hub.run_for(1.0)
    assert scheduler.get_status().msg_stat[counted] == vci.CAN_CTXMSG_STAT_BUSY
    control.start_line()
    virtual.hub.run_for(0.0199)
    assert len(port.waiting()) <= 1 + 2 * 2
    virtual.hub.run_for(0.1)
    found = [one for one in port.waiting() if one.msg_info.type == vci.CAN_MSGTYPE_DATA]
    assert len([one for one in found if one.msg_id == 1]) == 10
    assert scheduler.get_status().msg_stat[counted] == vci.CAN_CTXMSG_STAT_DONE
    assert found[0].data[0] <= 2


@pytest.mark.conforms("X3-29", "X4-41")
def test_sixteen_objects(bench: Bench) -> None:
    indices = [bench.add(cyclic(number, 100)) for number in range(16)]
    assert indices == list(range(16))
    with pytest.raises(vci.VciInvalidState, match="full"):
        bench.add(cyclic(16, 100))
    bench.scheduler.rem_message(7)
    assert bench.add(cyclic(17, 100)) == 7


@pytest.mark.conforms("X3-30")
def test_cycle_times(program: Program, bench: Bench) -> None:
    longest = program.open(vci.IID_ICanSocket2).get_capabilities().cms_max_ticks
    assert longest == 65535
    with pytest.raises(vci.VciInvalidArgument, match="cycle"):
        bench.add(cyclic(1, 0))
    with pytest.raises(vci.VciInvalidArgument, match="wCycleTime"):
        bench.add(cyclic(1, longest + 1))
    bench.add(cyclic(1, longest))


@pytest.mark.conforms("X3-30")
def test_there_is_one_object_a_tick(bench: Bench) -> None:
    bench.add(cyclic(1, 1))
    with pytest.raises(vci.VciInvalidArgument, match="sum"):
        bench.add(cyclic(2, 65535))
    bench.scheduler.reset()
    for cycle in (2, 3):
        bench.add(cyclic(cycle, cycle))
    with pytest.raises(vci.VciInvalidArgument, match="sum"):
        bench.add(cyclic(5, 5))
    bench.add(cyclic(6, 6))


@pytest.mark.conforms("X3-30")
def test_collisions_take_the_next_free_slot(virtual: Virtual) -> None:
    bench = Bench(virtual.program)
    bench.started(cyclic(2, 2), cyclic(3, 3))
    bench.scheduler.resume()
    found = bench.port.messages(16)
    ticks = slots(found, 2)
    taken = {
        number: [tick for tick, one in zip(ticks, found, strict=True) if one.msg_id == number]
        for number in (2, 3)
    }
    assert taken[2][:9] == list(range(2, 20, 2))
    assert taken[3][:6] == [3, 7, 9, 13, 15, 19]


@pytest.mark.conforms("X3-30", "X3-32")
def test_messages_come_in_time(virtual: Virtual) -> None:
    bench = Bench(virtual.program)
    bench.started(cyclic(1, 10), cyclic(2, 25))
    bench.scheduler.resume()
    for msg_id, cycle in ((1, 10), (2, 25)):
        times = [one.time for one in bench.port.messages(40) if one.msg_id == msg_id]
        for earlier, later in pairwise(times):
            assert abs(later - earlier - cycle * TICK_US) <= TICK_US + SLACK_US


# increments


@pytest.mark.conforms("X3-31")
@pytest.mark.parametrize(
    ("mode", "byte_index", "data", "found"),
    [
        (vci.CAN_CTXMSG_INC_NO, 0, b"\xfe\xff\x00", ["feff00"] * 4),
        (vci.CAN_CTXMSG_INC_8, 0, b"\xfe\xff\x00", ["feff00", "ffff00", "00ff00", "01ff00"]),
        (vci.CAN_CTXMSG_INC_8, 2, b"\xfe\xff\x00", ["feff00", "feff01", "feff02", "feff03"]),
        (vci.CAN_CTXMSG_INC_16, 0, b"\xfe\xff\x00", ["feff00", "ffff00", "000000", "010000"]),
        (vci.CAN_CTXMSG_INC_16, 1, b"\x00\xfe\x01", ["00fe01", "00ff01", "000002", "000102"]),
    ],
)
def test_data_count_up(bench: Bench, mode: int, byte_index: int, data: bytes, found: list[str]) -> None:
    bench.started(cyclic(1, 1, data, incr_mode=mode, byte_index=byte_index), count=4)
    bench.scheduler.resume()
    assert [one.data.hex() for one in bench.port.messages(4)] == found


@pytest.mark.conforms("X3-31")
@pytest.mark.parametrize(("first", "ext"), [(0x7FE, 0), (0x1FFF_FFFE, 1)])
def test_identifiers_count_up(bench: Bench, first: int, ext: int) -> None:
    bench.started(cyclic(first, 1, incr_mode=vci.CAN_CTXMSG_INC_ID, ext=ext), count=4)
    bench.scheduler.resume()
    assert [one.msg_id for one in bench.port.messages(4)] == [first, first + 1, 0, 1]


@pytest.mark.finding("vendor 6")
@pytest.mark.conforms("X4-42", "X3-31")
@pytest.mark.parametrize(
    ("mode", "byte_index", "length", "fits"),
    [
        (vci.CAN_CTXMSG_INC_8, 3, 4, True),
        (vci.CAN_CTXMSG_INC_8, 4, 4, False),
        (vci.CAN_CTXMSG_INC_16, 2, 4, True),
        (vci.CAN_CTXMSG_INC_16, 3, 4, False),
        (vci.CAN_CTXMSG_INC_8, 0, 0, False),
        (4, 0, 8, False),
    ],
)
def test_what_counts_up_lies_in_the_data(
    bench: Bench, mode: int, byte_index: int, length: int, fits: bool
) -> None:
    message = cyclic(1, 10, bytes(length), incr_mode=mode, byte_index=byte_index)
    if fits:
        bench.add(message)
        return
    with pytest.raises(vci.VciInvalidArgument):
        bench.add(message)


# running


@pytest.mark.conforms("X3-32", "X3-33", "X4-41")
def test_states(virtual: Virtual) -> None:
    bench = Bench(virtual.program)
    scheduler = bench.scheduler

    def states() -> tuple[int, list[int]]:
        status = scheduler.get_status()
        return status.task_stat, list(status.msg_stat[:3])

    empty, busy, done = vci.CAN_CTXMSG_STAT_EMPTY, vci.CAN_CTXMSG_STAT_BUSY, vci.CAN_CTXMSG_STAT_DONE
    stopped, running = vci.CAN_CTXTSK_STAT_STOPPED, vci.CAN_CTXTSK_STAT_RUNNING
    assert states() == (stopped, [empty] * 3)
    one, two = bench.add(cyclic(1, 10)), bench.add(cyclic(2, 10))
    assert states() == (stopped, [empty] * 3)
    scheduler.start_message(one, 3)
    scheduler.start_message(two, 0)
    assert states() == (stopped, [busy, busy, empty])
    scheduler.resume()
    assert states() == (running, [busy, busy, empty])
    bench.port.messages(8)
    assert states() == (running, [done, busy, empty])
    scheduler.stop_message(two)
    assert states() == (running, [done, done, empty])
    scheduler.suspend()
    assert states() == (stopped, [done, done, empty])
    scheduler.reset()
    assert states() == (stopped, [empty] * 3)
    assert scheduler.get_status().line_status.btp_sdr == bench.control.get_line_status().btp_sdr


@pytest.mark.conforms("X3-32")
def test_new_objects_are_idle(bench: Bench) -> None:
    idle = bench.add(cyclic(1, 5))
    bench.started(cyclic(2, 5))
    bench.scheduler.resume()
    assert {one.msg_id for one in bench.port.messages(5)} == {2}
    bench.scheduler.start_message(idle)
    while bench.port.message().msg_id != 1:
        pass


@pytest.mark.conforms("X3-32")
def test_until_resume_nothing_is_sent(bench: Bench, program: Program) -> None:
    bench.started(cyclic(1, 5))
    program.port(0).send(vci.CanMsg2(msg_id=0x99))
    assert bench.port.message().msg_id == 0x99
    bench.scheduler.resume()
    assert bench.port.message().msg_id == 1


@pytest.mark.conforms("X3-32")
def test_all_start_in_the_same_tick(virtual: Virtual) -> None:
    bench = Bench(virtual.program)
    bench.started(*(cyclic(number, 20) for number in range(1, 5)))
    virtual.hub.run_for(0.01)
    bench.scheduler.resume()
    found = bench.port.messages(8)
    assert [one.msg_id for one in found] == [1, 2, 3, 4] * 2
    assert slots(found, 20) == [20, 21, 22, 23, 40, 41, 42, 43]


@pytest.mark.conforms("X3-32")
def test_suspend_stops_all_and_resume_goes_on(bench: Bench, program: Program) -> None:
    bench.started(cyclic(1, 5), cyclic(2, 5))
    bench.scheduler.resume()
    bench.port.messages(4)
    bench.scheduler.suspend()
    sender = program.port(0)
    sender.send(vci.CanMsg2(msg_id=0x700))
    while bench.port.message().msg_id != 0x700:
        pass
    sender.send(vci.CanMsg2(msg_id=0x701))
    assert bench.port.message().msg_id == 0x701
    bench.scheduler.resume()
    assert {one.msg_id for one in bench.port.messages(4)} == {1, 2}


@pytest.mark.conforms("X4-41")
@pytest.mark.parametrize("count", [1, 2, 7])
def test_so_many_times(bench: Bench, program: Program, count: int) -> None:
    (index,) = bench.started(cyclic(1, 2), count=count)
    bench.scheduler.resume()
    assert [one.msg_id for one in bench.port.messages(count)] == [1] * count
    assert bench.scheduler.get_status().msg_stat[index] == vci.CAN_CTXMSG_STAT_DONE
    program.port(0).send(vci.CanMsg2(msg_id=0x700))
    assert bench.port.message().msg_id == 0x700


@pytest.mark.conforms("X4-41")
def test_counts_and_indices(bench: Bench) -> None:
    index = bench.add(cyclic(1, 10))
    bench.scheduler.start_message(index, 65535)
    for count in (-1, 65536):
        with pytest.raises(vci.VciInvalidArgument):
            bench.scheduler.start_message(index, count)
    for wrong in (1, 15, 16, -1, 0xFFFF_FFFF):
        for call in (
            bench.scheduler.start_message,
            bench.scheduler.stop_message,
            bench.scheduler.rem_message,
        ):
            with pytest.raises(vci.VciInvalidIndex):
                call(wrong)


@pytest.mark.conforms("X4-40")
def test_the_list_runs_on_without_the_control(program: Program, other_program: Program) -> None:
    port = program.port(1)
    program.start(1)
    scheduler = program.open(vci.IID_ICanScheduler2)
    with other_program.bal().open_socket(0, vci.IID_ICanControl2) as control:
        control.init_line(program.init())
        control.start_line()
    scheduler.start_message(scheduler.add_message(cyclic(1, 5)))
    scheduler.resume()
    assert [one.msg_id for one in port.messages(3)] == [1] * 3


# messages


@pytest.mark.conforms("X4-42")
def test_long_messages(program: Program) -> None:
    bench = Bench(program, ex_mode=vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA)
    data = bytes(range(64))
    bench.started(cyclic(1, 1, data, edl=1, fdr=1, incr_mode=vci.CAN_CTXMSG_INC_16, byte_index=62), count=3)
    bench.scheduler.resume()
    found = bench.port.messages(3)
    assert [one.data for one in found] == [data[:62] + bytes([62 + k, 63]) for k in range(3)]
    assert all(one.msg_info.fdr for one in found)
    with pytest.raises(vci.VciInvalidArgument):
        bench.add(cyclic(1, 9, data, edl=1, incr_mode=vci.CAN_CTXMSG_INC_16, byte_index=63))


@pytest.mark.conforms("X4-15", "X4-42")
def test_a_classic_line_takes_no_long_messages(bench: Bench) -> None:
    with pytest.raises(vci.VciInvalidState):
        bench.add(cyclic(1, 10, bytes(12), edl=1))


@pytest.mark.parametrize(
    "message",
    [
        vci.CanCyclicTxMsg2(cycle_time=10, msg_id=0x800),
        vci.CanCyclicTxMsg2(cycle_time=10, msg_id=1 << 29, ext=1),
        vci.CanCyclicTxMsg2(cycle_time=10, type=vci.CAN_MSGTYPE_INFO),
        vci.CanCyclicTxMsg(cycle_time=10),
        vci.CanMsg2(),
    ],
)
def test_messages_that_no_line_can_send(bench: Bench, message: Any) -> None:
    with pytest.raises(vci.VciInvalidArgument):
        bench.add(message)


def test_the_old_interface_has_the_same_list(program: Program) -> None:
    bench = Bench(program, vci.IID_ICanScheduler)
    message = vci.CanCyclicTxMsg(cycle_time=2, msg_id=0x123, data=b"12345678", incr_mode=vci.CAN_CTXMSG_INC_8)
    bench.started(message, count=2)
    bench.scheduler.resume()
    assert [one.data for one in bench.port.messages(2)] == [b"12345678", b"22345678"]
    status = bench.scheduler.get_status()
    assert isinstance(status, vci.CanSchedulerStatus)
    assert status.msg_stat[0] == vci.CAN_CTXMSG_STAT_DONE
    message.msg_info.edl = 1
    with pytest.raises(vci.VciInvalidArgument, match="ICanScheduler2"):
        bench.add(message)


def test_self_reception_works_from_the_list(bench: Bench, program: Program) -> None:
    old = program.old_port(0)
    bench.started(cyclic(0x42, 1, srr=1), count=1)
    bench.scheduler.resume()
    assert (old.message().msg_id, bench.port.message().msg_id) == (0x42, 0x42)


def test_remote_requests_from_the_list(bench: Bench) -> None:
    bench.started(cyclic(0x42, 1, rtr=1, dlc=4), count=1)
    bench.scheduler.resume()
    found = bench.port.message()
    assert (found.msg_info.rtr, found.msg_info.dlc) == (1, 4)
