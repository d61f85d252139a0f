"""DeviceIoControl's 19 codes: sizes, accesses, effects (FS-37, FS-42..60)."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import pytest

from canwire import Frame
from canwire.candrv import Handle
from canwire.candrv import constants as c
from canwire.candrv.constants import CanbusEvent, Command, ControlCode, Win32Error
from canwire.candrv.errors import CandrvError
from canwire.candrv.event_queue import Event
from canwire.candrv.ioctl import CODES, control
from canwire.candrv.registry.registry import RegistryStore
from canwire.candrv.structures import (
    CAN_ACCEPTANCE_FILTER,
    CAN_EVENT,
    CAN_PROPERTIES,
    CAN_TIME,
    CAN_TRANSMIT_DATA,
)
from tests.candrv.bench import Bench

RECEIVED, TRANSMITTED = CanbusEvent.RECEIVED, CanbusEvent.TRANSMITTED


def dword(value: int) -> bytes:
    return struct.pack("<I", value)


def number(handle: Handle, code: int) -> int:
    return int.from_bytes(control(handle, code, b"", 4).data, "little")


def command(handle: Handle, number: int) -> None:
    control(handle, ControlCode.SET_COMMAND, dword(number))


def refusal(call: Callable[..., object], *args: Any, **kwargs: Any) -> int:
    with pytest.raises(CandrvError) as raised:
        call(*args, **kwargs)
    return raised.value.code


def events(handle: Handle) -> list[Event]:
    return [handle.read_event() for _ in range(handle.waiting)]


def kinds(handle: Handle) -> list[int]:
    return [event.event for event in events(handle)]


@pytest.fixture
def mode_2b(registry: RegistryStore) -> None:
    registry.set("CID1", "CanMode2B", 1)


# the table


def test_every_code_of_the_header_is_there() -> None:
    assert set(CODES) == set(ControlCode)
    assert len(CODES) == 19


@pytest.mark.parametrize("code", list(ControlCode), ids=lambda code: code.name)
def test_sizes_and_accesses_are_checked(bench: Bench, code: ControlCode) -> None:
    query, both, row = bench.open(read=False, write=False), bench.open(), CODES[code]
    if row.takes:
        least = row.least or row.takes
        given = bytes(least - 1)
        assert refusal(control, both, code, given, row.gives, b"1") == Win32Error.ERROR_INVALID_PARAMETER
    if row.gives:
        room = row.gives - 1 or 0
        if room or not row.optional:
            code_of = refusal(control, both, code, bytes(row.takes), room)
            assert code_of == Win32Error.ERROR_INSUFFICIENT_BUFFER
    if row.reads or row.writes:
        refused = refusal(control, query, code, bytes(row.takes), row.gives)
        assert refused == Win32Error.ERROR_ACCESS_DENIED


@pytest.mark.parametrize("code", [0, 1, c.CTL_CODE(c.CAN_DEV, 0x814, 0, 0), 0xFFFF_FFFF])
def test_unknown_codes(bench: Bench, code: int) -> None:
    assert refusal(control, bench.open(), code) == Win32Error.ERROR_NOT_SUPPORTED


def test_a_closed_handle(bench: Bench) -> None:
    handle = bench.open()
    handle.close()
    assert refusal(control, handle, ControlCode.GET_BAUDRATE, b"", 4) == Win32Error.ERROR_INVALID_HANDLE


# filters


@pytest.mark.conforms("FS-37")
def test_filters_are_the_channels_own(bench: Bench) -> None:
    first, second = bench.open(), bench.open()
    wanted = CAN_ACCEPTANCE_FILTER(0x2400_0000, 0x00E0_0000)
    control(first, ControlCode.WRITE_ACCEPTANCE_FILTER, wanted.pack())
    read = control(first, ControlCode.READ_ACCEPTANCE_FILTER, b"", 8).data
    assert CAN_ACCEPTANCE_FILTER.unpack(read) == wanted
    bench.peer.send(Frame(0x11F), Frame(0x121))
    bench.run(0.01)
    assert [event.identifier for event in events(first)] == [0x121]
    assert [event.identifier for event in events(second)] == [0x11F, 0x121]


def test_what_came_before_a_filter_was_set_stays(bench: Bench) -> None:
    handle = bench.open()
    bench.peer.send(Frame(5))
    bench.run(0.01)
    handle.filter = CAN_ACCEPTANCE_FILTER()
    bench.peer.send(Frame(6), Frame(0))
    bench.run(0.01)
    assert [event.identifier for event in events(handle)] == [5, 0]


def test_example_1_reads_through_a_reading_handle(bench: Bench, registry: RegistryStore) -> None:
    registry.set("CID1", "Align", 1)
    handle = bench.open(write=False)
    control(handle, ControlCode.WRITE_ACCEPTANCE_FILTER, CAN_ACCEPTANCE_FILTER(0x120, 0x007).pack())
    bench.peer.send(*(Frame(n) for n in range(0x118, 0x130)))
    bench.run(0.02)
    assert [event.identifier for event in events(handle)] == list(range(0x120, 0x128))


# rates, modes, formats


@pytest.mark.conforms("FS-42")
def test_baud_rate(bench: Bench) -> None:
    handle = bench.open()
    control(handle, ControlCode.SET_BAUDRATE, dword(400_000))
    assert number(handle, ControlCode.GET_BAUDRATE) == 400_000
    for wrong in (0, 1, 2_000_000, 999_999, 0xFFFF_FFFF):
        assert (
            refusal(control, handle, ControlCode.SET_BAUDRATE, dword(wrong))
            == Win32Error.ERROR_INVALID_PARAMETER
        )
    assert number(handle, ControlCode.GET_BAUDRATE) == 400_000
    assert handle.device.status().running


@pytest.mark.conforms("FS-43")
def test_baud_rate_by_constant(bench: Bench) -> None:
    handle = bench.open()
    table = CAN_PROPERTIES.unpack(control(handle, ControlCode.READ_PROPERTIES, b"", CAN_PROPERTIES.SIZE).data)
    for index, rate in enumerate(table.baudrates[: table.nBaudrates]):
        control(handle, ControlCode.SET_BAUDRATE_BY_CONSTANT, dword(index))
        assert number(handle, ControlCode.GET_BAUDRATE) == rate
        assert number(handle, ControlCode.GET_BAUDRATE_BY_CONSTANT) == index
    wrong = dword(table.nBaudrates)
    code = refusal(control, handle, ControlCode.SET_BAUDRATE_BY_CONSTANT, wrong)
    assert code == Win32Error.ERROR_INVALID_PARAMETER
    control(handle, ControlCode.SET_BAUDRATE, dword(400_000))
    assert number(handle, ControlCode.GET_BAUDRATE_BY_CONSTANT) == 0xFFFF_FFFF


@pytest.mark.conforms("FS-44", "FS-45")
def test_modes_and_formats(bench: Bench) -> None:
    handle, writer = bench.open(), bench.open(read=False)
    assert bench.peer

    def sent() -> bool:
        writer.write("12 0 0\n")
        frame = bench.peer.receive(1)
        assert frame is not None
        return bool(frame.extended)

    assert not sent()
    bench.peer.send(Frame(1, extended=True), Frame(2))
    bench.run(0.01)
    assert [event.identifier for event in events(handle)] == [2]
    control(handle, ControlCode.SET_CAN_MODE, dword(1))
    assert sent()
    control(handle, ControlCode.SET_DEFAULT_FRAME_FORMAT, dword(c.CANBUS_TRANS_FMT_STD))
    assert not sent()
    control(handle, ControlCode.SET_DEFAULT_FRAME_FORMAT, dword(c.CANBUS_TRANS_FMT_EXT))
    assert sent()
    bench.run(0.01)
    events(handle)
    bench.peer.send(Frame(1, extended=True), Frame(2))
    bench.run(0.01)
    assert [(event.identifier, event.fmt) for event in events(handle)] == [(1, 2), (2, 1)]
    control(handle, ControlCode.SET_CAN_MODE, dword(0))
    assert not sent()
    for code in (ControlCode.SET_CAN_MODE, ControlCode.SET_DEFAULT_FRAME_FORMAT):
        assert refusal(control, handle, code, dword(7)) == Win32Error.ERROR_INVALID_PARAMETER


@pytest.mark.conforms("FS-46")
def test_every_change_is_told_to_every_receive_channel(bench: Bench, mode_2b: None) -> None:
    first, second = bench.open(), bench.open(hub=bench.program("second"))
    query = bench.open(read=False, write=False)
    changes = [
        (ControlCode.SET_BAUDRATE, 500_000),
        (ControlCode.SET_BAUDRATE_BY_CONSTANT, 3),
        (ControlCode.SET_CAN_MODE, 1),
        (ControlCode.SET_DEFAULT_FRAME_FORMAT, 1),
        (ControlCode.SET_COMMAND, Command.LISTEN_ON),
        (ControlCode.SET_COMMAND, Command.LISTEN_OFF),
    ]
    for code, value in changes:
        control(query, code, dword(value))
        assert kinds(first) == kinds(second) == [CanbusEvent.DEVICE_CHANGED], code


# binary messages and events


@pytest.mark.conforms("FS-47")
def test_binary_messages_have_a_format_of_their_own(bench: Bench, mode_2b: None) -> None:
    """The manual's example of 8.19."""
    handle = bench.open()
    assert bench.peer
    first = CAN_TRANSMIT_DATA(c.CANBUS_TRANS_FMT_STD, 0x123, 0, 2, b"\x11\x22")
    second = CAN_TRANSMIT_DATA(c.CANBUS_TRANS_FMT_EXT, 0x1234_5678, 1, 0)
    third = CAN_TRANSMIT_DATA(c.CANBUS_TRANS_FMT_DEFAULT, 0x12, 0, 1, b"\x01\x02\x03")
    for message in (first, second, third):
        control(handle, ControlCode.WRITE_TRANSMIT_DATA, message.pack())
    assert bench.peer.received(3) == [
        Frame(0x123, b"\x11\x22"),
        Frame(0x1234_5678, extended=True, remote=True),
        Frame(0x12, b"\x01", extended=True),
    ]


@pytest.mark.conforms("FS-47")
@pytest.mark.parametrize("wrong", [{"fmt": 3}, {"dlc": 16}, {"rtr": 2}, {"identifier": 0x800, "fmt": 1}])
def test_impossible_binary_messages(bench: Bench, wrong: dict[str, int]) -> None:
    handle = bench.open()
    message = CAN_TRANSMIT_DATA(**wrong)  # type: ignore[arg-type]
    code = refusal(control, handle, ControlCode.WRITE_TRANSMIT_DATA, message.pack())
    assert code == Win32Error.ERROR_INVALID_PARAMETER
    bench.run(0.01)
    assert kinds(handle) == []


@pytest.mark.conforms("FS-48")
def test_binary_events(bench: Bench) -> None:
    handle = bench.open()
    bench.run(0.005)
    bench.peer.send(Frame(0x112, b"\x01\x02"))
    bench.run(0.01)
    event = CAN_EVENT.unpack(control(handle, ControlCode.READ_EVENT_DATA, b"", CAN_EVENT.SIZE).data)
    assert (event.event, event.time, event.lost) == (c.CANBUS_EVENT_RECEIVED, CAN_TIME(5, 0), 0)
    assert event.data == CAN_TRANSMIT_DATA(c.CANBUS_TRANS_FMT_STD, 0x112, 0, 2, b"\x01\x02")


@pytest.mark.conforms("FS-49")
def test_time_wraps_without_touching_the_high_word(bench: Bench) -> None:
    handle = bench.open()

    def time() -> CAN_TIME:
        return CAN_TIME.unpack(control(handle, ControlCode.READ_TIME, b"", 8).data)

    bench.run(1.5)
    assert time() == CAN_TIME(1500, 0)
    bench.run((2**32 - 1500) / 1000)
    bench.run(0.007)
    assert time() == CAN_TIME(7, 0)
    bench.peer.send(Frame(1))
    assert handle.read_event().time == 7


# properties and commands


@pytest.mark.conforms("FS-50")
def test_properties_change_with_the_mode(bench: Bench) -> None:
    handle = bench.open(read=False, write=False)
    found = []
    for mode in (0, 1):
        control(handle, ControlCode.SET_CAN_MODE, dword(mode))
        reply = control(handle, ControlCode.READ_PROPERTIES, b"", CAN_PROPERTIES.SIZE)
        found.append(CAN_PROPERTIES.unpack(reply.data))
    assert found[0] != found[1]
    assert found[0].max == 1_000_000


@pytest.mark.conforms("FS-51")
def test_unlisted_commands_are_refused(bench: Bench) -> None:
    handle = bench.open()
    for number in (0, 10, 99):
        code = refusal(control, handle, ControlCode.SET_COMMAND, dword(number))
        assert code == Win32Error.ERROR_INVALID_PARAMETER
    reader = bench.open(write=False) if bench.hub.board("inducan104").id == bench.board else None
    if reader is not None:
        code = refusal(control, reader, ControlCode.SET_COMMAND, dword(Command.ABORT_TRANSMISSION))
        assert code == Win32Error.ERROR_ACCESS_DENIED


@pytest.mark.conforms("FS-52")
def test_standby_until_something_is_sent_or_heard(bench: Bench) -> None:
    first, second = bench.open(), bench.open(hub=bench.program("second"))
    assert bench.peer
    bench.run(0.01)
    sleeps, wakes = CanbusEvent.ENTERING_STANDBY, CanbusEvent.LEAVING_STANDBY
    control(first, ControlCode.SET_COMMAND, bytes([Command.ENTER_STANDBY]))  # a BYTE, as in 8.9
    assert kinds(first) == kinds(second) == [sleeps]
    command(second, Command.LEAVE_STANDBY)
    bench.run(0.01)
    assert kinds(first) == kinds(second) == [wakes]
    command(first, Command.ENTER_STANDBY)
    first.mask = wakes
    bench.peer.send(Frame(1), Frame(2))
    assert first.wait_comm_event() == wakes
    bench.run(0.01)
    command(first, Command.ENTER_STANDBY)
    second.write("5 0 0\n")
    bench.run(0.01)
    assert kinds(first) == [wakes, wakes]
    assert bench.peer.receive(0) == Frame(5)


@pytest.mark.conforms("FS-53")
def test_listen_only_keeps_what_is_to_be_sent(bench: Bench, mode_2b: None) -> None:
    handle = bench.open()
    assert bench.peer
    control(handle, ControlCode.SET_DEFAULT_FRAME_FORMAT, dword(1))
    command(handle, Command.LISTEN_ON)
    for n in range(5):
        handle.write(f"{n:x} 0 0\n")
    bench.run(0.01)
    assert bench.peer.receive(0) is None
    events(handle)
    command(handle, Command.LISTEN_OFF)
    bench.run(0.01)
    assert [frame.id for frame in bench.peer.received(5)] == list(range(5))
    assert kinds(handle) == [CanbusEvent.DEVICE_CHANGED, *[TRANSMITTED] * 5]


@pytest.mark.conforms("FS-53")
def test_listen_only_hears(bench: Bench, mode_2b: None) -> None:
    handle, other = bench.open(), bench.program("acknowledges")
    board = other.board("HW000001").id
    import canwire

    control_ = other.open_control(board, 1)
    control_.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=8_000_000)))
    control_.start()
    command(handle, Command.LISTEN_ON)
    bench.peer.send(Frame(3))
    bench.run(0.01)
    assert kinds(handle) == [CanbusEvent.DEVICE_CHANGED, RECEIVED]


@pytest.mark.conforms("FS-56")
def test_loop_back_needs_no_partner(bench: Bench, mode_2b: None) -> None:
    handle = bench.open()
    bench.absent_peer()
    command(handle, Command.SELF_RECEPTION_REQUEST)
    handle.write("77 0 1 aa\n")
    bench.run(0.01)
    found = events(handle)
    assert {(event.event, event.identifier) for event in found if event.has_message} == {
        (RECEIVED, 0x77),
        (TRANSMITTED, 0x77),
    }
    control(handle, ControlCode.INIT, b"", 4)
    bench.peer.start()
    bench.peer.send(Frame(1))
    bench.run(0.01)
    assert RECEIVED in kinds(handle)


# registers, INIT, TEST_DEVICE


@pytest.mark.conforms("FS-58")
def test_registers(bench: Bench) -> None:
    handle = bench.open()
    sja1000 = "MOD" in bench.registers()
    ewl, writable = (13, 96) if sja1000 else (0x2A, None)  # EWLR; CNF1
    before = control(handle, ControlCode.READ_REGISTER, bytes([ewl]), 1).data
    if writable is not None:
        assert before == bytes([writable])
        control(handle, ControlCode.WRITE_REGISTER, bytes([ewl]), 1, b"\x50")
        assert (
            control(handle, ControlCode.READ_REGISTER, bytes([ewl]), 1).data == before
        )  # not in operating mode
    control(handle, ControlCode.WRITE_REGISTER_RM, bytes([ewl]), 1, b"\x01")
    assert control(handle, ControlCode.READ_REGISTER_RM, bytes([ewl]), 1).data == b"\x01"
    assert handle.device.status().running
    code = refusal(control, handle, ControlCode.READ_REGISTER, b"\xff", 1)
    assert code == Win32Error.ERROR_INVALID_PARAMETER


@pytest.mark.conforms("FS-59")
def test_init_brings_a_controller_back_from_bus_off(bench: Bench) -> None:
    handle = bench.open()
    assert bench.peer
    bench.faults.flip(bit=20, times=32)
    handle.write("1 0 0\n")
    bench.run(0.005)
    assert CanbusEvent.BUS_ERROR in kinds(handle)
    assert control(handle, ControlCode.INIT, b"", 4).data == dword(0)
    handle.write("2 0 0\n")
    bench.run(0.01)
    assert TRANSMITTED in kinds(handle)
    assert handle.device.state().rate == 1_000_000


@pytest.mark.conforms("FS-60")
def test_test_device(bench: Bench) -> None:
    handle = bench.open()
    assert control(handle, ControlCode.TEST_DEVICE).answer == 0
    board, line = handle.device.board.id, handle.device.number
    with bench.hub.open_control(board, line) as held:
        held.stop()
    assert control(handle, ControlCode.TEST_DEVICE).answer == 1
