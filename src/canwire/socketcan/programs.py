"""Finds programs that cannot use a preloaded library: the server answers their calls, or reports the reason.

Source: the ELF format (elf(5)), ld.so(8) on secure execution, what Go's linker writes.
"""

from __future__ import annotations

import os
import platform
import stat
import struct
from typing import BinaryIO

_HEADER = struct.Struct("<4sBB10xHHIQQQIHHHHHH")
_PROGRAM = struct.Struct("<IIQQQQQQ")
_INTERPRETER = 3  # PT_INTERP
_CLASS_64, _LITTLE = 2, 1
_MACHINES = {"x86_64": 62, "aarch64": 183, "riscv64": 243}
_SECTION = struct.Struct("<I4xQQQQ24x")
_GO = b".go.buildinfo"
_LOOKED_AT = 1 << 16
STATIC = "is linked statically: nothing can be preloaded there"
GO = "is a Go program: it makes its system calls itself"
MUSL = "is linked with musl: canwire's shim is for glibc"


def calls_itself(path: str) -> bool:
    """True if this program cannot use the shim (static, musl or Go) and supervised/ answers its calls."""
    return trouble_with(path) in (STATIC, GO, MUSL) and platform.machine() in ("x86_64", "aarch64")


def is_for_musl(path: str) -> bool:
    """True if its loader fails when it is to preload a library for glibc."""
    return trouble_with(path) == MUSL


def trouble_with(path: str) -> str:
    """Why the shim does not work in this program, one clause; "" if it does. For a script: its interpreter."""
    try:
        with open(path, "rb") as file:
            start = file.read(_LOOKED_AT)
            mode = os.fstat(file.fileno()).st_mode
            sections = _sections(file, start)
    except (OSError, ValueError):
        return ""  # exec says what is wrong; ValueError: a name that no file can have
    if start[:2] == b"#!":
        words = start[2:].split(b"\n", 1)[0].split()
        return trouble_with(os.fsdecode(words[0])) if words else ""
    if start[:4] != b"\x7fELF" or len(start) < _HEADER.size:
        return ""
    if mode & (stat.S_ISUID | stat.S_ISGID) and os.geteuid() != 0:
        return "is set-uid or set-gid: the loader preloads nothing there"
    return _trouble_with_elf(start, sections)


def _sections(file: BinaryIO, start: bytes) -> bytes:
    """Their names, one after the other."""
    if start[:4] != b"\x7fELF" or len(start) < _HEADER.size:
        return b""
    *_, at, _, _, _, _, size, count, names = _HEADER.unpack_from(start)
    if size != _SECTION.size or names >= count:
        return b""
    file.seek(at + names * size)
    header = file.read(size)
    if len(header) < size:
        return b""
    _, _, _, offset, length = _SECTION.unpack(header)
    file.seek(offset)
    return file.read(min(length, _LOOKED_AT))


def _trouble_with_elf(start: bytes, sections: bytes) -> str:
    _, word, order, _, machine, _, _, at, _, _, _, size, count, *_ = _HEADER.unpack_from(start)
    ours = _MACHINES.get(platform.machine())
    if word != _CLASS_64 or order != _LITTLE or (ours is not None and machine != ours):
        return "is for another machine than canwire's shim"
    interpreter = b""
    for number in range(count):
        place = at + number * size
        if place + _PROGRAM.size > len(start):
            break
        kind, _, offset, _, _, length, _, _ = _PROGRAM.unpack_from(start, place)
        if kind == _INTERPRETER:
            interpreter = start[offset : offset + length].rstrip(b"\0")
    if not interpreter:
        return STATIC
    if b"musl" in interpreter:
        return MUSL
    if _GO in sections:
        return GO
    return ""
