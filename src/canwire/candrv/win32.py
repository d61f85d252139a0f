"""The functions of the manual: on failure they return 0 or INVALID_HANDLE_VALUE, and GetLastError returns the cause.

    written = [0]
    handle = CreateFile("CID1:", GENERIC_WRITE, 0, None, OPEN_EXISTING, FILE_FLAG_WRITE_THROUGH, 0)
    text = b"731 0 4 11 22 33 44\\n"
    if not WriteFile(handle, text, len(text), written, None):
        print(GetLastError())

C's arguments have these forms in Python. A HANDLE is a number. A pointer to a DWORD that the function writes (lpdwRead,
lpdwEvent, ...) is a list whose item 0 is set, a ctypes number, or None. A buffer that the function reads is a
bytes-like object or a structure of `candrv.structures`; a buffer that it writes is a writable buffer such as a
bytearray, or such a structure, which it fills in. ctypes' arrays, structures and byref are accepted for both. A
COMMTIMEOUTS is always that structure. Further constants are in `canwire.candrv.constants`.

Source: CANDRV manual, chapter 8.
"""

# ruff: noqa: N802, N803 - functions and parameters have the manual's names
from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeAlias

from canwire import CanwireError
from canwire.candrv import ioctl
from canwire.candrv.constants import (
    CREATE_NEW,
    FILE_SHARE_READ,
    FILE_SHARE_WRITE,
    GENERIC_READ,
    GENERIC_WRITE,
    INVALID_HANDLE_VALUE,
    OPEN_EXISTING,
    TRUNCATE_EXISTING,
    ControlCode,
    Win32Error,
)
from canwire.candrv.device.device import Device
from canwire.candrv.errors import CandrvError, as_candrv, translated
from canwire.candrv.handle.handle import Handle
from canwire.candrv.handle.writing import PartialWrite
from canwire.candrv.pointers import fill, room_in, set_dword, taken, timeouts_of
from canwire.candrv.program import PROGRAM
from canwire.candrv.structures import COMMTIMEOUTS, Structure

if TYPE_CHECKING:
    from canwire import Hub

P = ParamSpec("P")
Out: TypeAlias = list[int] | Any
Readable: TypeAlias = bytes | bytearray | memoryview | Structure | Any
Writable: TypeAlias = bytearray | memoryview | Structure | Any

_ACCESS = GENERIC_READ | GENERIC_WRITE
_SHARES = FILE_SHARE_READ | FILE_SHARE_WRITE


def _answering(failure: int) -> Callable[[Callable[P, int]], Callable[P, int]]:
    """Makes a function return `failure` where it would raise an error, whose code GetLastError then returns."""

    def wrap(call: Callable[P, int]) -> Callable[P, int]:
        @wraps(call)
        def answer(*args: P.args, **kwargs: P.kwargs) -> int:
            try:
                return call(*args, **kwargs)
            except CanwireError as error:
                return _failed(error, failure)

        return answer

    return wrap


def _failed(error: CanwireError, failure: int) -> int:
    PROGRAM.last_error.code = as_candrv(error).code
    return failure


def use(hub: Hub | None) -> None:
    """Open devices on this hub from now on; None: on the hub of `canwire.connect()`. Not in the manual."""
    PROGRAM.use(hub)


def GetLastError() -> int:
    """The error code of the last call of this thread that failed; a successful call does not change it."""
    return PROGRAM.last_error.code


def SetLastError(dwErrCode: int) -> None:
    PROGRAM.last_error.code = dwErrCode


@_answering(INVALID_HANDLE_VALUE)
def CreateFile(
    lpFileName: str,
    dwAccess: int,
    dwShareMode: int,
    lpSecurity: object = None,
    dwCreation: int = OPEN_EXISTING,
    dwFlags: int = 0,
    hTemplate: object = None,
) -> int:
    """Returns a handle, or INVALID_HANDLE_VALUE. lpSecurity, dwFlags and hTemplate are ignored.

    Each dwCreation opens the existing device, except CREATE_NEW, which fails with ERROR_FILE_EXISTS.
    """
    if dwCreation == CREATE_NEW:
        raise CandrvError(Win32Error.ERROR_FILE_EXISTS, f"{lpFileName} is a device")
    if dwAccess & ~_ACCESS or dwShareMode & ~_SHARES or not CREATE_NEW < dwCreation <= TRUNCATE_EXISTING:
        raise CandrvError(
            Win32Error.ERROR_INVALID_PARAMETER,
            f"access {dwAccess:#x}, share mode {dwShareMode:#x}, creation {dwCreation}",
        )
    with translated():
        device = Device(PROGRAM.hub(), lpFileName)
    read, write = bool(dwAccess & GENERIC_READ), bool(dwAccess & GENERIC_WRITE)
    return PROGRAM.add(Handle(device, read=read, write=write, share=dwShareMode))


@_answering(0)
def CloseHandle(hDevice: int) -> int:
    PROGRAM.remove(hDevice).close()
    return 1


@_answering(0)
def WriteFile(
    hDevice: int, lpBuffer: Readable, dwCount: int, lpdwWritten: Out = None, lpOverlapped: object = None
) -> int:
    """lpdwWritten gets the number of characters used, also if the call fails at a later character."""
    set_dword(lpdwWritten, 0)
    handle = PROGRAM.handle(hDevice)
    try:
        set_dword(lpdwWritten, handle.write(taken(lpBuffer, dwCount)))
    except PartialWrite as error:
        set_dword(lpdwWritten, error.written)
        raise
    return 1


def ReadFile(  # without _answering: a wrapper's call would be a tenth of what an event costs
    hDevice: int,
    lpBuffer: Writable,
    dwCount: int,
    lpdwRead: Out = None,
    lpOverlapped: object = None,
) -> int:
    """Reads the next event as text. If the buffer is too small, it fails with ERROR_INSUFFICIENT_BUFFER and the event
    stays in the queue."""
    try:
        set_dword(lpdwRead, 0)
        text = PROGRAM.handle(hDevice).read_text(room_in(lpBuffer, dwCount))
        fill(lpBuffer, text)
        set_dword(lpdwRead, len(text))
    except CanwireError as error:
        return _failed(error, 0)
    return 1


@_answering(0)
def DeviceIoControl(
    hDevice: int,
    dwIoControlCode: int,
    lpInBuffer: Readable = None,
    nInBufferSize: int = 0,
    lpOutBuffer: Writable = None,
    nOutBufferSize: int = 0,
    lpReturned: Out = None,
    lpOverlapped: object = None,
) -> int:
    """Returns a number other than 0 on success; IOCTL_CAN_TEST_DEVICE returns its result. Two codes read the out
    buffer."""
    set_dword(lpReturned, 0)
    handle = PROGRAM.handle(hDevice)
    given = taken(lpInBuffer, nInBufferSize) if nInBufferSize else b""
    second = taken(lpOutBuffer, nOutBufferSize) if dwIoControlCode in ioctl.READ_BOTH else b""
    room = 0
    if nOutBufferSize:
        room = room_in(lpOutBuffer, nOutBufferSize, written=dwIoControlCode not in ioctl.READ_BOTH)
    try:
        data, answer = ioctl.control(handle, dwIoControlCode, given, room, second)
    except CandrvError as error:
        if dwIoControlCode == ControlCode.INIT and room >= 4:
            fill(lpOutBuffer, ioctl.init_status(error))
        raise
    if data:
        fill(lpOutBuffer, data)
        set_dword(lpReturned, len(data))
    return answer


@_answering(0)
def SetCommTimeouts(hDevice: int, lpTimeouts: COMMTIMEOUTS) -> int:
    PROGRAM.handle(hDevice).timeouts = timeouts_of(lpTimeouts)
    return 1


@_answering(0)
def GetCommTimeouts(hDevice: int, lpTimeouts: COMMTIMEOUTS) -> int:
    fill(timeouts_of(lpTimeouts), PROGRAM.handle(hDevice).timeouts.pack())
    return 1


@_answering(0)
def SetCommMask(hDevice: int, dwEventMask: int) -> int:
    PROGRAM.handle(hDevice).mask = dwEventMask
    return 1


@_answering(0)
def GetCommMask(hDevice: int, lpdwEventMask: Out) -> int:
    set_dword(lpdwEventMask, PROGRAM.handle(hDevice).mask)
    return 1


@_answering(0)
def WaitCommEvent(hDevice: int, lpdwEvent: Out, lpOverlapped: object = None) -> int:
    """lpdwEvent gets the type of the next event, which stays in the queue; 0 if the wait was aborted."""
    set_dword(lpdwEvent, 0)
    set_dword(lpdwEvent, PROGRAM.handle(hDevice).wait_comm_event())
    return 1
