"""The manual's functions: its own programs, arguments, answers and error codes."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

import canwire
from canwire import Frame
from canwire.candrv import win32
from canwire.candrv.constants import (
    CANBUS_CMD_CLEAR_OVERRUN,
    CANBUS_EVENT_DEVICE_CHANGED,
    CANBUS_EVENT_RECEIVED,
    CANBUS_EVENT_TRANSMITTED,
    ERROR_ACCESS_DENIED,
    ERROR_FILE_NOT_FOUND,
    ERROR_INSUFFICIENT_BUFFER,
    ERROR_INVALID_HANDLE,
    ERROR_INVALID_PARAMETER,
    ERROR_OPERATION_ABORTED,
    ERROR_SHARING_VIOLATION,
    ERROR_TIMEOUT,
    FILE_FLAG_WRITE_THROUGH,
    GENERIC_READ,
    GENERIC_WRITE,
    INFINITE,
    INVALID_HANDLE_VALUE,
    IOCTL_CAN_GET_BAUDRATE,
    IOCTL_CAN_INIT,
    IOCTL_CAN_READ_ACCEPTANCE_FILTER,
    IOCTL_CAN_READ_EVENT_DATA,
    IOCTL_CAN_READ_REGISTER,
    IOCTL_CAN_SET_BAUDRATE,
    IOCTL_CAN_SET_COMMAND,
    IOCTL_CAN_TEST_DEVICE,
    IOCTL_CAN_WRITE_ACCEPTANCE_FILTER,
    IOCTL_CAN_WRITE_REGISTER_RM,
    IOCTL_CAN_WRITE_TRANSMIT_DATA,
    OPEN_EXISTING,
)
from canwire.candrv.program import PROGRAM
from canwire.candrv.structures import CAN_ACCEPTANCE_FILTER, CAN_EVENT, CAN_TRANSMIT_DATA, COMMTIMEOUTS
from canwire.candrv.win32 import (
    CloseHandle,
    CreateFile,
    DeviceIoControl,
    GetCommMask,
    GetCommTimeouts,
    GetLastError,
    ReadFile,
    SetCommMask,
    SetCommTimeouts,
    SetLastError,
    WaitCommEvent,
    WriteFile,
)
from tests.candrv.bench import Peer

EVERYTHING = CAN_ACCEPTANCE_FILTER(0, 0xFFFF_FFFF)


@pytest.fixture(autouse=True)
def program(hub: canwire.Hub) -> Iterator[None]:
    """This program's hub is the test's."""
    win32.use(hub)
    SetLastError(0)
    yield
    for number in list(PROGRAM._handles):
        CloseHandle(number)
    win32.use(None)


def opened(access: int = GENERIC_READ | GENERIC_WRITE, share: int = 3) -> int:
    handle = CreateFile("CID1:", access, share, None, OPEN_EXISTING, FILE_FLAG_WRITE_THROUGH, 0)
    assert handle != INVALID_HANDLE_VALUE, GetLastError()
    if access & GENERIC_READ:
        assert DeviceIoControl(handle, IOCTL_CAN_WRITE_ACCEPTANCE_FILTER, EVERYTHING, EVERYTHING.SIZE)
    return handle


@pytest.mark.smoke
@pytest.mark.conforms("FS-15", "FS-23", "FS-26")
def test_can_write_and_can_read(peer: Peer) -> None:
    """CanWrite sets the rate through a handle of its own, CanRead prints what comes."""
    query = CreateFile("CID1:", 0, 0, None, OPEN_EXISTING, 0, None)
    rate = bytearray((1_000_000).to_bytes(4, "little"))
    assert DeviceIoControl(query, IOCTL_CAN_SET_BAUDRATE, rate, len(rate), None, 0, None, None)
    returned = [0]
    assert DeviceIoControl(query, IOCTL_CAN_GET_BAUDRATE, None, 0, rate, len(rate), returned, None)
    assert returned == [4]
    assert bytes(rate) == (1_000_000).to_bytes(4, "little")
    assert CloseHandle(query)
    handle, text, written = opened(), b"731 0 4 11 22 33 44\n", [0]
    assert WriteFile(handle, text, len(text), written, None)
    assert written == [20]
    assert peer.receive() == Frame(0x731, b"\x11\x22\x33\x44")
    peer.send(Frame(0x112, remote=True))
    buffer, read, lines = bytearray(100), [0], []
    for _ in range(2):
        assert ReadFile(handle, buffer, len(buffer), read, None)
        lines.append(bytes(buffer[: read[0]]).split())
    assert [line[0] for line in lines] == [b"transmitted", b"received"]
    assert lines[0][2:] == [b"00000731", b"0", b"4", b"11", b"22", b"33", b"44"]
    assert lines[1][2:] == [b"00000112", b"1", b"0", b"0"]


@pytest.mark.conforms("FS-47", "FS-48")
def test_binary_forms_go_in_and_out_as_structures(peer: Peer) -> None:
    handle = opened()
    message = CAN_TRANSMIT_DATA(0, 0x123, 0, 2, b"\x11\x22")
    assert DeviceIoControl(handle, IOCTL_CAN_WRITE_TRANSMIT_DATA, message, message.SIZE, None, 0, None, None)
    assert peer.receive() == Frame(0x123, b"\x11\x22")
    event, returned = CAN_EVENT(), [0]
    assert DeviceIoControl(handle, IOCTL_CAN_READ_EVENT_DATA, None, 0, event, event.SIZE, returned)
    assert (event.event, event.data.identifier, returned) == (
        CANBUS_EVENT_TRANSMITTED,
        0x123,
        [CAN_EVENT.SIZE],
    )
    if event.event == CANBUS_EVENT_RECEIVED:
        assert DeviceIoControl(handle, IOCTL_CAN_SET_COMMAND, bytes([CANBUS_CMD_CLEAR_OVERRUN]), 1)


@pytest.mark.conforms("FS-25")
def test_malformed_text_says_how_much_was_used(peer: Peer) -> None:
    handle, written = opened(GENERIC_WRITE), [0]
    text = b"1 0 0\nxyz 9\n"
    assert not WriteFile(handle, text, len(text), written, None)
    assert GetLastError() == ERROR_INVALID_PARAMETER
    assert written[0] >= 6
    assert peer.receive() == Frame(1)


@pytest.mark.conforms("FS-28")
def test_a_small_buffer(peer: Peer) -> None:
    handle, read = opened(GENERIC_READ), [7]
    peer.send(Frame(1))
    assert not ReadFile(handle, bytearray(5), 5, read)
    assert (GetLastError(), read) == (ERROR_INSUFFICIENT_BUFFER, [0])
    assert ReadFile(handle, bytearray(100), 100, read)
    assert read[0] > 20


@pytest.mark.conforms("FS-29", "FS-31")
def test_timeouts() -> None:
    handle, chosen = opened(), COMMTIMEOUTS()
    assert GetCommTimeouts(handle, chosen)
    assert chosen.ReadTotalTimeoutConstant == chosen.WriteTotalTimeoutConstant == INFINITE
    chosen.ReadTotalTimeoutConstant, chosen.ReadIntervalTimeout = 0, 77
    assert SetCommTimeouts(handle, chosen)
    assert GetCommTimeouts(handle, chosen)
    assert chosen.ReadIntervalTimeout == 77
    assert not ReadFile(handle, bytearray(100), 100, [0])
    assert GetLastError() == ERROR_TIMEOUT
    event = CAN_EVENT()
    assert not DeviceIoControl(handle, IOCTL_CAN_READ_EVENT_DATA, None, 0, event, event.SIZE)
    assert GetLastError() == ERROR_TIMEOUT


@pytest.mark.conforms("FS-32", "FS-36")
def test_masks_and_waiting(peer: Peer) -> None:
    handle, mask, event = opened(), [0], [0]
    assert GetCommMask(handle, mask)
    assert mask == [0x7FF]
    assert SetCommMask(handle, mask[0] & ~CANBUS_EVENT_DEVICE_CHANGED)
    assert GetCommMask(handle, mask)
    assert mask == [0x5FF]
    peer.send(Frame(1))
    assert WaitCommEvent(handle, event, None)
    assert event == [CANBUS_EVENT_RECEIVED]
    assert not SetCommMask(handle, -1)
    assert GetLastError() == ERROR_INVALID_PARAMETER


@pytest.mark.conforms("FS-36", "FS-21")
def test_wait_comm_event_gives_0_when_aborted() -> None:
    handle, event, answers = opened(), [5], []

    def wait() -> None:
        answers.extend([WaitCommEvent(handle, event, None), GetLastError()])

    thread = threading.Thread(target=wait)
    thread.start()
    while not PROGRAM.handle(handle)._channel.room._waiting:
        pass
    assert CloseHandle(handle)
    thread.join(30)
    assert (answers, event) == ([0, ERROR_OPERATION_ABORTED], [0])
    assert GetLastError() == 0  # this thread's own


def test_registers_go_through_both_buffers() -> None:
    handle, value = opened(0), bytearray(1)
    assert DeviceIoControl(handle, IOCTL_CAN_WRITE_REGISTER_RM, bytes([13]), 1, b"\x50", 1)
    assert DeviceIoControl(handle, IOCTL_CAN_READ_REGISTER, bytes([13]), 1, value, 1, returned := [0])
    assert bytes(value) == b"\x50"
    assert returned == [1]


@pytest.mark.conforms("FS-59", "FS-60")
def test_init_and_test_device() -> None:
    handle, status = opened(0), bytearray(b"\xff" * 4)
    assert DeviceIoControl(handle, IOCTL_CAN_INIT, None, 0, status, 4)
    assert status == bytes(4)
    SetLastError(0)
    assert DeviceIoControl(handle, IOCTL_CAN_TEST_DEVICE) == 0
    assert GetLastError() == 0


def test_init_that_fails_leaves_its_code_in_the_buffer(hub: canwire.Hub) -> None:
    handle, status = opened(0), bytearray(4)
    with hub.open_control(hub.board("HW000104").id, 0):
        assert not DeviceIoControl(handle, IOCTL_CAN_INIT, None, 0, status, 4)
    assert int.from_bytes(status, "little") == GetLastError() == ERROR_SHARING_VIOLATION


def test_refusals() -> None:
    def failed(answer: int, failure: int = 0) -> int:
        assert answer == failure
        code = GetLastError()
        SetLastError(0)
        return code

    assert failed(CreateFile("CID9:", GENERIC_READ, 0), INVALID_HANDLE_VALUE) == ERROR_FILE_NOT_FOUND
    for arguments in ((1, 0), (GENERIC_READ, 4), (GENERIC_READ, 0, None, 6)):
        assert failed(CreateFile("CID1:", *arguments), INVALID_HANDLE_VALUE) == ERROR_INVALID_PARAMETER
    handle = opened(GENERIC_READ, 0)
    assert failed(CreateFile("CID1:", GENERIC_READ, 3), INVALID_HANDLE_VALUE) == ERROR_SHARING_VIOLATION
    assert failed(WriteFile(handle, b"1 0 0\n", 6)) == ERROR_ACCESS_DENIED
    assert failed(WriteFile(handle, b"1 0 0\n", 7)) == ERROR_INVALID_PARAMETER
    assert failed(ReadFile(handle, bytearray(3), 4)) == ERROR_INVALID_PARAMETER
    small = bytearray(4)
    code = failed(DeviceIoControl(handle, IOCTL_CAN_READ_ACCEPTANCE_FILTER, None, 0, small, 4))
    assert code == ERROR_INSUFFICIENT_BUFFER
    assert failed(GetCommTimeouts(handle, None)) == ERROR_INVALID_PARAMETER  # type: ignore[arg-type]
    assert CloseHandle(handle)
    calls = [CloseHandle(handle), ReadFile(handle, bytearray(9), 9), GetCommMask(handle, [0])]
    assert calls == [0, 0, 0]
    assert GetLastError() == ERROR_INVALID_HANDLE
