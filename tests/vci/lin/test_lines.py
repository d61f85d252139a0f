"""LIN lines: sockets, control units and monitors, and what goes over the bus between two boards."""

from __future__ import annotations

import time
from typing import Any

import numpy
import pytest

import canwire
from canwire import vci
from canwire.bus.lin.faults import LinFaults
from canwire.vci.fifo.elements import LIN_MSGS
from tests.vci.programs import Program, Virtual

FD_BOARD, CLASSIC_BOARD = "HW000001", "HW000002"
LINE = 2
SLAVE, MASTER, ERRORS = vci.LIN_OPMODE_SLAVE, vci.LIN_OPMODE_MASTER, vci.LIN_OPMODE_ERRORS
SLEEP, WAKEUP = vci.LinMsg(type=vci.LIN_MSGTYPE_SLEEP), vci.LinMsg(type=vci.LIN_MSGTYPE_WAKEUP)
LONG = 30


def message(pid: int, data: bytes = b"", **bits: int) -> vci.LinMsg:
    return vci.LinMsg(pid=pid, data=data, **bits)


def header(pid: int, length: int) -> vci.LinMsg:
    return vci.LinMsg(pid=pid, ido=1, dlen=length, ecs=1)


def send(control: Any, *messages: vci.LinMsg) -> None:
    """Put messages on the bus, each as soon as the one before is over."""
    for one in messages:
        deadline = time.monotonic() + LONG
        while not sent(control, one):
            if control._lease.hub.virtual:
                control._lease.hub.run_for(0.001)
            assert time.monotonic() < deadline, f"always busy before {one}"


def sent(control: Any, one: vci.LinMsg) -> bool:
    try:
        control.write_message(True, one)
    except vci.VciError as error:
        if error.code != vci.VCI_E_BUSY:
            raise
        return False
    return True


def shown(messages: list[Any]) -> list[tuple[int, bytes]]:
    return [(one.msg_info.pid & vci.LIN_PIDMASK_ID, one.data) for one in messages]


def settings(status: vci.LinLineStatus) -> tuple[int, int, int]:
    """All but the load, which changes by itself."""
    return status.op_mode, status.bitrate, status.status


def of_type(messages: list[Any], kind: int) -> list[Any]:
    return [one for one in messages if one.msg_info.type == kind]


# interfaces


@pytest.mark.conforms("X3-36")
def test_a_lin_connector_has_lin_interfaces(program: Program) -> None:
    kinds = {vci.IID_ILinSocket: vci.LinSocket, vci.IID_ILinControl: vci.LinControl}
    for iid, kind in kinds.items():
        opened = program.open(iid, LINE)
        assert type(opened) is kind
        assert opened.query_interface(iid) is opened
        opened.release()
        with pytest.raises(vci.VciNoInterface):
            opened.query_interface(vci.IID_ICanSocket)
        for board, line in ((FD_BOARD, 0), (CLASSIC_BOARD, 1)):
            with pytest.raises(vci.VciNotImplemented, match=r"CAN-. has no ILin"):
                program.open(iid, line, board)
    for absent in (vci.IID_ICanSocket, vci.IID_ICanSocket2, vci.IID_ICanControl2, vci.IID_ICanScheduler):
        with pytest.raises(vci.VciNotImplemented, match="LIN-1 has no ICan"):
            program.open(absent, LINE)
    with pytest.raises(vci.VciNotImplemented):  # it comes from CreateMonitor
        program.open(vci.IID_ILinMonitor, LINE)


@pytest.mark.conforms("X3-36")
def test_the_connector(program: Program) -> None:
    info = program.open(vci.IID_ILinSocket, LINE).get_socket_info()
    assert (info.socket_no, info.bus_type) == (LINE, vci.VCI_LIN_GENERIC)
    assert info.object_id != program.open(vci.IID_ICanSocket, 0).get_socket_info().object_id


@pytest.mark.conforms("X4-44")
def test_capabilities(program: Program) -> None:
    capabilities = program.open(vci.IID_ILinSocket, LINE).get_capabilities()
    every = ("MASTER", "AUTORATE", "ERRFRAME", "BUSLOAD", "SLEEP", "WAKEUP")
    assert capabilities.features == sum(getattr(vci, f"LIN_FEATURE_{name}") for name in every)
    assert (capabilities.clock_freq, capabilities.tsc_divisor) == (80_000_000, 80)


@pytest.mark.conforms("X3-36")
def test_one_program_has_the_control_and_all_look(program: Program, other_program: Program) -> None:
    control = program.lin()
    with pytest.raises(vci.VciAccessDenied):
        other_program.open(vci.IID_ILinControl, LINE)
    socket = other_program.open(vci.IID_ILinSocket, LINE)
    assert settings(socket.get_line_status()) == settings(control.get_line_status()) == (SLAVE, 19_200, 0)
    assert control.release() == 0
    other_program.lin()


@pytest.mark.conforms("X3-36")
def test_an_exclusive_monitor_is_alone(program: Program, other_program: Program) -> None:
    socket, other = (one.open(vci.IID_ILinSocket, LINE) for one in (program, other_program))
    with socket.create_monitor(True):
        for refused in (socket, other):
            with pytest.raises(vci.VciAccessDenied):
                refused.create_monitor(False)
    with socket.create_monitor(False), other.create_monitor(False), pytest.raises(vci.VciAccessDenied):
        other.create_monitor(True)
    other.create_monitor(True).release()


@pytest.mark.conforms("X3-36")
def test_all_monitors_of_a_line_get_the_same(
    program: Program, other_program: Program, lin_board: str
) -> None:
    ports = [program.monitor(), program.monitor(), other_program.monitor(), program.monitor(lin_board)]
    program.lin()
    send(program.lin(lin_board, op_mode=MASTER), *(message(k, bytes([k]), ecs=1) for k in range(5)))
    for port in ports:
        assert shown(port.messages(5)) == [(k, bytes([k])) for k in range(5)]


@pytest.mark.conforms("X3-36")
def test_an_exclusive_monitor_gets_the_same(program: Program, lin_board: str) -> None:
    port = program.monitor(exclusive=True)
    program.lin()
    send(program.lin(lin_board, op_mode=MASTER), message(5, b"abc", ecs=1))
    assert shown([port.message()]) == [(5, b"abc")]


# life of a monitor


@pytest.mark.conforms("X3-36")
def test_before_it_is_initialised_a_monitor_can_do_nothing(program: Program) -> None:
    monitor = program.keep(program.open(vci.IID_ILinSocket, LINE).create_monitor())
    for call in (monitor.activate, monitor.deactivate, monitor.get_reader):
        with pytest.raises(vci.VciNotInitialized):
            call()
    for wrong in (0, -1, 65_536, "1"):
        with pytest.raises(vci.VciInvalidArgument):
            monitor.initialize(wrong)
    status = monitor.get_status()
    assert (status.activated, status.rx_overrun, status.rx_fifo_load) == (False, False, 0)
    assert not hasattr(monitor, "get_writer")


@pytest.mark.conforms("X3-36")
def test_a_monitors_fifo_takes_whole_pages(program: Program) -> None:
    reader = program.monitor(rx=1).reader
    assert (reader.get_entry_size(), reader.get_capacity()) == (16, 254)
    assert program.monitor(rx=255).reader.get_capacity() == 510


@pytest.mark.conforms("X3-36")
def test_a_monitor_has_one_reader_until_it_is_initialised_anew(program: Program) -> None:
    monitor = program.keep(program.open(vci.IID_ILinSocket, LINE).create_monitor())
    monitor.initialize(10)
    monitor.activate()
    reader = monitor.get_reader()
    with pytest.raises(vci.VciAccessDenied):
        monitor.get_reader()
    assert reader.release() == 0
    reader = monitor.get_reader()
    monitor.initialize(10)
    assert not monitor.get_status().activated
    with pytest.raises(vci.VciError) as raised:
        reader.get_fill_count()
    assert raised.value.code == vci.VCI_E_INVHANDLE
    monitor.get_reader().release()


@pytest.mark.conforms("X3-36")
def test_an_inactive_monitor_gets_nothing(program: Program, lin_board: str) -> None:
    awake, asleep = program.monitor(), program.monitor(active=False)
    program.lin()
    master = program.lin(lin_board, op_mode=MASTER)
    send(master, message(1, b"1", ecs=1))
    awake.message()
    asleep.channel.activate()
    send(master, message(2, b"2", ecs=1))
    assert shown([asleep.message()]) == [(2, b"2")]
    asleep.channel.deactivate()
    send(master, message(3, b"3", ecs=1))
    assert shown(awake.messages(2)) == [(2, b"2"), (3, b"3")]
    assert asleep.waiting() == []


def test_acquired_messages_lie_in_the_fifo(program: Program, lin_board: str) -> None:
    port = program.monitor()
    program.lin()
    port.message(vci.LIN_MSGTYPE_INFO)
    port.waiting()
    watcher = program.monitor()
    send(program.lin(lin_board, op_mode=MASTER), message(0x10, b"hello", ecs=1), message(0x11, b"!"))
    watcher.messages(2)
    block, count = port.reader.acquire_read()
    assert count == 2
    one, two = block
    assert (one.msg_info.pid, one.data, two.data) == (0x50, b"hello", b"!")
    assert bytes(block.memory) == one.to_bytes() + two.to_bytes()
    records = block.records
    assert records.dtype == vci.linmsg_view_dtype()
    assert records["dwTime"].tolist() == [one.time, two.time]
    assert records["uMsgInfo"].tolist() == [one.msg_info.value, two.msg_info.value]
    assert records["abData"][0].tobytes() == b"hello\0\0\0"
    compact = numpy.frombuffer(block.memory, vci.linmsg_dtype())
    assert compact["uMsgInfo"].tolist() == records["uMsgInfo"].tolist()
    port.reader.release_read(1)
    assert port.reader.get_data_entry() == two


def test_elements_in_their_cells() -> None:
    made = message(0x50, b"12345678", time=0x11223344, ecs=1)
    cell = LIN_MSGS.store(made)
    assert len(cell) == LIN_MSGS.cell == 80
    assert LIN_MSGS.load(cell) == made
    assert (
        cell[:4] + cell[12:24] == made.to_bytes() == bytes(LIN_MSGS.compact(memoryview(cell), writable=False))
    )
    with pytest.raises(vci.VciInvalidArgument):
        LIN_MSGS.store(vci.CanMsg())
    LIN_MSGS.settle(memoryview(bytearray(cell)))


# the control unit


@pytest.mark.conforms("X3-37", "X4-47")
def test_states(program: Program) -> None:
    control = program.open(vci.IID_ILinControl, LINE)
    undefined = settings(control.get_line_status())
    assert undefined == (SLAVE, vci.LIN_BITRATE_UNDEF, vci.LIN_STATUS_ININIT)
    with pytest.raises(vci.VciNotInitialized):
        control.start_line()
    control.stop_line()
    control.reset_line()
    control.init_line(vci.LinInitLine(op_mode=MASTER | ERRORS, bitrate=9600))
    offline = settings(control.get_line_status())
    assert offline == (
        MASTER | ERRORS,
        9600,
        vci.LIN_STATUS_ININIT,
    )
    control.start_line()
    control.start_line()
    assert settings(control.get_line_status()) == (MASTER | ERRORS, 9600, 0)
    control.stop_line()
    assert settings(control.get_line_status()) == offline
    control.start_line()
    control.init_line(vci.LinInitLine(op_mode=SLAVE, bitrate=2400))
    assert settings(control.get_line_status()) == (SLAVE, 2400, vci.LIN_STATUS_ININIT)
    control.start_line()
    control.reset_line()
    assert settings(control.get_line_status()) == undefined
    with pytest.raises(vci.VciNotInitialized):
        control.start_line()


@pytest.mark.conforms("X3-37")
@pytest.mark.parametrize("bitrate", [1000, 2400, 9600, 10_400, 19_200, 20_000])
def test_bit_rates(program: Program, lin_board: str, bitrate: int) -> None:
    port = program.monitor()
    program.lin(bitrate=bitrate)
    master = program.lin(lin_board, op_mode=MASTER, bitrate=bitrate)
    assert master.get_line_status().bitrate == bitrate
    send(master, message(0x22, b"rate", ecs=1))
    assert shown([port.message()]) == [(0x22, b"rate")]


@pytest.mark.conforms("X3-37")
def test_impossible_settings(program: Program) -> None:
    control = program.open(vci.IID_ILinControl, LINE)
    control.init_line(vci.LinInitLine(op_mode=SLAVE, bitrate=9600))
    before = settings(control.get_line_status())
    for op_mode, bitrate in (
        (SLAVE, vci.LIN_BITRATE_UNDEF),
        (SLAVE, 999),
        (MASTER, 20_001),
        (MASTER, vci.LIN_BITRATE_AUTO),
        (4, 9600),
        (0x80 | MASTER, 9600),
    ):
        with pytest.raises(vci.VciInvalidArgument):
            control.init_line(vci.LinInitLine(op_mode=op_mode, bitrate=bitrate))
    for wrong in (vci.LinInitLine(bitrate=1 << 16), vci.CanInitLine(), None):
        with pytest.raises(vci.VciInvalidArgument):
            control.init_line(wrong)
    assert settings(control.get_line_status()) == before


@pytest.mark.conforms("X3-37")
def test_a_slave_finds_the_bit_rate(program: Program, lin_board: str) -> None:
    port = program.monitor()
    slave = program.lin(bitrate=vci.LIN_BITRATE_AUTO)
    assert slave.get_line_status().bitrate == vci.LIN_BITRATE_AUTO
    master, watcher = program.lin(lin_board, op_mode=MASTER, bitrate=9600), program.monitor(lin_board)
    for number in range(4):
        send(master, message(number, b"x", ecs=1))
        watcher.message()
    assert port.message().data == b"x"
    assert abs(slave.get_line_status().bitrate - 9600) <= 96


# sending and responding


@pytest.mark.conforms("X3-38", "X3-40", "X4-46")
def test_headers_are_answered_from_the_table(program: Program, lin_board: str) -> None:
    port, master_port = program.monitor(), program.monitor(lin_board)
    slave = program.open(vci.IID_ILinControl, LINE)
    with pytest.raises(vci.VciNotInitialized):
        slave.write_message(False, message(0, b"?", ecs=1))
    slave.init_line(vci.LinInitLine(op_mode=SLAVE, bitrate=19_200))
    slave.write_message(False, message(0, b"zero", ecs=1))
    slave.write_message(False, message(63, b"sixty-3!"))
    slave.start_line()
    master = program.lin(lin_board, op_mode=MASTER)
    send(master, header(0, 4), header(63, 8))
    answers = [(0, b"zero"), (63, b"sixty-3!")]
    for one, sor in ((port, 1), (master_port, 0)):
        found = one.messages(2)
        assert shown(found) == answers
        assert [each.msg_info.sor for each in found] == [sor, sor]
        assert [each.msg_info.ecs for each in found] == [1, 0]
        assert [each.msg_info.ido for each in found] == [0, 0]
    slave.write_message(False, message(0, b"new!", ecs=1))
    send(master, header(0, 4))
    assert shown([master_port.message()]) == [(0, b"new!")]
    slave.stop_line()
    slave.start_line()
    send(master, header(0, 4))
    assert shown([master_port.message()]) == [(0, b"new!")]


@pytest.mark.conforms("X3-38", "X3-40", "X4-45")
def test_reset_empties_the_table(program: Program, lin_board: str) -> None:
    slave = program.lin()
    slave.write_message(False, message(7, b"here", ecs=1))
    port, master = program.monitor(lin_board), program.lin(lin_board, op_mode=MASTER | ERRORS)
    send(master, header(7, 4))
    port.message()
    slave.reset_line()
    slave.init_line(vci.LinInitLine(op_mode=SLAVE, bitrate=19_200))
    slave.start_line()
    send(master, header(7, 4))
    error = port.message(vci.LIN_MSGTYPE_ERROR)
    assert (error.msg_info.pid, error.ab_data[0]) == (0xFF, vci.LIN_ERROR_SLNORE)
    assert port.waiting() == []


@pytest.mark.conforms("X3-38", "X3-40")
def test_a_master_answers_itself(program: Program) -> None:
    port, master = program.monitor(), program.lin(op_mode=MASTER)
    master.write_message(False, message(9, b"mine", ecs=1))
    send(master, header(9, 4))
    answer = port.message()
    assert (answer.data, answer.msg_info.sor) == (b"mine", 1)


@pytest.mark.conforms("X3-39")
def test_a_master_sends_data_sleep_and_wakeup(program: Program, lin_board: str) -> None:
    port, slave = program.monitor(), program.lin()
    master = program.lin(lin_board, op_mode=MASTER)
    send(master, message(0x10, b"data", ecs=1))
    data = port.message()
    assert (data.msg_info.pid, data.data, data.msg_info.sor) == (0x50, b"data", 0)
    send(master, SLEEP)
    command = port.message()
    assert (command.msg_info.pid, command.data) == (0x3C, b"\0" + b"\xff" * 7)
    assert port.message(vci.LIN_MSGTYPE_SLEEP).msg_info.pid == 0xFF
    send(master, WAKEUP)
    port.message(vci.LIN_MSGTYPE_STATUS)
    slave.write_message(False, message(1, b"awake", ecs=1))
    send(master, header(1, 5))
    assert shown([port.message()]) == [(1, b"awake")]


@pytest.mark.conforms("X3-39")
def test_a_slave_sends_nothing_but_wakeup(program: Program, lin_board: str) -> None:
    slave, master = program.lin(), program.lin(lin_board, op_mode=MASTER)
    port = program.monitor(lin_board)
    for refused in (message(1, b"1", ecs=1), header(1, 1), SLEEP):
        with pytest.raises(vci.VciInvalidState, match="slave"):
            slave.write_message(True, refused)
    send(master, SLEEP)
    port.message(vci.LIN_MSGTYPE_SLEEP)
    send(slave, WAKEUP)
    port.message(vci.LIN_MSGTYPE_STATUS)
    slave.write_message(False, message(1, b"1", ecs=1))
    send(master, header(1, 1))
    assert shown([port.message()]) == [(1, b"1")]


@pytest.mark.conforms("X3-39")
def test_a_line_that_is_not_started_sends_nothing(program: Program) -> None:
    control = program.open(vci.IID_ILinControl, LINE)
    for one in (message(1, b"1", ecs=1), SLEEP, WAKEUP):
        with pytest.raises(vci.VciNotInitialized):
            control.write_message(True, one)
    control.init_line(vci.LinInitLine(op_mode=MASTER, bitrate=19_200))
    for one in (message(1, b"1", ecs=1), header(1, 1), SLEEP, WAKEUP):
        with pytest.raises(vci.VciInvalidState, match="start"):
            control.write_message(True, one)


@pytest.mark.conforms("X3-38", "X3-39")
def test_messages_that_nobody_can_send(program: Program) -> None:
    control = program.lin(op_mode=MASTER)
    both = [
        message(0x40, b"1", ecs=1),  # identifier 0 has the parity bits 0x80
        message(0xFF, b"1", ecs=1),
        vci.LinMsg(pid=1, dlen=9, ecs=1),
        vci.LinMsg(pid=1, dlen=255, ecs=1),
        message(0x3C, b"12345678", ecs=1),
        *(vci.LinMsg(type=kind) for kind in (1, 2, 3, 6, 7)),
    ]
    for one in [*both, header(0x40, 1), header(1, 9)]:
        with pytest.raises(vci.VciInvalidArgument):
            control.write_message(True, one)
    for one in (*both, SLEEP, WAKEUP):
        with pytest.raises(vci.VciInvalidArgument):
            control.write_message(False, one)
    for wrong in (vci.CanMsg(), None, b"0123456789abcdef"):
        with pytest.raises(vci.VciInvalidArgument):
            control.write_message(True, wrong)


@pytest.mark.conforms("X3-41", "X4-47")
def test_a_message_before_the_one_before_is_over(virtual: Virtual) -> None:
    """Time stands still between the calls."""
    port, control = virtual.program.monitor(), virtual.program.lin(op_mode=MASTER)
    control.write_message(True, message(1, b"12345678", ecs=1))
    assert of_type(port.waiting(), vci.LIN_MSGTYPE_DATA) == []
    for one in (message(2, b"2", ecs=1), header(2, 1), SLEEP, WAKEUP):
        with pytest.raises(vci.VciError) as raised:
            control.write_message(True, one)
        assert raised.value.code == vci.VCI_E_BUSY
    control.write_message(False, message(2, b"2", ecs=1))
    assert control.get_line_status().status == vci.LIN_STATUS_TXPEND
    assert shown([port.message()]) == [(1, b"12345678")]
    assert control.get_line_status().status == 0
    control.write_message(True, header(2, 1))
    assert shown([port.message()]) == [(2, b"2")]


# what monitors are told


@pytest.mark.conforms("X3-43")
def test_fifos_keep_what_is_in_them(program: Program, lin_board: str) -> None:
    port, slave = program.monitor(), program.lin()
    watcher = program.monitor(lin_board)
    master = program.lin(lin_board, op_mode=MASTER)
    send(master, message(1, b"1", ecs=1), message(2, b"2", ecs=1))
    watcher.messages(2)
    slave.stop_line()
    slave.reset_line()
    found = port.waiting()
    assert shown(of_type(found, vci.LIN_MSGTYPE_DATA)) == [(1, b"1"), (2, b"2")]
    told = [one.ab_data[0] for one in of_type(found, vci.LIN_MSGTYPE_INFO)]
    assert told == [vci.LIN_INFO_START, vci.LIN_INFO_STOP, vci.LIN_INFO_RESET]
    for one in of_type(found, vci.LIN_MSGTYPE_INFO):
        assert (one.msg_info.pid, one.time) == (0xFF, 0)


@pytest.mark.conforms("X4-45")
def test_errors(virtual: Virtual) -> None:
    virtual.hub.plug("usb-to-can-fd", "HW000009")
    port, slave = virtual.program.monitor(), virtual.program.lin(op_mode=ERRORS)
    master = virtual.program.lin("HW000009", op_mode=MASTER | ERRORS)
    asking = virtual.program.monitor("HW000009")
    slave.write_message(False, message(1, b"1234", ecs=1))
    faults = LinFaults(virtual.world.buses["lin0"])

    def reported(by: Any) -> int:
        error = by.message(vci.LIN_MSGTYPE_ERROR)
        assert error.msg_info.pid == 0xFF
        assert error.ab_data[1] & vci.LIN_STATUS_ININIT == 0
        assert error.time > 0
        return int(error.ab_data[0])

    send(master, header(2, 4))
    assert reported(asking) == vci.LIN_ERROR_SLNORE
    faults.checksum(1)
    send(master, header(1, 4))
    assert reported(asking) == vci.LIN_ERROR_CHKSUM
    faults.flip(1, 3, 1)
    send(master, header(1, 4))
    assert (reported(port), reported(asking)) == (vci.LIN_ERROR_BIT, vci.LIN_ERROR_OTHER)
    faults.parity(1)
    send(master, header(1, 4))
    assert (reported(port), reported(asking)) == (vci.LIN_ERROR_PARITY, vci.LIN_ERROR_SLNORE)
    faults.sync(0x54)
    send(master, header(1, 4))
    assert (reported(port), reported(asking)) == (vci.LIN_ERROR_SYNC, vci.LIN_ERROR_SLNORE)
    faults.stop_bit(1, 1)
    send(master, header(1, 4))
    assert reported(asking) == vci.LIN_ERROR_OTHER
    asking.waiting()
    assert reported(asking) == vci.LIN_ERROR_NOBUS  # after seconds of silence


@pytest.mark.conforms("X4-45")
@pytest.mark.finding("vci F3")
def test_an_error_carries_the_low_byte_of_the_status(virtual: Virtual) -> None:
    """As it was at that moment: the line was still asking."""
    port, master = virtual.program.monitor(), virtual.program.lin(op_mode=MASTER | ERRORS)
    master.write_message(True, header(2, 4))
    assert master.get_line_status().status == vci.LIN_STATUS_TXPEND
    error = port.message(vci.LIN_MSGTYPE_ERROR)
    assert (error.ab_data[0], error.ab_data[1]) == (vci.LIN_ERROR_SLNORE, vci.LIN_STATUS_TXPEND)
    assert master.get_line_status().status == 0


@pytest.mark.conforms("X4-45")
def test_errors_are_reported_to_those_who_asked(virtual: Virtual) -> None:
    port, master = virtual.program.monitor(), virtual.program.lin(op_mode=MASTER)
    master.write_message(True, header(2, 4))
    master.stop_line()
    found = port.waiting()
    assert not of_type(found, vci.LIN_MSGTYPE_ERROR)
    assert of_type(found, vci.LIN_MSGTYPE_INFO)[-1].ab_data[0] == vci.LIN_INFO_STOP


@pytest.mark.conforms("X4-46")
def test_flags(program: Program, lin_board: str) -> None:
    port, own = program.monitor(), program.monitor(lin_board)
    program.lin()
    master = program.lin(lin_board, op_mode=MASTER)
    received = message(0x50, b"pid", ecs=1, sor=1, ovr=1, res=15, time=99)
    send(master, received, message(0x10, b"classic"), message(0x3C, b"\x01request"))
    enhanced, classic, diagnostic = port.messages(3)
    assert [one.msg_info.pid for one in (enhanced, classic, diagnostic)] == [0x50, 0x50, 0x3C]
    assert [one.msg_info.ecs for one in (enhanced, classic, diagnostic)] == [1, 0, 0]
    for one in (enhanced, classic, diagnostic):
        assert (one.msg_info.sor, one.msg_info.ovr, one.msg_info.ido, one.msg_info.res) == (0, 0, 0, 0)
    assert enhanced.time < classic.time < diagnostic.time
    assert [one.msg_info.sor for one in own.messages(3)] == [1, 1, 1]


@pytest.mark.conforms("X4-46", "X4-47")
def test_a_full_fifo(program: Program, lin_board: str) -> None:
    port, watcher = program.monitor(rx=1), program.monitor(rx=1000)
    program.lin()
    port.message(vci.LIN_MSGTYPE_INFO)
    port.waiting()
    master = program.lin(lin_board, op_mode=MASTER)
    capacity = port.reader.get_capacity()
    send(master, *(message(1, b"", ecs=1, dlen=1) for _ in range(capacity // 2)))
    watcher.messages(capacity // 2)
    status = port.channel.get_status()
    assert (status.activated, status.rx_overrun, status.rx_fifo_load) == (True, False, 50)
    send(master, *(message(1, b"", ecs=1, dlen=1) for _ in range(capacity // 2 + 5)))
    watcher.messages(capacity // 2 + 5)
    status = port.channel.get_status()
    assert (status.rx_overrun, status.rx_fifo_load) == (True, 100)
    assert status.line_status.status & vci.LIN_STATUS_OVRRUN
    assert [one.msg_info.ovr for one in port.waiting()] == [0] * (capacity - 1) + [1]
    assert port.channel.get_status().rx_overrun
    port.channel.deactivate()
    assert not port.channel.get_status().activated


@pytest.mark.conforms("X4-47")
def test_line_status(virtual: Virtual) -> None:
    program = virtual.program
    monitor, control = program.monitor(), program.lin(op_mode=MASTER | ERRORS, bitrate=9600)
    socket = program.open(vci.IID_ILinSocket, LINE)
    status = control.get_line_status()
    assert (status.op_mode, status.bitrate, status.status) == (MASTER | ERRORS, 9600, 0)
    assert status == socket.get_line_status() == monitor.channel.get_status().line_status
    control.write_message(True, message(1, b"12345678", ecs=1))
    assert socket.get_line_status().status == vci.LIN_STATUS_TXPEND
    monitor.message()
    assert 0 < socket.get_line_status().bus_load <= 100
    for _ in range(256):
        send(control, header(2, 1))
        monitor.message(vci.LIN_MSGTYPE_ERROR)
    assert socket.get_line_status().status & vci.LIN_STATUS_ERRLIM
    control.stop_line()
    assert socket.get_line_status().status & vci.LIN_STATUS_ININIT


def test_a_line_set_up_without_vci(hub: canwire.Hub, program: Program) -> None:
    board = hub.board(FD_BOARD).id
    with hub.open_lin_control(board, LINE) as control:
        control.initialise(canwire.LinMode(master=True, bit_rate=2400, errors=True))
        status = program.open(vci.IID_ILinSocket, LINE).get_line_status()
        assert (status.op_mode, status.bitrate) == (MASTER | ERRORS, 2400)


# pulled out


@pytest.mark.conforms("X3-36")
def test_a_board_pulled_out_says_so_on_every_handle(program: Program, hub: Any, event: canwire.Event) -> None:
    hub.plug("usb-to-can-fd", "HW000009")
    socket = program.open(vci.IID_ILinSocket, LINE, "HW000009")
    port, control = program.monitor("HW000009"), program.lin("HW000009")
    port.message(vci.LIN_MSGTYPE_INFO)
    port.reader.assign_event(event)
    hub.unplug("HW000009")
    assert event.wait(LONG)
    for call in (
        socket.get_line_status,
        socket.get_capabilities,
        socket.create_monitor,
        port.channel.get_status,
        port.channel.activate,
        port.reader.get_fill_count,
        control.stop_line,
        control.get_line_status,
        lambda: control.write_message(True, WAKEUP),
    ):
        with pytest.raises(vci.VciDeviceNotConnected):
            call()
