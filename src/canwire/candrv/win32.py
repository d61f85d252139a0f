"""The manual's functions under their own names: they answer 0 or INVALID_HANDLE_VALUE, and GetLastError says why.

    written = [0]
    handle = CreateFile("CID1:", GENERIC_WRITE, 0, None, OPEN_EXISTING, FILE_FLAG_WRITE_THROUGH, 0)
    text = b"731 0 4 11 22 33 44\\n"
    if not WriteFile(handle, text, len(text), written, None):
        print(GetLastError())

How C's arguments look here: a HANDLE is a number. A pointer to a DWORD that is written (lpdwRead, lpdwEvent, ...) is a
list whose item 0 is set, a ctypes number, or None. A buffer that is read is bytes or anything like it, or a structure
of `candrv.structures`; a buffer that is written is a bytearray or another writable buffer, or such a structure, which
is filled in; what ctypes has (arrays, structures, byref) will do for both. COMMTIMEOUTS is a structure, also where
GetCommTimeouts fills it in. Further constants: `canwire.candrv.constants`.

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
    """An error is this answer, and GetLastError's."""

    def wrap(call: Callable[P, int]) -> Callable[P, int]:
        @wraps(call)
        def answer(*args: P.args, **kwargs: P.kwargs) -> int:
            try:
                return call(*args, **kwargs)
            except CanwireError as error:
                PROGRAM.last_error.code = as_candrv(error).code
                return failure

        return answer

    return wrap


def use(hub: Hub | None) -> None:
    """Ours: open devices on this hub from now on; None: on that of `canwire.connect()`."""
    PROGRAM.use(hub)


def GetLastError() -> int:
    """Why the last call of this thread failed; a call that succeeds leaves it as it is."""
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
    """A handle, or INVALID_HANDLE_VALUE. lpSecurity, dwFlags and hTemplate mean nothing.

    Every dwCreation opens the device, which is always there already; so CREATE_NEW fails with ERROR_FILE_EXISTS.
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
    """lpdwWritten gets how much was used, also of a text that is wrong further on."""
    set_dword(lpdwWritten, 0)
    handle = PROGRAM.handle(hDevice)
    try:
        set_dword(lpdwWritten, handle.write(taken(lpBuffer, dwCount)))
    except PartialWrite as error:
        set_dword(lpdwWritten, error.written)
        raise
    return 1


@_answering(0)
def ReadFile(
    hDevice: int,
    lpBuffer: Writable,
    dwCount: int,
    lpdwRead: Out = None,
    lpOverlapped: object = None,
) -> int:
    """The next event as text. One that does not fit stays, and the call fails with ERROR_INSUFFICIENT_BUFFER."""
    set_dword(lpdwRead, 0)
    handle = PROGRAM.handle(hDevice)
    text = handle.read_text(room_in(lpBuffer, dwCount))
    fill(lpBuffer, text)
    set_dword(lpdwRead, len(text))
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
    """Not 0 for success; of IOCTL_CAN_TEST_DEVICE its own answer. Two codes read the out buffer."""
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
    """lpdwEvent gets the type of the next event, which stays; 0 if the waiting was aborted."""
    set_dword(lpdwEvent, 0)
    set_dword(lpdwEvent, PROGRAM.handle(hDevice).wait_comm_event())
    return 1
