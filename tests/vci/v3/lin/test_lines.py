"""LIN lines under the names of V3: ILinSocket, ILinMonitor, ILinMessageReader and ILinControl."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from typing import Any

import pytest

from canwire import vci
from canwire.vci import v3
from tests.vci.v3.programs import NetProgram

FD_BOARD = "HW000001"
PORT = 2
LONG_MS = 30_000
SLAVE, MASTER, ERRORS = v3.LinOperatingModes.SLAVE, v3.LinOperatingModes.MASTER, v3.LinOperatingModes.ERRORS
DATA, INFO, ERROR = v3.LinMessageType.DATA, v3.LinMessageType.INFO, v3.LinMessageType.ERROR


class LinPort:
    """A monitor with its reader open."""

    def __init__(self, monitor: v3.LinMonitor) -> None:
        self.monitor = monitor
        self.reader = monitor.get_message_reader()
        self.event = v3.AutoResetEvent()
        self.reader.assign_event(self.event)

    def receive(self, count: int = 1, kind: v3.LinMessageType = DATA) -> list[v3.LinMessage]:
        """The next `count` messages of this type; others on the way are dropped."""
        found: list[v3.LinMessage] = []
        while len(found) < count:
            message = self.reader.read_message()
            if message is None:
                assert self.event.wait_one(LONG_MS), f"{len(found)} of {count} messages came: {found}"
            elif message.message_type == kind:
                found.append(message)
        return found

    def close(self) -> None:
        self.reader.dispose()
        self.event.close()


class Lin:
    """The LIN lines of a program's boards."""

    def __init__(self, net: NetProgram) -> None:
        self.net = net
        self._opened = contextlib.ExitStack()

    def open(self, kind: Any, board: str = FD_BOARD) -> Any:
        return self.net.open(kind, PORT, board)

    def control(
        self,
        board: str = FD_BOARD,
        *,
        mode: v3.LinOperatingModes = SLAVE,
        bitrate: v3.LinBitrate = v3.LinBitrate.LIN_19200_BIT,
    ) -> v3.LinControl:
        """A control unit that is online."""
        control: v3.LinControl = self.open(v3.LinControl, board)
        control.init_line(v3.LinInitLine(mode, bitrate))
        control.start_line()
        return control

    def port(self, board: str = FD_BOARD, *, exclusive: bool = False) -> LinPort:
        monitor: v3.LinMonitor = self.open(v3.LinMonitor, board)
        monitor.initialize(200, exclusive)
        made = self._opened.enter_context(contextlib.closing(LinPort(monitor)))
        monitor.activate()
        return made

    def close(self) -> None:
        self._opened.close()


@pytest.fixture
def lin(net: NetProgram) -> Iterator[Lin]:
    with contextlib.closing(Lin(net)) as made:
        yield made


@pytest.fixture
def other_lin(other_net: NetProgram) -> Iterator[Lin]:
    with contextlib.closing(Lin(other_net)) as made:
        yield made


def message(identifier: int, data: bytes = b"", **properties: Any) -> v3.LinMessage:
    made = v3.LinMessage()
    made.prot_id, made.data_length, made.extended_crc = identifier, len(data), True
    for index, byte in enumerate(data):
        made[index] = byte
    for name, value in properties.items():
        setattr(made, name, value)
    return made


def header(identifier: int, length: int) -> v3.LinMessage:
    return message(identifier, id_only=True, data_length=length)


def send(control: v3.LinControl, *messages: v3.LinMessage) -> None:
    """Put messages on the bus, each as soon as the one before is over."""
    for one in messages:
        deadline = time.monotonic() + LONG_MS / 1000
        while not sent(control, one):
            assert time.monotonic() < deadline, f"always busy before {one}"


def sent(control: v3.LinControl, one: v3.LinMessage) -> bool:
    try:
        control.write_message(True, one)
    except v3.VciException as error:
        if error.code != vci.VCI_E_BUSY:
            raise
        return False
    return True


def data_of(one: v3.LinMessage) -> bytes:
    return bytes(one[index] for index in range(one.data_length))


# opening


@pytest.mark.conforms("X3-36")
@pytest.mark.parametrize("kind", [v3.LinSocket, v3.LinMonitor, v3.LinControl])
def test_lin_interfaces_open_on_a_lin_connector_alone(net: NetProgram, kind: Any) -> None:
    with net.bal() as bal:
        with bal.open_socket(PORT, kind) as opened:
            assert type(opened) is kind
            assert (opened.bus_port, opened.bus_type, opened.bus_name) == (PORT, v3.VciBusType.LIN, "LIN-1")
        for port in (0, 1):
            with pytest.raises(v3.NotImplementedException):
                bal.open_socket(port, kind)


@pytest.mark.conforms("X3-36")
def test_a_socket_tells_what_the_line_can(lin: Lin) -> None:
    socket = lin.open(v3.LinSocket)
    assert socket.features == ~v3.LinFeatures(0)
    assert socket.supports_master_mode
    assert socket.supports_autorate
    assert socket.supports_error_frames
    assert socket.supports_bus_load_computation
    assert (socket.clock_frequency, socket.time_stamp_counter_divisor) == (80_000_000, 80)
    assert not hasattr(socket, "start_line")


@pytest.mark.conforms("X3-36")
def test_one_program_has_the_control_unit(lin: Lin, other_lin: Lin) -> None:
    control = lin.control(mode=MASTER | ERRORS)
    with pytest.raises(v3.VciException) as raised:
        other_lin.open(v3.LinControl)
    assert raised.value.code == vci.VCI_E_ACCESSDENIED
    status = other_lin.open(v3.LinSocket).line_status
    assert (status.is_in_master_mode, status.is_in_slave_mode, status.is_err_mode_enabled) == (
        True,
        False,
        True,
    )
    assert (status.bitrate, status.is_in_init_mode) == (v3.LinBitrate.LIN_19200_BIT, False)
    control.dispose()
    other_lin.control()


# monitors


@pytest.mark.conforms("X3-36")
def test_a_monitor_that_is_not_initialised_is_as_good_as_disposed(lin: Lin) -> None:
    monitor = lin.open(v3.LinMonitor)
    for call in (
        monitor.activate,
        monitor.deactivate,
        monitor.get_message_reader,
        lambda: monitor.monitor_status,
    ):
        with pytest.raises(v3.ObjectDisposedException):
            call()
    for wrong in (0, -1, 65_536):
        with pytest.raises(v3.ArgumentException):
            monitor.initialize(wrong, False)
    monitor.initialize(1, False)
    status = monitor.monitor_status
    assert (status.is_activated, status.has_fifo_overrun, status.receive_fifo_load) == (False, False, 0)
    monitor.activate()
    assert monitor.monitor_status.is_activated


@pytest.mark.conforms("X3-36")
def test_an_exclusive_monitor_is_alone(lin: Lin, other_lin: Lin) -> None:
    port, second = lin.port(), other_lin.open(v3.LinMonitor)
    with pytest.raises(v3.VciException) as raised:
        port.monitor.initialize(10, True)
    assert raised.value.code == vci.VCI_E_ACCESSDENIED
    second.dispose()
    port.monitor.initialize(10, True)
    with pytest.raises(v3.VciException):
        other_lin.open(v3.LinMonitor)
    port.monitor.initialize(10, False)
    other_lin.open(v3.LinMonitor).initialize(10, False)


@pytest.mark.conforms("X3-36", "X3-37")
def test_initialising_a_monitor_keeps_the_lines_settings(lin: Lin) -> None:
    monitor = lin.open(v3.LinMonitor)
    control = lin.control(bitrate=v3.LinBitrate.LIN_2400_BIT)
    control.dispose()
    monitor.initialize(10, True)
    status = monitor.line_status
    assert (status.bitrate, status.is_in_init_mode) == (v3.LinBitrate.LIN_2400_BIT, False)


@pytest.mark.conforms("X3-36", "X3-40")
def test_messages_are_read_one_by_one_and_many_at_once(lin: Lin, lin_board: str) -> None:
    port, watcher = lin.port(), lin.port(lin_board)
    lin.control()
    port.receive(kind=INFO)
    port.reader.read_messages(10)
    send(lin.control(lin_board, mode=MASTER), *(message(k, bytes([k])) for k in range(1, 5)))
    watcher.receive(4)
    reader = port.reader
    assert (reader.fill_count, reader.capacity) == (4, 254)
    first = reader.read_message()
    assert first is not None
    assert (first.prot_id & 0x3F, data_of(first), first.message_type) == (1, b"\x01", DATA)
    out = v3.LinMessage()
    assert reader.read_message(out)
    assert data_of(out) == b"\x02"
    found: list[Any] = [None] * 10
    assert reader.read_messages(found) == 2
    assert [data_of(one) for one in found[:2]] == [b"\x03", b"\x04"]
    assert reader.read_message() is None
    assert not reader.read_message(out)
    assert reader.read_messages(5) == []
    reader.threshold = 1000
    assert reader.threshold == 254
    assert not hasattr(reader, "lock")
    reader.dispose()
    assert (reader.fill_count, reader.capacity) == (0, 0)
    with pytest.raises(v3.ObjectDisposedException):
        reader.read_message()


@pytest.mark.conforms("X3-43")
def test_fifos_survive_stop_and_reset(lin: Lin, lin_board: str) -> None:
    port, watcher, slave = lin.port(), lin.port(lin_board), lin.control()
    send(lin.control(lin_board, mode=MASTER), message(1, b"1"), message(2, b"2"))
    watcher.receive(2)
    slave.stop_line()
    slave.reset_line()
    found = port.reader.read_messages(100)
    assert [data_of(one) for one in found if one.message_type == DATA] == [b"1", b"2"]
    told = [v3.LinMsgInfoValue(one[0]) for one in found if one.message_type == INFO]
    info = v3.LinMsgInfoValue
    assert told == [info.START, info.STOP, info.RESET]


# the control unit


@pytest.mark.conforms("X3-37")
def test_states(lin: Lin) -> None:
    control = lin.open(v3.LinControl)
    assert control.line_status.bitrate == v3.LinBitrate.UNDEFINED
    for call in (control.start_line, lambda: control.write_message(False, message(1, b"1"))):
        with pytest.raises(v3.VciException):
            call()
    control.stop_line()
    control.reset_line()
    assert control.line_status.bitrate == v3.LinBitrate.UNDEFINED
    for bitrate in (v3.LinBitrate.UNDEFINED, v3.LinBitrate(999), v3.LinBitrate(20_001)):
        with pytest.raises(v3.ArgumentException):
            control.init_line(v3.LinInitLine(SLAVE, bitrate))
    for wrong in (None, vci.LinInitLine(bitrate=9600)):
        with pytest.raises(v3.ArgumentException):
            control.init_line(wrong)
    control.init_line(v3.LinInitLine(MASTER, v3.LinBitrate.LIN_9600_BIT))
    assert control.line_status.is_in_init_mode
    control.start_line()
    assert not control.line_status.is_in_init_mode
    control.stop_line()
    assert control.line_status.is_in_init_mode


@pytest.mark.conforms("X3-37")
def test_after_a_reset_the_line_is_offline_with_its_settings(lin: Lin) -> None:
    control = lin.control(mode=MASTER | ERRORS, bitrate=v3.LinBitrate.LIN_9600_BIT)
    control.reset_line()
    status = control.line_status
    assert (status.operating_mode, status.bitrate) == (MASTER | ERRORS, v3.LinBitrate.LIN_9600_BIT)
    assert status.is_in_init_mode
    control.start_line()


@pytest.mark.conforms("X3-37")
def test_a_slave_finds_the_bit_rate(lin: Lin, lin_board: str) -> None:
    port, watcher = lin.port(), lin.port(lin_board)
    slave = lin.control(bitrate=v3.LinBitrate.AUTO_RATE)
    master = lin.control(lin_board, mode=MASTER, bitrate=v3.LinBitrate.LIN_9600_BIT)
    for number in range(4):
        send(master, message(number, b"x"))
        watcher.receive()
    assert data_of(port.receive()[0]) == b"x"
    assert abs(slave.line_status.bitrate.as_uint16 - 9600) <= 96


@pytest.mark.conforms("X3-38", "X3-40")
def test_headers_are_answered_from_the_table(lin: Lin, lin_board: str) -> None:
    port, own = lin.port(lin_board), lin.port()
    slave, master = lin.control(), lin.control(lin_board, mode=MASTER | ERRORS)
    for identifier in (0, 63):
        slave.write_message(False, message(identifier, b"old", extended_crc=identifier == 0))
    slave.write_message(False, message(0, b"new"))
    send(master, header(0, 3), header(63, 3))
    zero, last = port.receive(2)
    assert (data_of(zero), zero.extended_crc, zero.sender_of_response, zero.id_only) == (
        b"new",
        True,
        False,
        False,
    )
    assert (data_of(last), last.extended_crc) == (b"old", False)
    assert [one.sender_of_response for one in own.receive(2)] == [True, True]
    slave.reset_line()
    slave.start_line()
    send(master, header(0, 3))
    (error,) = port.receive(kind=ERROR)
    assert (error.prot_id, error[0]) == (0xFF, v3.LinMsgError.SLAVE_NO_RESPONSE)


@pytest.mark.conforms("X3-39")
def test_who_sends_what(lin: Lin, lin_board: str) -> None:
    sleep, wakeup = (
        message(0, message_type=getattr(v3.LinMessageType, name)) for name in ("SLEEP", "WAKEUP")
    )
    port, slave, master = lin.port(), lin.control(), lin.control(lin_board, mode=MASTER)
    for refused in (message(1, b"1"), header(1, 1), sleep):
        with pytest.raises(v3.VciException) as raised:
            slave.write_message(True, refused)
        assert raised.value.code == vci.VCI_E_INVALID_STATE
    send(master, message(1, b"1"), sleep)
    assert [data_of(one) for one in port.receive(2)] == [b"1", b"\0" + b"\xff" * 7]
    send(slave, wakeup)
    send(master, wakeup, message(2, b"2"))
    assert data_of(port.receive()[0]) == b"2"
    for wrong in (message(0x41, b"1"), message(0, message_type=INFO), vci.LinMsg(), None):
        with pytest.raises(v3.ArgumentException):
            master.write_message(True, wrong)


@pytest.mark.conforms("X3-41")
def test_a_message_before_the_one_before_is_over(virtual_net: NetProgram) -> None:
    """Time stands still between the calls."""
    with contextlib.closing(Lin(virtual_net)) as lin:
        port, control = lin.port(), lin.control(mode=MASTER)
        control.write_message(True, message(1, b"12345678"))
        assert not sent(control, message(2, b"2"))
        assert data_of(port.receive()[0]) == b"12345678"
        assert sent(control, message(2, b"2"))
        assert data_of(port.receive()[0]) == b"2"
