"""Reads the bytes of a sending channel from the program's memory when they are needed.

Linux permits this because the program allows it by prctl's PR_SET_PTRACER (../acanapi/register.c).
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable


class _Piece(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


@functools.cache
def _process_vm_readv() -> Callable[..., int]:
    function = ctypes.CDLL(None, use_errno=True).process_vm_readv
    function.restype = ctypes.c_ssize_t
    piece, count = ctypes.POINTER(_Piece), ctypes.c_ulong
    function.argtypes = (ctypes.c_int, piece, count, piece, count, count)
    return function


def read_memory(process: int, address: int, length: int) -> bytes:
    """Return `length` bytes from this address; empty if the memory is gone or may not be read."""
    into = ctypes.create_string_buffer(max(length, 1))
    here = _Piece(ctypes.addressof(into), length)
    there = _Piece(address, length)
    got = _process_vm_readv()(process, ctypes.byref(here), 1, ctypes.byref(there), 1, 0)
    return into.raw[:got] if got == length else b""
