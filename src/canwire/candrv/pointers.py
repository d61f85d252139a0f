"""The objects that candrv.win32 accepts in place of C's pointers: bytes, buffers, structures, ctypes objects.

Any other object is refused with ERROR_INVALID_PARAMETER before the call reads, sends or removes anything: above all a
number, which means that a C program would have forgotten an `&`.
"""

from __future__ import annotations

import ctypes
from typing import Any

from canwire.candrv.constants import Win32Error
from canwire.candrv.errors import CandrvError
from canwire.candrv.structures import COMMTIMEOUTS, Structure


def set_dword(out: Any, value: int) -> None:
    """*out = value, if `out` is not None."""
    if type(out) is list and out:  # the most frequent kind, four times for each event that is read
        out[0] = value
        return
    target = _pointed_at(out)
    if target is None:
        return
    if isinstance(target, ctypes._SimpleCData):
        target.value = value
    elif isinstance(target, list) and target:
        target[0] = value
    else:
        raise _misfit(out, "a list of one number, a ctypes number or None")


def taken(buffer: Any, count: int) -> bytes:
    """The first `count` bytes of a buffer."""
    target = _pointed_at(buffer)
    held = b"" if target is None else target.pack() if isinstance(target, Structure) else bytes(_view(target))
    return held[: _checked(count, len(held))]


def room_in(buffer: Any, count: int, *, written: bool = True) -> int:
    """`count`, if the buffer has that many bytes and, if it is `written`, is writable; raises CandrvError otherwise."""
    if type(buffer) is bytearray and 0 <= count <= len(buffer):
        return count
    target = _pointed_at(buffer)
    if target is None:
        return _checked(count, 0)
    if isinstance(target, Structure):
        return _checked(count, target.SIZE)
    view = _view(target)
    if written and view.readonly:
        raise _misfit(target, "a writable buffer such as a bytearray")
    return _checked(count, view.nbytes)


def fill(buffer: Any, data: bytes) -> None:
    """Write bytes at the start of a buffer, which `room_in` has checked."""
    if type(buffer) is bytearray:
        buffer[: len(data)] = data
        return
    target = _pointed_at(buffer)
    if isinstance(target, Structure):
        filled = type(target).unpack(data)
        for name in type(target).OFFSETS:
            setattr(target, name, getattr(filled, name))
    elif target is not None:
        memory = (ctypes.c_char * len(data)).from_buffer(target)
        memory.raw = data


def timeouts_of(timeouts: Any) -> COMMTIMEOUTS:
    """The argument, which must be a COMMTIMEOUTS."""
    if not isinstance(timeouts, COMMTIMEOUTS):
        raise _misfit(timeouts, "a COMMTIMEOUTS")
    return timeouts


def _pointed_at(pointer: Any) -> Any:
    """The object that ctypes.byref() or ctypes.pointer() points to; any other object itself."""
    if isinstance(pointer, ctypes._Pointer):
        return pointer.contents if pointer else None
    return getattr(pointer, "_obj", pointer)


def _view(buffer: Any) -> memoryview:
    try:
        return memoryview(buffer)
    except TypeError:
        raise _misfit(buffer, "bytes, a buffer, a structure or None") from None


def _checked(count: int, held: int) -> int:
    if not 0 <= count <= held:
        raise CandrvError(Win32Error.ERROR_INVALID_PARAMETER, f"{count} bytes of a buffer of {held} bytes")
    return count


def _misfit(given: Any, wanted: str) -> CandrvError:
    return CandrvError(
        Win32Error.ERROR_INVALID_PARAMETER, f"{given!r:.40} in place of a pointer: pass {wanted}"
    )
