"""What stands for C's pointers in candrv.win32: what ctypes has will do, what is no pointer is refused in words."""

from __future__ import annotations

import ctypes
from array import array
from collections.abc import Iterator
from typing import Any

import pytest

from canwire.candrv import constants as c
from canwire.candrv import win32
from canwire.candrv.structures import CAN_TRANSMIT_DATA
from canwire.candrv.win32 import CloseHandle, CreateFile, DeviceIoControl, GetLastError, ReadFile, WriteFile
from tests.candrv.bench import Bench

pytestmark = pytest.mark.finding("candrv B10")


class CTransmitData(ctypes.LittleEndianStructure):
    """The manual's structure, as a ctypes program declares it."""

    _fields_ = (
        ("fmt", ctypes.c_uint32),
        ("identifier", ctypes.c_uint32),
        ("rtr", ctypes.c_uint8),
        ("dlc", ctypes.c_uint8),
        ("msg", ctypes.c_uint8 * 8),
    )


class CEvent(ctypes.LittleEndianStructure):
    _fields_ = (
        ("event", ctypes.c_uint32),
        ("time", ctypes.c_uint32 * 2),
        ("lost", ctypes.c_uint32),
        ("data", CTransmitData),
        ("arbitration", ctypes.c_uint32),
    )


@pytest.fixture
def can(bench: Bench) -> Iterator[int]:
    """A handle in win32's way; whoever acknowledges is there."""
    assert bench.peer
    win32.use(bench.hub)
    handle = CreateFile("CID1:", c.GENERIC_READ | c.GENERIC_WRITE, 0, None, c.OPEN_EXISTING)
    assert handle != c.INVALID_HANDLE_VALUE
    yield handle
    CloseHandle(handle)
    win32.use(None)


def test_bytes_of_a_message_one_by_one(can: int, bench: Bench) -> None:
    """As 8.19 has it."""
    message = CAN_TRANSMIT_DATA()
    message.identifier, message.dlc = 0x123, 2
    message.msg[0] = 0x11  # type: ignore[index]
    message.msg[1] = 0x22  # type: ignore[index]
    assert CAN_TRANSMIT_DATA().msg == bytes(8)
    assert DeviceIoControl(can, c.IOCTL_CAN_WRITE_TRANSMIT_DATA, message, message.SIZE)
    frame = bench.peer.receive(1)
    assert frame is not None
    assert (frame.id, frame.data) == (0x123, b"\x11\x22")


def test_structures_of_ctypes_in_and_out(can: int) -> None:
    message = CTransmitData(identifier=0x124, dlc=1)
    message.msg[0] = 0x33
    given = ctypes.byref(message)
    assert DeviceIoControl(can, c.IOCTL_CAN_WRITE_TRANSMIT_DATA, given, ctypes.sizeof(message))
    event, count = CEvent(), ctypes.c_uint32()
    for out in (event, ctypes.byref(event), ctypes.pointer(event)):
        event.event = 0
        assert DeviceIoControl(can, c.IOCTL_CAN_READ_EVENT_DATA, None, 0, out, 40, ctypes.byref(count)) == 1
        assert (event.event, event.data.identifier, event.data.msg[0]) == (2, 0x124, 0x33)
        assert count.value == 40
        DeviceIoControl(can, c.IOCTL_CAN_WRITE_TRANSMIT_DATA, given, ctypes.sizeof(message))


@pytest.mark.parametrize(
    "buffer",
    [
        ctypes.create_string_buffer(100),
        (ctypes.c_uint8 * 100)(),
        array("B", bytes(100)),
        array("I", [0] * 25),
    ],
    ids=["c_char", "c_uint8", "bytes", "words"],
)
def test_any_buffer_takes_the_text(can: int, buffer: Any) -> None:
    assert WriteFile(can, b"123 0 0\n", 8)
    count = [0]
    assert ReadFile(can, buffer, 100, count)
    assert bytes(buffer).startswith(b"transmitted\t0:")
    assert count[0] > 30


@pytest.mark.parametrize(
    "wrong",
    [bytes(100), "text", 100, memoryview(bytes(100)), [0] * 100],
    ids=["bytes", "text", "number", "view", "list"],
)
def test_an_event_is_not_lost_for_a_buffer_that_cannot_be_written(can: int, wrong: Any) -> None:
    assert WriteFile(can, b"123 0 0\n", 8)
    assert not ReadFile(can, wrong, 100, [0])
    assert GetLastError() == c.ERROR_INVALID_PARAMETER
    buffer = bytearray(100)
    assert ReadFile(can, buffer, 100, [0])
    assert b"00000123" in buffer


@pytest.mark.parametrize(
    "call",
    [
        lambda can: DeviceIoControl(can, c.IOCTL_CAN_SET_BAUDRATE, 500_000, 4),
        lambda can: WriteFile(can, 20, 20),
        lambda can: WriteFile(can, "123 0 0\n", 8),
        lambda can: DeviceIoControl(can, c.IOCTL_CAN_WRITE_TRANSMIT_DATA, 20, 20),
        lambda can: DeviceIoControl(can, c.IOCTL_CAN_WRITE_ACCEPTANCE_FILTER, 8, 8),
        lambda can: DeviceIoControl(can, c.IOCTL_CAN_GET_BAUDRATE, None, 0, bytearray(4), 4, 5),
    ],
)
def test_a_number_is_no_pointer(can: int, bench: Bench, call: Any) -> None:
    """A forgotten & does nothing, and says so."""
    assert not call(can)
    assert GetLastError() == c.ERROR_INVALID_PARAMETER
    bench.run(0.01)
    assert bench.peer.receive(0) is None


@pytest.mark.finding("candrv B14")
@pytest.mark.parametrize(
    ("creation", "code"),
    [
        (c.CREATE_NEW, c.ERROR_FILE_EXISTS),
        (c.CREATE_ALWAYS, 0),
        (c.OPEN_EXISTING, 0),
        (c.OPEN_ALWAYS, 0),
        (c.TRUNCATE_EXISTING, 0),
        (0, c.ERROR_INVALID_PARAMETER),
        (6, c.ERROR_INVALID_PARAMETER),
    ],
)
def test_creation(can: int, creation: int, code: int) -> None:
    """`_wfopen(device, "w+t")` of CanWrite asks for c.CREATE_ALWAYS: a device is there already."""
    win32.SetLastError(0)
    handle = CreateFile("CID1:", 0, 3, None, creation)
    assert (handle == c.INVALID_HANDLE_VALUE) == bool(code)
    assert GetLastError() == code
    CloseHandle(handle)
