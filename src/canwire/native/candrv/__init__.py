"""CANDRV for programs in C: answers libcandrv's calls by canwire.candrv.win32, which defines rules and error codes.

A result is the value for GetLastError, 0 for success; the number of an object is that of its handle.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from canwire.candrv import CAN_PROPERTIES, COMMTIMEOUTS, win32
from canwire.candrv.constants import IOCTL_CAN_READ_PROPERTIES
from canwire.native.candrv.properties import as_in_c, is_of_c
from canwire.native.helper.answers import Reply
from canwire.native.helper.rings import States

_OPEN = struct.Struct("<3I")  # access, share mode, creation; the name follows
_BUFFER = struct.Struct("<2I")  # its size, and whether there is one
_CONTROL = struct.Struct("<5I")  # the code, and the in and the out buffer as above; both buffers follow
_DWORD = struct.Struct("<I")
_LONGEST_TEXT = 1024  # an event's is shorter
_NONE = 0xFFFF_FFFF


class CandrvAnswers:
    """canwire.candrv for one program (helper.answers.Answers)."""

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        win32.SetLastError(0)
        return _METHODS[method](number, data)


def _create_file(number: int, data: bytes) -> Reply:
    access, share, creation = _OPEN.unpack_from(data)
    name = data[_OPEN.size :].decode("utf-8", "replace")
    return _reply(value=win32.CreateFile(name, access, share, None, creation))


def _close(number: int, data: bytes) -> Reply:
    win32.CloseHandle(number)
    return _reply()


def _read_file(number: int, data: bytes) -> Reply:
    count, given = _BUFFER.unpack_from(data)
    room, read = min(count, _LONGEST_TEXT), [0]
    buffer = bytearray(room) if given else None
    win32.ReadFile(number, buffer, room, read)
    return _reply(data=bytes(buffer[: read[0]]) if buffer else b"")


def _write_file(number: int, data: bytes) -> Reply:
    count, given = _BUFFER.unpack_from(data)
    written = [0]
    win32.WriteFile(number, data[_BUFFER.size :] if given else None, count, written)
    return _reply(value=written[0])


def _device_io_control(number: int, data: bytes) -> Reply:
    """DeviceIoControl: reply with the number of returned bytes, and the whole out buffer."""
    code, in_size, in_given, out_size, out_given = _CONTROL.unpack_from(data)
    buffers = data[_CONTROL.size :]
    first = min(in_size, len(buffers)) if in_given else 0
    out = bytearray(buffers[first:]) if out_given else None
    shown = len(out) if out is not None else 0
    if code == IOCTL_CAN_READ_PROPERTIES and is_of_c(shown):
        out = bytearray(CAN_PROPERTIES.SIZE)
    returned = [0]
    answer = win32.DeviceIoControl(
        number,
        code,
        buffers[:first] if in_given else None,
        first if in_given else in_size,
        out,
        out_size if out is None else len(out),
        returned,
    )
    if out is not None and len(out) != shown:
        out[:] = as_in_c(bytes(out), shown) if returned[0] else buffers[first:]
        returned[0] = returned[0] and shown
    return _reply(value=answer, data=_DWORD.pack(returned[0]) + (out or b""))


def _set_comm_timeouts(number: int, data: bytes) -> Reply:
    win32.SetCommTimeouts(number, COMMTIMEOUTS.unpack(data) if data else None)  # type: ignore[arg-type]
    return _reply()


def _get_comm_timeouts(number: int, data: bytes) -> Reply:
    timeouts = COMMTIMEOUTS() if any(data) else None
    win32.GetCommTimeouts(number, timeouts)  # type: ignore[arg-type]
    return _reply(data=timeouts.pack() if timeouts is not None else b"")


def _set_comm_mask(number: int, data: bytes) -> Reply:
    win32.SetCommMask(number, _DWORD.unpack(data)[0])
    return _reply()


def _get_comm_mask(number: int, data: bytes) -> Reply:
    mask = [0]
    win32.GetCommMask(number, mask)
    return _reply(value=mask[0])


def _wait_comm_event(number: int, data: bytes) -> Reply:
    event = [0]
    win32.WaitCommEvent(number, event)
    return _reply(value=event[0])


def _reply(value: int = 0, data: bytes = b"") -> Reply:
    """Return a reply with GetLastError's value, which is 0 before each call and after a successful one."""
    return Reply(win32.GetLastError(), value & _NONE, data)


_METHODS: dict[str, Callable[[int, bytes], Reply]] = {
    "create_file": _create_file,
    "close": _close,
    "read_file": _read_file,
    "write_file": _write_file,
    "device_io_control": _device_io_control,
    "set_comm_timeouts": _set_comm_timeouts,
    "get_comm_timeouts": _get_comm_timeouts,
    "set_comm_mask": _set_comm_mask,
    "get_comm_mask": _get_comm_mask,
    "wait_comm_event": _wait_comm_event,
}


def interface(states: States) -> CandrvAnswers:
    """Return the answers for the helper; CANDRV's programs use no rings."""
    return CandrvAnswers()
